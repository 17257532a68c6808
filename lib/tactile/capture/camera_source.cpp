#include "tactile/capture/camera_source.hpp"

#include <filesystem>
#include <string_view>

#include "tactile/capture/file_source.hpp"
#include "tactile/capture/libcaer_camera.hpp"
#include "tactile/capture/network_source.hpp"
#include "tactile/capture/readout_mode.hpp"
#include "tactile/capture/simulator_source.hpp"
#include "tactile/core/error.hpp"
#include "tactile/transport/network_address.hpp"

namespace tactile::capture {
namespace {

/// The text after `kind` and a colon; nothing if `text` is only `kind`.
/// @throws Error  if there is nothing after the colon
std::optional<std::string> after_kind(const std::string& kind, const std::string& text) {
  if (text == kind) return std::nullopt;
  if (text.size() == kind.size() + 1) throw Error("'" + text + "': nothing follows the colon; expected a name, or no colon");
  return text.substr(kind.size() + 1);
}

bool is_kind(const std::string& kind, const std::string& text) { return text == kind || text.starts_with(kind + ":"); }

/// The address in `HOST:PORT` or `tcp:HOST:PORT`, as people write it; empty if there is none.
std::string address_in(std::string_view text) {
  for (const std::string_view begin : {"tcp:", "//"}) {
    if (text.starts_with(begin)) text.remove_prefix(begin.size());
  }
  if (text.find('/') != std::string_view::npos) return {};  // a path, or an address of another protocol
  const std::string address = "tcp://" + std::string(text);
  try {
    transport::network_address(address);
    return address;
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

LostElements count_of(const CameraPacket& packet) {
  return {.packets = 1,
          .events = packet.events.size(),
          .others = packet.imu.size() + packet.triggers.size() + (packet.frame ? 1 : 0)};
}

std::unique_ptr<CameraSource> open_camera_source(const std::string& text, const CameraSourceOptions& options) {
  const bool is_camera = is_kind("camera", text);
  if (!options.readout_mode.empty()) {
    readout_mode(options.readout_mode);
    if (!is_camera) throw Error(text + ": its read-out mode cannot be set here; expected one only for camera[:SERIAL]");
  }
  const bool is_network = text.starts_with("tcp://") || text.starts_with("unix:");
  if (!options.stream.empty() && (is_camera || is_network || is_kind("sim", text)))
    throw Error(text + ": has no choice of streams, but stream '" + options.stream +
                "' is given; expected one only for file:PATH");
  if (is_camera) return open_libcaer_camera(text, after_kind("camera", text), options.readout_mode);
  if (is_kind("sim", text)) return open_simulator_source(text, after_kind("sim", text), options.speed, options.seed);
  if (text.starts_with("file:")) {
    const auto path = after_kind("file", text);
    return open_file_source(text, path.value_or(""), options);
  }
  if (is_network) return open_network_source(text);
  std::error_code ignored;
  const bool is_path = std::filesystem::exists(text, ignored);
  const std::string address = address_in(text);
  throw Error("'" + text + "' is no source; expected " +
              (is_path            ? "file:" + text
               : !address.empty() ? address
                                  : "tcp://host:port, unix:PATH, file:PATH, sim[:OBJECT] or camera[:SERIAL]"));
}

}  // namespace tactile::capture
