#pragma once

#include <memory>
#include <string>

#include "tactile/capture/camera_source.hpp"

namespace tactile::capture {

/// A DV stream from `tcp://host:port` or `unix:PATH`, one per connection. It ends when the server closes it.
/// @throws Error  if there is no such stream
std::unique_ptr<CameraSource> open_network_source(const std::string& address);

}  // namespace tactile::capture
