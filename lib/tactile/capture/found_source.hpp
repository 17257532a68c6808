#pragma once

#include <string>

namespace tactile {

/// A source that is there to be opened.
struct FoundSource {
  std::string text;         ///< as it is opened: "camera:DXM00017", "/dev/video0"; empty if it cannot be from here
  std::string description;  ///< what it is, and where `text` is empty how to reach it
  std::string serial{};     ///< of a USB device, where it is known
};

}  // namespace tactile
