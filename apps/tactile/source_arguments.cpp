#include "source_arguments.hpp"

#include <fmt/core.h>

#include <vector>

#include "tactile/capture/find_sources.hpp"
#include "tactile/core/error.hpp"

namespace tactile::cli {

std::string default_source(const std::string& command) {
  std::vector<std::string> cameras, streams;
  std::string out_of_reach;
  for (const capture::FoundSource& source : capture::find_camera_sources()) {
    if (source.text.empty()) {
      out_of_reach += "; " + source.description;
    } else {
      (source.text.starts_with("camera") ? cameras : streams).push_back(source.text);
    }
  }
  if (cameras.size() > 1) {
    std::string names;
    for (const std::string& camera : cameras) names += (names.empty() ? "" : ", ") + camera;
    throw Error(command + ": several cameras were found (" + names + "); expected --from with one of them");
  }
  if (!cameras.empty()) return cameras.front();
  if (!streams.empty()) return streams.front();
  throw Error(
      fmt::format("{}: found no camera that can be opened, and no stream at {}{}; expected one of them, or --from "
                  "tcp://HOST:PORT, unix:PATH, file:PATH, sim or camera:SERIAL",
                  command, capture::SourcePlaces{}.stream, out_of_reach));
}

transport::NetworkAddress robot_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::size_t bracket = text.rfind(']');
  const bool has_port = colon != std::string::npos && (bracket == std::string::npos ? text.find(':') == colon : colon > bracket);
  const bool is_bare_ipv6 = !has_port && colon != std::string::npos && bracket == std::string::npos;
  const std::string host = is_bare_ipv6 ? "[" + text + "]" : text;
  try {
    return transport::network_address("tcp://" + host + (has_port ? "" : ":30004"));
  } catch (const Error&) {
    throw Error("--robot '" + text + "': is no address; expected HOST or HOST:PORT with a port from 1 to 65535");
  }
}

}  // namespace tactile::cli
