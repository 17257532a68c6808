#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/capture/found_source.hpp"

namespace tactile {

/// Where sources are looked for.
struct SourcePlaces {
  std::filesystem::path sysfs = "/sys";
  std::filesystem::path devices = "/dev";
  std::string stream = "tcp://127.0.0.1:7777";     ///< where DV and scripts/dv-bridge serve a camera's events
  std::chrono::milliseconds stream_patience{300};  ///< for an answer from there
};

/// Cameras: those that libcaer opens, the vendor's others at the USB with how to reach them, and a stream that answers.
std::vector<FoundSource> find_camera_sources(const SourcePlaces& places = {});

/// Video devices that take pictures, in order of their numbers.
std::vector<FoundSource> find_video_devices(const SourcePlaces& places = {});

}  // namespace tactile
