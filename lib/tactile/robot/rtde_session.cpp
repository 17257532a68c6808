#include "tactile/robot/rtde_session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace tactile::robot {
namespace {

using std::chrono::milliseconds;

constexpr double old_highest_hz = 125, highest_hz = 500;
constexpr std::uint32_t first_fast_version = 5;
constexpr milliseconds farewell_patience{100};

/// A controller's message in printable form.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return text;
}

std::string text_of(const RtdeText& message) {
  constexpr std::array<std::string_view, 4> levels{"exception", "error", "warning", "message"};
  const std::string_view level = levels[std::min<std::size_t>(message.level, 3)];
  const std::string source = message.source.empty() ? "" : printable(message.source) + ": ";
  return fmt::format("{} of the robot: {}{}", level, source, printable(message.text));
}

}  // namespace

RtdeSession::RtdeSession(const transport::NetworkAddress& address, milliseconds patience, Report report)
    : connection_(address, patience), patience_(patience), report_(std::move(report)), buffer_(std::size_t{1} << 16) {}

void RtdeSession::refuse(const std::string& what) const { throw Error(connection_.address().text() + ": " + what); }

void RtdeSession::send(const std::vector<std::byte>& package) { connection_.send(package, patience_); }

/// The controller's last message, to be put after a refusal.
std::string RtdeSession::last_words() const { return last_words_.empty() ? "" : " (" + last_words_ + ")"; }

/// Data of an earlier start may still arrive.
template <class Answer>
Answer RtdeSession::answer_to(RtdePackageType type, std::string_view what, Answer (*read)(std::span<const std::byte>)) {
  const auto deadline = std::chrono::steady_clock::now() + patience_;
  for (;;) {
    while (const auto package = next()) {
      if (package->type == type) return checked([&] { return read(package->payload); });
    }
    const auto left = std::chrono::ceil<milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left <= milliseconds(0)) {
      refuse(fmt::format("no answer to the {} within {} s; expected a UR controller's RTDE server", what,
                         static_cast<double>(patience_.count()) / 1e3));
    }
    receive(left);
  }
}

RtdeControllerVersion RtdeSession::greet() {
  send(rtde_protocol_version_request(rtde_protocol_version));
  if (!answer_to(RtdePackageType::protocol_version, "version request", accepted_in))
    refuse("the controller does not speak RTDE version 2; expected a UR controller that does");
  send(rtde_bare_request(RtdePackageType::controller_version));
  return answer_to(RtdePackageType::controller_version, "question for its version", controller_version_in);
}

RtdeFieldType RtdeSession::type_of(const std::string& name, const std::string& type) const {
  const auto known = rtde_field_type_called(type);
  if (!known) refuse(fmt::format("the controller gives '{}' the type '{}'; expected one of RTDE's", name, printable(type)));
  return *known;
}

RtdeAgreement RtdeSession::agree_on_inputs(const std::vector<std::string>& names) {
  RtdeAgreement agreed;
  agreed.version = greet();
  send(rtde_setup_inputs_request(names));
  const RtdeSetupReply reply = answer_to(RtdePackageType::setup_inputs, "request for inputs", setup_reply_in);
  for (std::size_t i = 0; i < std::min(names.size(), reply.types.size()); ++i) {
    if (reply.types[i] == "IN_USE")
      refuse(fmt::format("'{}' is written by another client of the controller; expected an input that is free", names[i]));
    if (reply.types[i] == "NOT_FOUND") {
      agreed.unknown.push_back(names[i]);
    } else {
      agreed.recipe.fields.push_back({names[i], type_of(names[i], reply.types[i])});
    }
  }
  agreed.recipe.id = reply.recipe_id;
  if (agreed.unknown.empty() && (reply.recipe_id == 0 || reply.types.size() != names.size()))
    refuse(fmt::format("the controller refuses {} inputs{}; expected it to accept them", names.size(), last_words()));
  return agreed;
}

void RtdeSession::write(const RtdeRecipe& recipe, std::span<const RtdeNumber> numbers, milliseconds patience) {
  connection_.send(rtde_data_package(recipe, numbers), patience);
}

RtdeAgreement RtdeSession::agree(const std::vector<std::string>& names, double frequency_hz) {
  RtdeAgreement agreed;
  agreed.version = greet();
  const double highest = agreed.version.major < first_fast_version ? old_highest_hz : highest_hz;
  agreed.frequency_hz = frequency_hz > 0 ? frequency_hz : highest;

  send(rtde_setup_outputs_request({agreed.frequency_hz, names}));
  const RtdeSetupReply reply = answer_to(RtdePackageType::setup_outputs, "request for outputs", setup_reply_in);
  if (reply.types.size() == names.size()) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (reply.types[i] == "NOT_FOUND") {
        agreed.unknown.push_back(names[i]);
      } else {
        agreed.recipe.fields.push_back({names[i], type_of(names[i], reply.types[i])});
      }
    }
  }
  agreed.recipe.id = reply.recipe_id;
  if (agreed.unknown.empty() && (reply.recipe_id == 0 || reply.types.size() != names.size())) {
    refuse(fmt::format("the controller refuses to send {} outputs at {} Hz; its version {} allows at most {} Hz{}", names.size(),
                       agreed.frequency_hz, text_of(agreed.version), highest, last_words()));
  }
  return agreed;
}

void RtdeSession::start() {
  send(rtde_bare_request(RtdePackageType::start));
  if (!answer_to(RtdePackageType::start, "request to start", accepted_in))
    refuse(fmt::format("the controller refuses to start sending{}; expected it to send", last_words()));
}

void RtdeSession::pause() {
  try {
    connection_.send(rtde_bare_request(RtdePackageType::pause), farewell_patience);
  } catch (const Error&) {  // it is being closed: the answer does not matter
  }
}

bool RtdeSession::receive(milliseconds patience) {
  const std::optional<std::size_t> got = connection_.receive(buffer_, patience);
  if (!got) refuse("the controller closed the connection");
  reassembly_.append(std::span<const std::byte>(buffer_).first(*got));
  return *got > 0;
}

std::optional<RtdePackage> RtdeSession::next() {
  for (;;) {
    const std::optional<RtdePackage> package = checked([&] { return reassembly_.next(); });
    if (!package || package->type != RtdePackageType::text) return package;
    last_words_ = text_of(checked([&] { return text_in(package->payload); }));
    report_(last_words_);
  }
}

}  // namespace tactile::robot
