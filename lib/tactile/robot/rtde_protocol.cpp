#include "tactile/robot/rtde_protocol.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <concepts>

#include "tactile/core/error.hpp"

namespace tactile::robot {
namespace {

constexpr std::size_t header_size = 3;
constexpr std::size_t longest_package = 0xFFFF;

struct FieldTypeRow {
  RtdeFieldType type;
  std::string_view name;
  std::size_t numbers;
  std::size_t number_size;
};
constexpr std::array<FieldTypeRow, 10> field_types{{
    {RtdeFieldType::boolean, "BOOL", 1, 1},
    {RtdeFieldType::uint8, "UINT8", 1, 1},
    {RtdeFieldType::uint32, "UINT32", 1, 4},
    {RtdeFieldType::uint64, "UINT64", 1, 8},
    {RtdeFieldType::int32, "INT32", 1, 4},
    {RtdeFieldType::real, "DOUBLE", 1, 8},
    {RtdeFieldType::vector3, "VECTOR3D", 3, 8},
    {RtdeFieldType::vector6, "VECTOR6D", 6, 8},
    {RtdeFieldType::vector6_int32, "VECTOR6INT32", 6, 4},
    {RtdeFieldType::vector6_uint32, "VECTOR6UINT32", 6, 4},
}};

const FieldTypeRow& row_of(RtdeFieldType type) {
  const auto& row = field_types[static_cast<std::size_t>(type)];
  assert(row.type == type && "the table is in the enumeration's order");
  return row;
}

bool is_known(std::uint8_t type) {
  constexpr std::string_view types = "VvMOISPU";
  return types.find(static_cast<char>(type)) != std::string_view::npos;
}

template <std::unsigned_integral T>
void put(std::vector<std::byte>& bytes, T value) {
  for (std::size_t i = sizeof(T); i-- > 0;) bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}

void put(std::vector<std::byte>& bytes, std::string_view text) {
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
}

/// A package whose size is not known yet; `finished` puts it in.
std::vector<std::byte> package_of(RtdePackageType type) { return {std::byte{0}, std::byte{0}, static_cast<std::byte>(type)}; }

std::vector<std::byte> finished(std::vector<std::byte> package) {
  if (package.size() > longest_package)
    throw Error(fmt::format("an RTDE package of {} bytes; expected at most {}", package.size(), longest_package));
  package[0] = static_cast<std::byte>(package.size() >> 8);
  package[1] = static_cast<std::byte>(package.size() & 0xFF);
  return package;
}

std::string joined(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ",")); }

std::string checked_names(const std::vector<std::string>& names, std::string_view kind, std::string_view example) {
  for (const std::string& name : names) {
    if (name.empty() || name.find(',') != std::string::npos)
      throw Error(fmt::format("'{}' is no name of an RTDE {}; expected one such as {}", name, kind, example));
  }
  std::string text = joined(names);
  if (text.size() > rtde_longest_field_list) {
    throw Error(fmt::format("the {} names of the requested RTDE {}s are {} bytes long; expected at most {}", names.size(), kind,
                            text.size(), rtde_longest_field_list));
  }
  return text;
}

std::vector<std::string> parted(std::string_view text) {
  std::vector<std::string> names;
  if (text.empty()) return names;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(',', begin);
    names.emplace_back(text.substr(begin, end == std::string_view::npos ? end : end - begin));
    if (end == std::string_view::npos) return names;
    begin = end + 1;
  }
}

/// Reads a payload from its front, never beyond its end.
class Payload {
 public:
  Payload(std::string_view what, std::span<const std::byte> bytes) : what_(what), bytes_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    T value = 0;
    for (const std::byte byte : take(sizeof(T)))
      value = static_cast<T>(static_cast<std::uint64_t>(value) << 8 | std::to_integer<T>(byte));
    return value;
  }

  std::string text(std::size_t size) {
    const auto bytes = take(size);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  std::string rest() { return text(bytes_.size()); }

  void end() const {
    if (!bytes_.empty()) throw Error(fmt::format("{} with {} bytes too many; expected RTDE version 2", what_, bytes_.size()));
  }

 private:
  std::span<const std::byte> take(std::size_t size) {
    if (size > bytes_.size())
      throw Error(fmt::format("{} that ends too early: {} bytes are left instead of {}; expected RTDE version 2", what_,
                              bytes_.size(), size));
    const auto taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }

  std::string_view what_;
  std::span<const std::byte> bytes_;
};

}  // namespace

