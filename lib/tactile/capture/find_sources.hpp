#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/capture/found_source.hpp"

namespace tactile::capture {

/// Where to look for sources.
struct SourcePlaces {
  std::filesystem::path sysfs = "/sys";
  std::filesystem::path devices = "/dev";
  std::string stream = "tcp://127.0.0.1:7777";     ///< where DV and scripts/dv-bridge serve a camera's events
  std::chrono::milliseconds stream_patience{300};  ///< wait this long for an answer from there
};

/// Cameras that libcaer can open, the vendor's other cameras at the USB with a way to use them, and a stream that answers.
std::vector<FoundSource> find_camera_sources(const SourcePlaces& places = {});

/// Video devices that take pictures, by number.
std::vector<FoundSource> find_video_devices(const SourcePlaces& places = {});

}  // namespace tactile::capture
