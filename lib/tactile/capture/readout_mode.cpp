#include "tactile/capture/readout_mode.hpp"

#include <array>
#include <string>

#include "tactile/core/error.hpp"

namespace tactile::capture {

std::span<const ReadoutMode> readout_modes() {
  static constexpr std::array modes{
      ReadoutMode{"constant-100", true, 9100, 15, 45000}, ReadoutMode{"constant-200", true, 4100, 15, 45000},
      ReadoutMode{"constant-500", true, 1100, 15, 45000}, ReadoutMode{"constant-1000", true, 100, 15, 45000},
      ReadoutMode{"lossy-2000", true, 1, 5, 25000},       ReadoutMode{"lossy-5000", true, 1, 5, 10000},
      ReadoutMode{"lossy-10000", true, 1, 5, 5000},       ReadoutMode{"variable-2000", false, 307, 15, 0},
      ReadoutMode{"variable-5000", false, 7, 15, 0},      ReadoutMode{"variable-10000", false, 10, 7, 0},
      ReadoutMode{"variable-15000", false, 1, 5, 0},
  };
  return modes;
}

const ReadoutMode& readout_mode(std::string_view name) {
  std::string list;
  for (const ReadoutMode& mode : readout_modes()) {
    if (mode.name == name) return mode;
    list += (list.empty() ? "" : ", ") + std::string(mode.name);
  }
  throw Error("read-out mode: '" + std::string(name) + "' is unknown; expected one of " + list);
}

}  // namespace tactile::capture