void RtdeReassembly::append(std::span<const std::byte> bytes) {
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(used_));
  used_ = 0;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::optional<RtdePackage> RtdeReassembly::next() {
  const auto left = std::span<const std::byte>(bytes_).subspan(used_);
  if (left.size() < 2) return std::nullopt;
  const std::size_t size = std::to_integer<std::size_t>(left[0]) << 8 | std::to_integer<std::size_t>(left[1]);
  if (size < header_size) throw Error(fmt::format("a package of {} bytes; expected RTDE, where none is shorter than 3", size));
  if (left.size() < header_size) return std::nullopt;
  const auto type = std::to_integer<std::uint8_t>(left[2]);
  if (!is_known(type)) throw Error(fmt::format("a package of type {}; expected one of RTDE's: V v M O I S P U", type));
  if (left.size() < size) return std::nullopt;
  used_ += size;
  return RtdePackage{static_cast<RtdePackageType>(type), left.first(size).subspan(header_size)};
}

std::string_view name_of(RtdeFieldType type) { return row_of(type).name; }

std::optional<RtdeFieldType> rtde_field_type_called(std::string_view name) {
  const auto found =
      std::find_if(field_types.begin(), field_types.end(), [&](const FieldTypeRow& row) { return row.name == name; });
  return found == field_types.end() ? std::nullopt : std::optional(found->type);
}

std::size_t numbers_in(RtdeFieldType type) { return row_of(type).numbers; }
std::size_t bytes_of(RtdeFieldType type) { return row_of(type).numbers * row_of(type).number_size; }

std::vector<std::string> columns_of(const RtdeRecipe& recipe) {
  std::vector<std::string> columns;
  for (const RtdeField& field : recipe.fields) {
    const std::size_t numbers = numbers_in(field.type);
    for (std::size_t i = 0; i < numbers; ++i) columns.push_back(numbers == 1 ? field.name : fmt::format("{}_{}", field.name, i));
  }
  return columns;
}

double as_double(const RtdeNumber& number) {
  return std::visit([](auto value) { return static_cast<double>(value); }, number);
}

std::string text_of(const RtdeControllerVersion& version) {
  return fmt::format("{}.{}.{}.{}", version.major, version.minor, version.bugfix, version.build);
}

std::vector<std::byte> rtde_protocol_version_request(std::uint16_t version) {
  auto package = package_of(RtdePackageType::protocol_version);
  put(package, version);
  return finished(std::move(package));
}

std::vector<std::byte> rtde_bare_request(RtdePackageType type) { return finished(package_of(type)); }

std::vector<std::byte> rtde_setup_outputs_request(const RtdeOutputsRequest& request) {
  const std::string names = checked_names(request.names, "output", "output_int_register_0");
  auto package = package_of(RtdePackageType::setup_outputs);
  put(package, std::bit_cast<std::uint64_t>(request.frequency_hz));
  put(package, names);
  return finished(std::move(package));
}

std::vector<std::byte> rtde_setup_inputs_request(const std::vector<std::string>& names) {
  const std::string joined_names = checked_names(names, "input", "input_bit_register_64");
  auto package = package_of(RtdePackageType::setup_inputs);
  put(package, joined_names);
  return finished(std::move(package));
}

std::vector<std::byte> rtde_accepted_reply(RtdePackageType type, bool accepted) {
  auto package = package_of(type);
  put(package, static_cast<std::uint8_t>(accepted ? 1 : 0));
  return finished(std::move(package));
}

std::vector<std::byte> rtde_controller_version_reply(const RtdeControllerVersion& version) {
  auto package = package_of(RtdePackageType::controller_version);
  for (const std::uint32_t part : {version.major, version.minor, version.bugfix, version.build}) put(package, part);
  return finished(std::move(package));
}

std::vector<std::byte> rtde_setup_reply(RtdePackageType type, const RtdeSetupReply& reply) {
  auto package = package_of(type);
  put(package, reply.recipe_id);
  put(package, joined(reply.types));
  return finished(std::move(package));
}

std::vector<std::byte> rtde_text_message(const RtdeText& message) {
  auto package = package_of(RtdePackageType::text);
  for (const std::string_view text : {std::string_view(message.text), std::string_view(message.source)}) {
    const std::string_view cut = text.substr(0, 255);
    put(package, static_cast<std::uint8_t>(cut.size()));
    put(package, cut);
  }
  put(package, message.level);
  return finished(std::move(package));
}

