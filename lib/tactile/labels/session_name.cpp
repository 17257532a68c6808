#include "tactile/labels/session_name.hpp"

namespace tactile::labels {

std::optional<std::string> camera_session_of(const events::Stream& stream) {
  for (const auto& [name, value] : stream.info) {
    if (name == "tsOffset") return "camera started at " + value;
  }
  return std::nullopt;
}

}  // namespace tactile::labels
