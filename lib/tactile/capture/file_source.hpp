#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tactile/capture/camera_source.hpp"

namespace tactile::capture {

/// Plays a recording at `options.speed`: all streams of one camera, merged in the order of their packets' times. Times stay as
/// they are stored. A packet is received when its last element is due, and spans less than `options.packet_span`.
/// @param name  the source as the user wrote it
/// @param path  an AEDAT4 or RAW file, or a run's folder
/// @throws Error  if it cannot be read, has no events, or has events of several cameras and `options.stream` names none
std::unique_ptr<CameraSource> open_file_source(std::string name, const std::filesystem::path& path,
                                               const CameraSourceOptions& options);

}  // namespace tactile::capture