std::vector<std::byte> rtde_data_package(const RtdeRecipe& recipe, std::span<const RtdeNumber> numbers) {
  auto package = package_of(RtdePackageType::data);
  put(package, recipe.id);
  for (const RtdeField& field : recipe.fields) {
    const std::size_t count = numbers_in(field.type);
    assert(numbers.size() >= count && "a number for every column");
    for (const RtdeNumber& number : numbers.first(count)) {
      const auto whole = [&]() -> std::uint64_t {
        if (const auto* bits = std::get_if<std::uint64_t>(&number)) return *bits;
        if (const auto* signed_number = std::get_if<std::int64_t>(&number)) return static_cast<std::uint64_t>(*signed_number);
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::get<double>(number)));
      };
      switch (row_of(field.type).number_size) {
        case 1:
          put(package, static_cast<std::uint8_t>(whole()));
          break;
        case 4:
          put(package, static_cast<std::uint32_t>(whole()));
          break;
        default:
          put(package, field.type == RtdeFieldType::uint64 ? whole() : std::bit_cast<std::uint64_t>(as_double(number)));
      }
    }
    numbers = numbers.subspan(count);
  }
  return finished(std::move(package));
}

std::uint16_t protocol_version_in(std::span<const std::byte> request) {
  Payload payload("a protocol version", request);
  const auto version = payload.number<std::uint16_t>();
  payload.end();
  return version;
}

bool accepted_in(std::span<const std::byte> reply) {
  Payload payload("a yes or no", reply);
  const auto accepted = payload.number<std::uint8_t>();
  payload.end();
  return accepted != 0;
}

RtdeControllerVersion controller_version_in(std::span<const std::byte> reply) {
  Payload payload("a controller version", reply);
  RtdeControllerVersion version;
  for (std::uint32_t* part : {&version.major, &version.minor, &version.bugfix, &version.build}) {
    *part = payload.number<std::uint32_t>();
  }
  payload.end();
  return version;
}

RtdeOutputsRequest outputs_request_in(std::span<const std::byte> request) {
  Payload payload("a request for outputs", request);
  RtdeOutputsRequest outputs;
  outputs.frequency_hz = std::bit_cast<double>(payload.number<std::uint64_t>());
  outputs.names = parted(payload.rest());
  if (!outputs.names.empty() && outputs.names.back().empty()) outputs.names.pop_back();  // some clients end the list with a comma
  return outputs;
}

std::vector<std::string> inputs_request_in(std::span<const std::byte> request) {
  Payload payload("a request for inputs", request);
  std::vector<std::string> names = parted(payload.rest());
  if (!names.empty() && names.back().empty()) names.pop_back();
  return names;
}

RtdeSetupReply setup_reply_in(std::span<const std::byte> reply) {
  Payload payload("an answer to a set-up", reply);
  RtdeSetupReply setup;
  setup.recipe_id = payload.number<std::uint8_t>();
  setup.types = parted(payload.rest());
  return setup;
}

RtdeText text_in(std::span<const std::byte> message) {
  Payload payload("a text message", message);
  RtdeText text;
  text.text = payload.text(payload.number<std::uint8_t>());
  text.source = payload.text(payload.number<std::uint8_t>());
  text.level = payload.number<std::uint8_t>();
  payload.end();
  return text;
}

bool read_rtde_data(const RtdeRecipe& recipe, std::span<const std::byte> bytes, std::vector<RtdeNumber>& numbers) {
  numbers.clear();
  Payload payload("a data package", bytes);
  if (payload.number<std::uint8_t>() != recipe.id) return false;
  for (const RtdeField& field : recipe.fields) {
    for (std::size_t i = 0; i < numbers_in(field.type); ++i) {
      switch (field.type) {
        case RtdeFieldType::boolean:
          numbers.emplace_back(std::uint64_t{payload.number<std::uint8_t>() != 0 ? 1U : 0U});
          break;
        case RtdeFieldType::uint8:
          numbers.emplace_back(std::uint64_t{payload.number<std::uint8_t>()});
          break;
        case RtdeFieldType::uint32:
        case RtdeFieldType::vector6_uint32:
          numbers.emplace_back(std::uint64_t{payload.number<std::uint32_t>()});
          break;
        case RtdeFieldType::uint64:
          numbers.emplace_back(payload.number<std::uint64_t>());
          break;
        case RtdeFieldType::int32:
        case RtdeFieldType::vector6_int32:
          numbers.emplace_back(std::int64_t{static_cast<std::int32_t>(payload.number<std::uint32_t>())});
          break;
        case RtdeFieldType::real:
        case RtdeFieldType::vector3:
        case RtdeFieldType::vector6:
          numbers.emplace_back(std::bit_cast<double>(payload.number<std::uint64_t>()));
          break;
      }
    }
  }
  payload.end();
  return true;
}

}  // namespace tactile::robot
