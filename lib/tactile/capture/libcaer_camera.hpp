#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/found_source.hpp"

namespace tactile {

/// Whether the build found libcaer, the driver of the vendor's cameras.
bool is_built_with_libcaer();

/// A DVXplorer at the USB: events, what its inertial sensor feels, and where it has an input for them, signals. Its times are the
/// host's when its first data came, and from there on by its own clock; that data itself is thrown away.
/// @param name    the source as the user wrote it
/// @param serial  the only one there is, where it is not given
/// @param mode    one of `readout_modes()`, or empty for the default
/// @throws Error  if there is no such camera, it cannot be opened, or its firmware speaks a protocol that libcaer does not
std::unique_ptr<CameraSource> open_libcaer_camera(const std::string& name, const std::optional<std::string>& serial,
                                                  const std::string& mode);

/// The DVXplorers that `open_libcaer_camera` can open; none in a build without libcaer.
std::vector<FoundSource> find_libcaer_cameras();

/// From this firmware on a Mini speaks a protocol that libcaer does not know.
inline constexpr int first_foreign_firmware = 10;

}  // namespace tactile
