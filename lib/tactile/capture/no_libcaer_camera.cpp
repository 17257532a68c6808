// Replaces libcaer_camera.cpp in a build without libcaer.
#include "tactile/capture/dv_bridge.hpp"
#include "tactile/capture/libcaer_camera.hpp"
#include "tactile/core/error.hpp"

namespace tactile::capture {

bool is_built_with_libcaer() { return false; }

std::unique_ptr<CameraSource> open_libcaer_camera(const std::string& name, const std::optional<std::string>&,
                                                  const std::string&) {
  throw Error(name + ": this build has no libcaer; expected one that found it (3.3.14 or later), or the camera served by " +
              dv_bridge() + " and --from tcp://127.0.0.1:7777");
}

std::vector<FoundSource> find_libcaer_cameras() { return {}; }

}  // namespace tactile::capture
