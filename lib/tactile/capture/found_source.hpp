#pragma once

#include <string>

namespace tactile::capture {

/// A source that was found.
struct FoundSource {
  std::string text;         ///< for `--from` or `--video`: "camera:DXM00017", "/dev/video0"; empty if it cannot be opened here
  std::string description;  ///< what it is, and how to use it if `text` is empty
  std::string serial{};     ///< of a USB device, if known
};

}  // namespace tactile::capture
