#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/found_source.hpp"

namespace tactile::capture {

/// Whether the build has libcaer, the driver of the vendor's cameras.
bool is_built_with_libcaer();

/// A DVXplorer at the USB: events, IMU samples and, if it has an input, triggers. Its clock starts at the host time of the first
/// data, which is discarded.
/// @param name    the source as the user wrote it
/// @param serial  nothing: the only camera
/// @param mode    one of `readout_modes()`, or empty for the default
/// @throws Error  if there is no such camera, it cannot be opened, or libcaer does not support its firmware
std::unique_ptr<CameraSource> open_libcaer_camera(const std::string& name, const std::optional<std::string>& serial,
                                                  const std::string& mode);

/// The DVXplorers that `open_libcaer_camera` can open; none in a build without libcaer.
std::vector<FoundSource> find_libcaer_cameras();

/// From this firmware on, libcaer does not support a Mini.
inline constexpr int first_foreign_firmware = 10;

}  // namespace tactile::capture
