#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tactile/bags/ros_fields.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/evt3.hpp"

// Decoders for the messages with events. They check every length before use. They fail if the bytes are not such a message, or
// have more than 8 million events.
namespace tactile::bags {

/// The events of a message, in its order.
struct RosEvents {
  events::SensorSize size;
  std::vector<events::Event> events;
  std::vector<events::Evt3Trigger> triggers;  ///< of `evt3` alone
  std::uint64_t outside = 0;                  ///< events outside the sensor; dropped
  std::uint64_t unplaced = 0;                 ///< events before the first time and row of `evt3`; dropped
  std::uint64_t lost_packets = 0;             ///< missing before this EventPacket: sequence numbers rise by one
  std::string encoding;                       ///< of an EventPacket
};

/// Reads the sensor's size, which messages give as height, then width. @return  false if that is no size of a sensor
bool take_size(RosFields& fields, events::SensorSize& size);

/// dvs_msgs/EventArray.
bool decode_event_array(SerialisedMessage message, RosEvents& into);

enum class PacketDecoding : std::uint8_t { whole, broken, other_encoding };

/// Decodes event_camera_msgs/EventPacket of one topic, in the order in which they were sent: `evt3` keeps its state from packet
/// to packet, and its times are the camera's own. In `libcaer`, `libcaer_cmp` and `mono`, times count from the packet's base.
class EventPacketDecoder {
 public:
  /// Of a packet in another encoding, or with big-endian numbers, only the part up to `encoding` is decoded.
  PacketDecoding decode(SerialisedMessage message, RosEvents& into);

 private:
  bool decode_evt3(std::span<const std::byte> data, RosEvents& into);

  std::optional<std::uint64_t> sequence_;
  std::optional<events::Evt3Decoder> evt3_;
  events::SensorSize evt3_size_;
};

}  // namespace tactile::bags
