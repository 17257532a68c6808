#include "tactile/capture/libcaer_packets.hpp"

#include <algorithm>

namespace tactile::capture {
namespace {

/// The packet of a container that holds one type; nullptr if there is none.
caerEventPacketHeaderConst packet_of(caerEventPacketContainerConst container, std::int16_t type) {
  for (std::int32_t i = 0; i < caerEventPacketContainerGetEventPacketsNumber(container); ++i) {
    const caerEventPacketHeaderConst packet = caerEventPacketContainerGetEventPacketConst(container, i);
    if (packet != nullptr && caerEventPacketHeaderGetEventType(packet) == type) return packet;
  }
  return nullptr;
}

std::optional<std::int8_t> trigger_type(std::uint8_t special) {
  switch (special) {
    case EXTERNAL_INPUT_RISING_EDGE:
      return std::int8_t{1};
    case EXTERNAL_INPUT_FALLING_EDGE:
      return std::int8_t{2};
    case EXTERNAL_INPUT_PULSE:
      return std::int8_t{3};
    case EXTERNAL_GENERATOR_RISING_EDGE:
      return std::int8_t{4};
    case EXTERNAL_GENERATOR_FALLING_EDGE:
      return std::int8_t{5};
    default:
      return std::nullopt;
  }
}

CameraTime time_of(std::int64_t device_us, microseconds offset) { return after(camera_time(device_us), offset); }

}  // namespace

std::uint64_t append_events(caerPolarityEventPacketConst packet, microseconds offset, events::SensorSize size,
                            std::vector<events::Event>& events) {
  const std::int32_t count = caerEventPacketHeaderGetEventNumber(&packet->packetHeader);
  events.reserve(events.size() + static_cast<std::size_t>(std::max(count, 0)));
  std::uint64_t outside = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const caerPolarityEventConst event = caerPolarityEventPacketGetEventConst(packet, i);
    if (!caerPolarityEventIsValid(event)) continue;
    const int x = caerPolarityEventGetX(event), y = caerPolarityEventGetY(event);
    if (x >= size.width || y >= size.height) {
      ++outside;
      continue;
    }
    events.push_back({.t = time_of(caerPolarityEventGetTimestamp64(event, packet), offset),
                      .x = static_cast<std::int16_t>(x),
                      .y = static_cast<std::int16_t>(y),
                      .on = static_cast<std::uint8_t>(caerPolarityEventGetPolarity(event))});
  }
  return outside;
}

void append_imu(caerIMU6EventPacketConst packet, microseconds offset, std::vector<events::ImuSample>& samples) {
  const std::int32_t count = caerEventPacketHeaderGetEventNumber(&packet->packetHeader);
  for (std::int32_t i = 0; i < count; ++i) {
    const caerIMU6EventConst felt = caerIMU6EventPacketGetEventConst(packet, i);
    if (!caerIMU6EventIsValid(felt)) continue;
    events::ImuSample sample;
    sample.t = time_of(caerIMU6EventGetTimestamp64(felt, packet), offset);
    sample.temperature_c = caerIMU6EventGetTemp(felt);
    sample.acceleration_g[0] = caerIMU6EventGetAccelX(felt);
    sample.acceleration_g[1] = caerIMU6EventGetAccelY(felt);
    sample.acceleration_g[2] = caerIMU6EventGetAccelZ(felt);
    sample.angular_rate_dps[0] = caerIMU6EventGetGyroX(felt);
    sample.angular_rate_dps[1] = caerIMU6EventGetGyroY(felt);
    sample.angular_rate_dps[2] = caerIMU6EventGetGyroZ(felt);
    samples.push_back(sample);
  }
}

void append_triggers(caerSpecialEventPacketConst packet, microseconds offset, std::vector<events::Trigger>& triggers) {
  const std::int32_t count = caerEventPacketHeaderGetEventNumber(&packet->packetHeader);
  for (std::int32_t i = 0; i < count; ++i) {
    const caerSpecialEventConst special = caerSpecialEventPacketGetEventConst(packet, i);
    if (!caerSpecialEventIsValid(special)) continue;
    const std::optional<std::int8_t> type = trigger_type(caerSpecialEventGetType(special));
    if (type) triggers.push_back({.t = time_of(caerSpecialEventGetTimestamp64(special, packet), offset), .type = *type});
  }
}

bool has_timestamp_reset(caerEventPacketContainerConst container) {
  const caerEventPacketHeaderConst found = packet_of(container, SPECIAL_EVENT);
  if (found == nullptr) return false;
  const caerSpecialEventPacketConst packet = caerSpecialEventPacketFromPacketHeaderConst(found);
  return caerSpecialEventPacketFindValidEventByTypeConst(packet, TIMESTAMP_RESET) != nullptr;
}

std::optional<std::int64_t> lowest_device_time(caerEventPacketContainerConst container) {
  std::optional<std::int64_t> lowest;
  for (std::int32_t i = 0; i < caerEventPacketContainerGetEventPacketsNumber(container); ++i) {
    const caerEventPacketHeaderConst packet = caerEventPacketContainerGetEventPacketConst(container, i);
    if (packet == nullptr) continue;
    for (std::int32_t k = 0; k < caerEventPacketHeaderGetEventNumber(packet); ++k) {
      const void* element = caerGenericEventGetEvent(packet, k);
      if (!caerGenericEventIsValid(element)) continue;
      const std::int64_t t = caerGenericEventGetTimestamp64(element, packet);
      lowest = std::min(lowest.value_or(t), t);
    }
  }
  return lowest;
}

}  // namespace tactile::capture
