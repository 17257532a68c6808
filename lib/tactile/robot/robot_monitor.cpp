#include "tactile/robot/robot_monitor.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/robot/growing_log.hpp"
#include "tactile/robot/repeated_messages.hpp"
#include "tactile/robot/rtde_protocol.hpp"
#include "tactile/robot/rtde_session.hpp"

namespace tactile::robot {
namespace {

using std::chrono::milliseconds;

constexpr std::array<std::string_view, 3> needed_fields{"timestamp", "actual_TCP_pose", "actual_TCP_speed"};
constexpr std::array<std::string_view, 18> usual_fields{"timestamp",
                                                        "target_q",
                                                        "actual_q",
                                                        "actual_qd",
                                                        "actual_TCP_pose",
                                                        "actual_TCP_speed",
                                                        "actual_TCP_force",
                                                        "actual_tool_accelerometer",
                                                        "speed_scaling",
                                                        "runtime_state",
                                                        "robot_mode",
                                                        "safety_mode",
                                                        "safety_status",
                                                        "actual_digital_input_bits",
                                                        "actual_digital_output_bits",
                                                        "output_bit_registers0_to_31",
                                                        "output_bit_registers32_to_63",
                                                        "output_int_register_0"};
constexpr std::string_view usual_register = "output_double_register_0";

constexpr milliseconds attempt_patience{2'000};
constexpr milliseconds wake_every{100};

/// If robot and host disagree by more about the length of a lost connection, the controller's clock has restarted.
constexpr double longest_clock_disagreement_s = 1.0;
constexpr double latest_timestamp_s = 1e12;  // what `read_robot_log` takes

/// At the two ends of a log there is no second package that shows a gap: a silence of this length is one.
constexpr double longest_silence_s = 1.0;

std::vector<std::string> wanted_fields(const RobotMonitorOptions& options) {
  std::vector<std::string> names(usual_fields.begin(), usual_fields.end());
  names.emplace_back(usual_register);
  for (const auto* more : {&options.extra_fields, &options.required_fields}) {
    for (const std::string& name : *more) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

bool same_fields(const RtdeRecipe& a, const RtdeRecipe& b) {
  return std::equal(a.fields.begin(), a.fields.end(), b.fields.begin(), b.fields.end(),
                    [](const RtdeField& x, const RtdeField& y) { return x.name == y.name && x.type == y.type; });
}

}  // namespace

struct RobotMonitor::State {
  RobotMonitorOptions options;
  transport::NetworkAddress address;
  std::vector<std::string> fields;   ///< the requested ones that the controller has
  std::vector<std::string> columns;  ///< of a data package
  std::size_t time_column = 0;
  std::vector<std::size_t> needed_columns;
  // The next four are used by the monitor's thread only, once that runs.
  std::unique_ptr<RtdeSession> session;
  RtdeRecipe recipe;
  bool reported_bad_numbers = false;
  RepeatedMessages messages{[this](const std::string& text) { report(text); }};

  mutable std::mutex mutex;  ///< guards all that follows
  std::condition_variable woken;
  bool stopping = false;
  RobotMonitorState shown;
  double period_s = 0;
  std::vector<RtdeNumber> newest;
  std::deque<HostTime> arrivals;  ///< of the last second
  std::unique_ptr<GrowingLog> log;
  std::optional<double> last_timestamp;  ///< in any log or in none
  HostTime last_arrival{};
  ClockPairs<RobotClock> clock;  ///< since the log began or the controller's clock restarted
  bool was_lost = false;         ///< the connection, since then
  HostTime log_begun{};
  bool log_has_rows = false;
  bool gap_is_counted = false;  ///< the present one; an empty line marks it, but not before the first row
  std::string line;

  std::thread thread;

  void report(const std::string& text) const {
    if (options.log) options.log(text);
  }

  void take(const RtdeAgreement& agreed);
  void first_connection();
  void connect_again();
  void lose_connection();
  void take_package(const RtdePackage& package, HostTime arrival);
  void log_numbers(const std::vector<RtdeNumber>& numbers, HostTime arrival, bool restarted);
  void count_gap_at_end(HostTime now);
  std::uint64_t packages_in(double seconds) const { return static_cast<std::uint64_t>(std::llround(seconds / period_s)); }
  void run();
};

void RobotMonitor::State::take(const RtdeAgreement& agreed) {
  recipe = agreed.recipe;
  const std::lock_guard lock(mutex);
  shown.connected = true;
  shown.controller = text_of(agreed.version);
  period_s = 1.0 / agreed.frequency_hz;
}

void RobotMonitor::State::first_connection() {
  if (!(options.frequency_hz >= 0 && std::isfinite(options.frequency_hz)))
    throw Error(fmt::format("a robot frequency of {} Hz; expected more than 0, or 0 for the highest", options.frequency_hz));
  address = {.kind = transport::NetworkAddress::Kind::tcp, .host = options.host, .port = options.port, .path = {}};
  const auto report_once = [this](const std::string& text) { messages.hear(text); };

  fields = wanted_fields(options);
  session = std::make_unique<RtdeSession>(address, options.patience, report_once);
  RtdeAgreement agreed = session->agree(fields, options.frequency_hz);
  if (!agreed.unknown.empty()) {
    for (const std::string_view needed : needed_fields) {
      if (std::find(agreed.unknown.begin(), agreed.unknown.end(), needed) != agreed.unknown.end()) {
        throw Error(fmt::format("{}: the controller has no output '{}' (version {}); expected a UR controller's RTDE outputs",
                                address.text(), needed, text_of(agreed.version)));
      }
    }
    for (const std::string& required : options.required_fields) {
      if (std::find(agreed.unknown.begin(), agreed.unknown.end(), required) != agreed.unknown.end()) {
        throw Error(fmt::format("{}: the controller has no output '{}' (version {}); expected one of its RTDE outputs",
                                address.text(), required, text_of(agreed.version)));
      }
    }
    report(fmt::format("the robot has no {}: the log does not contain it", fmt::join(agreed.unknown, ", ")));
    std::erase_if(fields, [&](const std::string& name) {
      return std::find(agreed.unknown.begin(), agreed.unknown.end(), name) != agreed.unknown.end();
    });
    // Controllers differ in what a second request on the same connection does.
    session = std::make_unique<RtdeSession>(address, options.patience, report_once);
    agreed = session->agree(fields, options.frequency_hz);
    if (!agreed.unknown.empty())
      throw Error(fmt::format("{}: the controller no longer has {}; expected the same answer as before", address.text(),
                              fmt::join(agreed.unknown, ", ")));
  }

  columns = columns_of(agreed.recipe);
  for (const RtdeField& field : agreed.recipe.fields) {
    const RtdeFieldType right = field.name == "timestamp" ? RtdeFieldType::real : RtdeFieldType::vector6;
    const bool is_needed = std::find(needed_fields.begin(), needed_fields.end(), field.name) != needed_fields.end();
    if (is_needed && field.type != right) {
      throw Error(fmt::format("{}: the controller's output '{}' is of type {}; expected {}", address.text(), field.name,
                              name_of(field.type), name_of(right)));
    }
    if (numbers_in(field.type) > 1 &&
        std::find(options.required_fields.begin(), options.required_fields.end(), field.name) != options.required_fields.end()) {
      throw Error(fmt::format("{}: the controller's output '{}' is a {}; expected an output of one number", address.text(),
                              field.name, name_of(field.type)));
    }
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string& name = columns[i];
    if (name == "timestamp") time_column = i;
    if (name == "timestamp" || name.starts_with("actual_TCP_pose_") || name.starts_with("actual_TCP_speed_"))
      needed_columns.push_back(i);
  }
  session->start();
  take(agreed);
}

void RobotMonitor::State::connect_again() {
  const HostTime lost_at = host_now();
  milliseconds pause = shortest_pause;
  std::string last_reason;
  for (;;) {
    {
      std::unique_lock lock(mutex);
      if (woken.wait_for(lock, pause, [&] { return stopping; })) return;
    }
    pause = std::min(2 * pause, longest_pause);
    try {
      session = std::make_unique<RtdeSession>(address, std::min(options.patience, attempt_patience),
                                              [this](const std::string& text) { messages.hear(text); });
      const RtdeAgreement agreed = session->agree(fields, options.frequency_hz);
      if (!agreed.unknown.empty() || !same_fields(agreed.recipe, recipe))
        throw Error(address.text() + ": the controller offers other outputs than before; expected the same as at the start");
      session->start();
      take(agreed);
      break;
    } catch (const Error& e) {
      session.reset();
      if (last_reason != e.what()) {
        last_reason = e.what();
        report(fmt::format("robot still gone ({})", last_reason));
      }
    }
  }
  {
    const std::lock_guard lock(mutex);
    ++shown.reconnects;
  }
  report(fmt::format("robot is back after {:.1f} s", static_cast<double>((host_now() - lost_at).count()) / 1e6));
}

void RobotMonitor::State::lose_connection() {
  session.reset();
  reported_bad_numbers = false;
  const std::lock_guard lock(mutex);
  shown.connected = false;
  newest.clear();
  arrivals.clear();
  was_lost = true;
  if (log && !gap_is_counted) {
    if (log_has_rows) log->append("\n");
    gap_is_counted = true;
    ++shown.gaps;
  }
}

void RobotMonitor::State::log_numbers(const std::vector<RtdeNumber>& numbers, HostTime arrival, bool restarted) {
  line.clear();
  if (log_has_rows) {
    const double step = as_double(numbers[time_column]) - *last_timestamp;
    if (restarted && !gap_is_counted) line += '\n';
    const bool is_gap = restarted || step > 1.5 * period_s;
    if (is_gap && !gap_is_counted) ++shown.gaps;
    if (is_gap && !restarted) shown.missing += static_cast<std::uint64_t>(std::max(1.0, std::round(step / period_s)) - 1.0);
  } else if (const double silence = in_s(arrival - log_begun); gap_is_counted || silence > longest_silence_s) {
    if (!gap_is_counted) ++shown.gaps;
    shown.missing += packages_in(silence);
  }
  for (const RtdeNumber& number : numbers) {
    std::visit([&](auto value) { fmt::format_to(std::back_inserter(line), "{},", value); }, number);
  }
  fmt::format_to(std::back_inserter(line), "{}\n", us_of(arrival));
  log->append(line);
  log_has_rows = true;
  gap_is_counted = false;
}

/// A log that ends while the robot is gone, or that has no package, lacks packages that no later one shows.
void RobotMonitor::State::count_gap_at_end(HostTime now) {
  const double silence = in_s(now - (log_has_rows ? last_arrival : log_begun));
  if (shown.connected && log_has_rows && silence <= longest_silence_s) return;
  if (!gap_is_counted) ++shown.gaps;
  shown.missing += packages_in(silence);
}

void RobotMonitor::State::take_package(const RtdePackage& package, HostTime arrival) {
  if (package.type != RtdePackageType::data) return;
  std::vector<RtdeNumber> numbers;
  if (!session->checked([&] { return read_rtde_data(recipe, package.payload, numbers); })) return;
  const bool usable = std::all_of(needed_columns.begin(), needed_columns.end(), [&](std::size_t i) {
    const double number = as_double(numbers[i]);
    return std::isfinite(number) && (i != time_column || std::abs(number) <= latest_timestamp_s);
  });
  if (!usable) {  // a row that no reader accepts would make the whole log unreadable
    if (!std::exchange(reported_bad_numbers, true))
      report("the robot sends times, poses or speeds that are not finite numbers: such rows are left out");
    return;
  }
  const std::lock_guard lock(mutex);
  newest = std::move(numbers);
  arrivals.push_back(arrival);
  while (arrivals.front() <= arrival - 1s) arrivals.pop_front();

  const double timestamp = as_double(newest[time_column]);
  bool restarted = false;
  if (last_timestamp) {
    const double step = timestamp - *last_timestamp;
    restarted = step < 0 || (was_lost && std::abs(step - in_s(arrival - last_arrival)) > longest_clock_disagreement_s);
  }
  if (restarted) {
    ++shown.clock_starts;
    clock = ClockPairs<RobotClock>();
  }
  clock.add({RobotTime{microseconds{std::llround(timestamp * 1e6)}}, arrival});
  if (log) log_numbers(newest, arrival, restarted);
  last_timestamp = timestamp;
  last_arrival = arrival;
  was_lost = false;
}

void RobotMonitor::State::run() {
  HostTime heard = host_now();
  for (;;) {
    {
      const std::lock_guard lock(mutex);
      if (stopping) break;
    }
    messages.forget_old();
    if (!session) {
      connect_again();
      heard = host_now();
      continue;
    }
    try {
      if (session->receive(wake_every)) {
        const HostTime arrival = host_now();
        heard = arrival;
        while (const auto package = session->next()) take_package(*package, arrival);
      } else if (host_now() - heard > options.patience) {
        throw Error(fmt::format("{}: no data for {} s", address.text(), static_cast<double>(options.patience.count()) / 1e3));
      }
    } catch (const Error& e) {
      lose_connection();
      report(fmt::format("robot gone ({}), trying again", e.what()));
    }
  }
  if (session) session->pause();
  messages.forget_all();
}

RobotMonitor::RobotMonitor(RobotMonitorOptions options) : state_(std::make_unique<State>()) {
  state_->options = std::move(options);
  state_->first_connection();
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

RobotMonitor::~RobotMonitor() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->woken.notify_all();
  state_->thread.join();
}

void RobotMonitor::start_log(const std::filesystem::path& file) {
  const auto refuse_second = [&] {
    if (state_->log) throw Error(file.string() + ": a log is already being written; stop it first");
  };
  {
    const std::lock_guard lock(state_->mutex);
    refuse_second();
  }
  std::string header;
  for (const std::string& column : state_->columns) header += column + ",";
  auto log = std::make_unique<GrowingLog>(file, header + "host_time_us");
  const std::lock_guard lock(state_->mutex);
  refuse_second();
  state_->log = std::move(log);
  state_->log_begun = host_now();
  state_->log_has_rows = false;
  state_->clock = ClockPairs<RobotClock>();
  state_->gap_is_counted = !state_->shown.connected;
  state_->shown.rows = state_->shown.missing = 0;
  state_->shown.gaps = state_->gap_is_counted ? 1 : 0;
  state_->shown.error.clear();
}

void RobotMonitor::stop_log() {
  std::unique_ptr<GrowingLog> log;
  {
    const std::lock_guard lock(state_->mutex);
    log = std::move(state_->log);
    if (log) state_->count_gap_at_end(host_now());
  }
  if (!log) return;
  std::string error;
  try {
    log->close();
  } catch (const Error& e) {
    error = e.what();
  }
  {
    const std::lock_guard lock(state_->mutex);
    state_->shown.rows = log->rows();
    state_->shown.error = error;
  }
  if (!error.empty()) throw Error(error);
}

RobotMonitorState RobotMonitor::state() const {
  const std::lock_guard lock(state_->mutex);
  RobotMonitorState shown = state_->shown;
  const HostTime second_ago = host_now() - 1s;
  shown.rate_hz = static_cast<double>(
      std::count_if(state_->arrivals.begin(), state_->arrivals.end(), [&](HostTime arrival) { return arrival > second_ago; }));
  shown.clock = state_->clock.offset();
  if (state_->log) {
    shown.rows = state_->log->rows();
    shown.error = state_->log->error();
  }
  return shown;
}

std::optional<double> RobotMonitor::newest(const std::string& field) const {
  const auto column = std::find(state_->columns.begin(), state_->columns.end(), field);
  if (column == state_->columns.end())
    throw Error(fmt::format("the robot sends no '{}'; expected a requested RTDE output of one number", field));
  const std::lock_guard lock(state_->mutex);
  if (!state_->shown.connected || state_->newest.empty()) return std::nullopt;
  return as_double(state_->newest[static_cast<std::size_t>(column - state_->columns.begin())]);
}

}  // namespace tactile::robot
