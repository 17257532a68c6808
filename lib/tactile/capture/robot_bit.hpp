#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tactile::capture {

/// A condition of the robot: a BOOL, a whole number other than 0, or one bit of it.
struct RobotBit {
  std::string field;       ///< name in RTDE: "output_bit_register_64", "actual_digital_output_bits"
  std::optional<int> bit;  ///< 0 to 63; the whole field if there is none

  std::string text() const;          ///< as a user writes it: "actual_digital_output_bits:3"
  bool is_high(double value) const;  ///< of the field's value
};

/// @throws Error  if `text` is not the name of an RTDE output, with or without `:BIT` from 0 to 63
RobotBit robot_bit(std::string_view text);

/// Detects when a bit rises: it is high now, and was low when last known. A bit that is high at first must fall before it can
/// rise.
class RisingEdge {
 public:
  bool rises(std::optional<bool> high);  ///< nothing while the robot is not connected

 private:
  bool low_ = false;
};

}  // namespace tactile::capture
