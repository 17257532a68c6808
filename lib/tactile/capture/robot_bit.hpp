#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tactile {

/// A truth that the robot tells: a BOOL, a whole number that is not 0, or one bit of it.
struct RobotBit {
  std::string field;       ///< RTDE's name, "output_bit_register_64", "actual_digital_output_bits"
  std::optional<int> bit;  ///< 0 to 63; the whole field if there is none

  std::string text() const;          ///< as it is written: "actual_digital_output_bits:3"
  bool is_high(double value) const;  ///< of the field's value
};

/// @throws Error  if `text` is neither an RTDE output's name nor one with `:BIT` behind it, BIT from 0 to 63
RobotBit robot_bit(std::string_view text);

/// Tells when a bit rises: high now, and low when it was last known. A bit that is high at first must fall before it can rise.
class RisingEdge {
 public:
  bool rises(std::optional<bool> high);  ///< nothing while the robot cannot be asked

 private:
  bool low_ = false;
};

}  // namespace tactile
