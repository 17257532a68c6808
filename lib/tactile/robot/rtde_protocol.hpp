#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace tactile::robot {

// RTDE, protocol version 2, of a UR controller on TCP port 30004: a stream of packages, each a uint16 size that includes itself,
// a uint8 type and a payload; every number is big-endian. The packages of both sides are here, so that tests can simulate a
// controller. There are no sockets here. Source: UR's RTDE guide.

inline constexpr std::uint16_t rtde_protocol_version = 2;
inline constexpr std::size_t rtde_longest_field_list = 2'048;  ///< [bytes] of names, commas included

enum class RtdePackageType : std::uint8_t {
  protocol_version = 'V',
  controller_version = 'v',
  text = 'M',
  setup_outputs = 'O',
  setup_inputs = 'I',
  start = 'S',
  pause = 'P',
  data = 'U',
};

struct RtdePackage {
  RtdePackageType type{};
  std::span<const std::byte> payload;
};

/// Makes packages from the stream's bytes, in pieces of any size. Holds one package and the bytes after it.
class RtdeReassembly {
 public:
  void append(std::span<const std::byte> bytes);

  /// The next whole package, valid until the next call of any member; nothing if it has not arrived whole.
  /// @throws Error  if there is none: a size below that of its own header, or a type that RTDE does not have
  std::optional<RtdePackage> next();

 private:
  std::vector<std::byte> bytes_;
  std::size_t used_ = 0;
};

enum class RtdeFieldType : std::uint8_t {
  boolean,
  uint8,
  uint32,
  uint64,
  int32,
  real,
  vector3,
  vector6,
  vector6_int32,
  vector6_uint32
};

std::string_view name_of(RtdeFieldType type);                                ///< in the protocol: "VECTOR6D"
std::optional<RtdeFieldType> rtde_field_type_called(std::string_view name);  ///< nothing for "NOT_FOUND", "IN_USE" and the like
std::size_t numbers_in(RtdeFieldType type);                                  ///< 1, 3 or 6
std::size_t bytes_of(RtdeFieldType type);                                    ///< on the wire

struct RtdeField {
  std::string name;
  RtdeFieldType type{};
};

/// The fields of a data package, without padding.
struct RtdeRecipe {
  std::uint8_t id = 0;
  std::vector<RtdeField> fields;
};

/// The name of every number of a data package: the field's own, or with _0, _1, … where it is a vector.
std::vector<std::string> columns_of(const RtdeRecipe& recipe);

/// A boolean is 0 or 1.
using RtdeNumber = std::variant<std::uint64_t, std::int64_t, double>;
double as_double(const RtdeNumber& number);

struct RtdeControllerVersion {
  std::uint32_t major = 0, minor = 0, bugfix = 0, build = 0;
};
std::string text_of(const RtdeControllerVersion& version);  ///< "3.15.8.106339"

struct RtdeText {
  std::string text, source;
  std::uint8_t level = 3;  ///< 0 exception, 1 error, 2 warning, 3 information
};

struct RtdeOutputsRequest {
  double frequency_hz = 0;
  std::vector<std::string> names;
};

struct RtdeSetupReply {
  std::uint8_t recipe_id = 0;      ///< 0: refused
  std::vector<std::string> types;  ///< in the request's order
};

// What a client sends.
std::vector<std::byte> rtde_protocol_version_request(std::uint16_t version);
std::vector<std::byte> rtde_bare_request(RtdePackageType type);  ///< controller_version, start, pause
/// @throws Error  if the names are longer than `rtde_longest_field_list`, or one is empty or holds a comma
std::vector<std::byte> rtde_setup_outputs_request(const RtdeOutputsRequest& request);
/// @throws Error  under the same conditions
std::vector<std::byte> rtde_setup_inputs_request(const std::vector<std::string>& names);

// What either sends: a controller its outputs, a client the controller's inputs.
/// `numbers` as `columns_of` the recipe.
std::vector<std::byte> rtde_data_package(const RtdeRecipe& recipe, std::span<const RtdeNumber> numbers);

// What a controller sends.
std::vector<std::byte> rtde_accepted_reply(RtdePackageType type, bool accepted);  ///< protocol_version, start, pause
std::vector<std::byte> rtde_controller_version_reply(const RtdeControllerVersion& version);
std::vector<std::byte> rtde_setup_reply(RtdePackageType type, const RtdeSetupReply& reply);  ///< setup_outputs, setup_inputs
std::vector<std::byte> rtde_text_message(const RtdeText& message);                           ///< each text cut at 255 bytes

// Reads payloads. @throws Error  if the payload has not the size or form of its kind
std::uint16_t protocol_version_in(std::span<const std::byte> request);
bool accepted_in(std::span<const std::byte> reply);
RtdeControllerVersion controller_version_in(std::span<const std::byte> reply);
RtdeOutputsRequest outputs_request_in(std::span<const std::byte> request);
std::vector<std::string> inputs_request_in(std::span<const std::byte> request);
RtdeSetupReply setup_reply_in(std::span<const std::byte> reply);
RtdeText text_in(std::span<const std::byte> message);
/// Puts the numbers of a data package into `numbers`; false if it is another recipe's.
/// @throws Error  if its size is not the recipe's
bool read_rtde_data(const RtdeRecipe& recipe, std::span<const std::byte> payload, std::vector<RtdeNumber>& numbers);

}  // namespace tactile::robot
