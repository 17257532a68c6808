#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tactile/capture/camera_source.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::capture {

/// An attribute of a stream's `info` in addition to the vendor's.
inline constexpr std::string_view readout_mode_attribute = "readoutMode";

std::optional<std::string> info_of(const events::Stream& stream, std::string_view key);
void set_info(events::Stream& stream, std::string_view key, std::string value);

/// The camera of the streams, for run.json: `source`, and `readout_mode` if a stream names it.
nlohmann::json camera_json(std::span<const events::Stream> streams);

/// Keeps the times of a stream ascending, as recordings require.
class AscendingTimes {
 public:
  /// Removes elements from the packet that are earlier than a previous one, and adds them to `drops`.
  /// @throws Error  that begins with `name`, if an element is earlier by more than a second: the clock was set back. The whole
  ///                packet is then lost and counted
  void keep(CameraPacket& packet, std::string_view name, SourceDrops& drops);

 private:
  std::optional<CameraTime> latest_;
};

}  // namespace tactile::capture
