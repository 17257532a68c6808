#include "tactile/capture/robot_bit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::capture {

std::string RobotBit::text() const { return bit ? fmt::format("{}:{}", field, *bit) : field; }

bool RobotBit::is_high(double value) const {
  if (!std::isfinite(value)) return false;
  if (!bit) return value != 0;
  constexpr double beyond = 18446744073709551616.0;  // 2^64
  if (value >= beyond || value < -beyond / 2) return false;
  const std::uint64_t word =
      value < 0 ? static_cast<std::uint64_t>(static_cast<std::int64_t>(value)) : static_cast<std::uint64_t>(value);
  return (word >> *bit & 1U) != 0;
}

RobotBit robot_bit(std::string_view text) {
  const std::size_t colon = text.find(':');
  RobotBit bit{.field = std::string(text.substr(0, colon)), .bit = {}};
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  bool sound = !bit.field.empty() && std::all_of(bit.field.begin(), bit.field.end(), is_plain);
  if (colon != std::string_view::npos) {
    const auto number = whole_number_in(text.substr(colon + 1));
    sound = sound && number && *number >= 0 && *number <= 63;
    if (sound) bit.bit = static_cast<int>(*number);
  }
  if (!sound) {
    throw Error(
        fmt::format("'{}' is not a bit of the robot; expected an RTDE output such as output_bit_register_64, or a bit of one, "
                    "such as actual_digital_output_bits:3",
                    text));
  }
  return bit;
}

bool RisingEdge::rises(std::optional<bool> high) {
  if (!high) return false;
  const bool was_low = std::exchange(low_, !*high);
  return was_low && *high;
}

}  // namespace tactile::capture
