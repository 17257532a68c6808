#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace tactile::capture {

/// A read-out mode of the DVXplorer, with the chip's settings.
struct ReadoutMode {
  std::string_view name;
  bool fixed_read_time = false;   ///< every read-out takes `read_cycles`, for any number of events
  std::uint32_t wait_us = 0;      ///< exposure between two read-outs
  std::uint32_t next_select = 0;  ///< cycles from one column to the next
  std::uint32_t read_cycles = 0;  ///< of 20 ns, with `fixed_read_time`
};

/// "constant-N": N complete read-outs per second. "lossy-N": N per second, and a read-out that takes too long loses its rest.
/// "variable-N": up to N per second, fewer if there are many events. Source: dv-processing's presets of the DVXplorer.
std::span<const ReadoutMode> readout_modes();

inline constexpr std::string_view default_readout_mode = "variable-5000";

/// @throws Error  with a list of all names, if none has this name
const ReadoutMode& readout_mode(std::string_view name);

}  // namespace tactile::capture
