#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tactile/capture/camera_source.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

/// An attribute of a stream's `info` that says what the vendor's own do not.
inline constexpr std::string_view readout_mode_attribute = "readoutMode";

std::optional<std::string> info_of(const Stream& stream, std::string_view key);
void set_info(Stream& stream, std::string_view key, std::string value);

/// What streams say of their camera, for run.json: `source`, and `readout_mode` where one names it.
nlohmann::json camera_json(std::span<const Stream> streams);

/// Holds a stream to times that never go back, as recordings must.
class AscendingTimes {
 public:
  /// Takes out of the packet whatever is earlier than an element before it, and adds it to `drops`.
  /// @throws Error  that begins with `name`, if an element is earlier by more than a second: the clock was set back. The packet
  ///                is then lost whole, and so counted.
  void keep(CameraPacket& packet, std::string_view name, SourceDrops& drops);

 private:
  std::optional<CameraTime> latest_;
};

}  // namespace tactile
