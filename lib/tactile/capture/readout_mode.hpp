#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace tactile {

/// How a DVXplorer reads its pixels out, and the chip's settings for it.
struct ReadoutMode {
  std::string_view name;
  bool fixed_read_time = false;   ///< every read-out takes `read_cycles`, however many pixels have events
  std::uint32_t wait_us = 0;      ///< exposure between two read-outs
  std::uint32_t next_select = 0;  ///< cycles from one column to the next
  std::uint32_t read_cycles = 0;  ///< of 20 ns, where it is fixed
};

/// "constant-N": N read-outs a second, whole ones; "lossy-N": likewise, but a read-out that does not get through in its time
/// loses what is left; "variable-N": up to N a second, fewer when much moves. Source: dv-processing's presets of the DVXplorer.
std::span<const ReadoutMode> readout_modes();

inline constexpr std::string_view default_readout_mode = "variable-5000";

/// @throws Error  that lists them if none has this name
const ReadoutMode& readout_mode(std::string_view name);

}  // namespace tactile
