#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "tactile/core/time.hpp"

namespace tactile {

/// What the skin feels. The values are those of labels in the dataset and of the network's outputs.
enum class Touch : std::uint8_t { none = 0, press = 1, slip = 2 };

inline constexpr std::size_t touch_count = 3;
inline constexpr std::array<Touch, touch_count> all_touches{Touch::none, Touch::press, Touch::slip};

std::string_view name_of(Touch touch);  ///< "none", "press", "slip"

/// @throws Error  if `name` is none of the three
Touch touch_named(std::string_view name);

/// A stretch of camera time with one touch. A tick is in it if `start < t_c <= end`.
struct TouchInterval {
  Touch touch = Touch::none;
  CameraTime start{};
  CameraTime end{};

  bool contains(CameraTime tick) const { return start < tick && tick <= end; }
};

}  // namespace tactile
