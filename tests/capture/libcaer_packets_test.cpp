#include "tactile/capture/libcaer_packets.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>

namespace tactile::capture {
namespace {

struct Free {
  void operator()(void* packet) const { std::free(packet); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

Owned<caer_polarity_event_packet> polarity_packet(std::int32_t capacity, std::int32_t overflow) {
  return Owned<caer_polarity_event_packet>(caerPolarityEventPacketAllocate(capacity, 1, overflow));
}

void add(caerPolarityEventPacket packet, std::int32_t index, std::int32_t t, std::uint16_t x, std::uint16_t y, bool on,
         bool is_valid = true) {
  const caerPolarityEvent event = caerPolarityEventPacketGetEvent(packet, index);
  caerPolarityEventSetTimestamp(event, t);
  caerPolarityEventSetX(event, x);
  caerPolarityEventSetY(event, y);
  caerPolarityEventSetPolarity(event, on);
  caerPolarityEventValidate(event, packet);
  if (!is_valid) caerPolarityEventInvalidate(event, packet);
}

Owned<caer_special_event_packet> special_packet(const std::vector<std::uint8_t>& types) {
  Owned<caer_special_event_packet> packet(caerSpecialEventPacketAllocate(static_cast<std::int32_t>(types.size()), 1, 0));
  for (std::size_t i = 0; i < types.size(); ++i) {
    const caerSpecialEvent event = caerSpecialEventPacketGetEvent(packet.get(), static_cast<std::int32_t>(i));
    caerSpecialEventSetTimestamp(event, static_cast<std::int32_t>(i));
    caerSpecialEventSetType(event, types[i]);
    caerSpecialEventValidate(event, packet.get());
  }
  return packet;
}

TEST(LibcaerPackets, KeepPlaceAndPolarityAndCountMicrosecondsBeyondThirtyOneBits) {
  const auto packet = polarity_packet(4, 2);
  add(packet.get(), 0, 5, 0, 0, false);
  add(packet.get(), 1, 5, 639, 479, true);
  add(packet.get(), 2, 6, 10, 20, true, false);
  add(packet.get(), 3, 7, 640, 20, true);
  std::vector<events::Event> events;
  EXPECT_EQ(append_events(packet.get(), microseconds{1'000}, {640, 480}, events), 1U) << "one lies outside";
  ASSERT_EQ(events.size(), 2U) << "the invalid one is left out too";
  const std::int64_t t = (std::int64_t{2} << 31) + 5 + 1'000;
  EXPECT_EQ(events[0], (events::Event{.t = camera_time(t), .x = 0, .y = 0, .on = 0}));
  EXPECT_EQ(events[1], (events::Event{.t = camera_time(t), .x = 639, .y = 479, .on = 1}));
}

TEST(LibcaerPackets, GiveSignalsTheTypesOfRecordings) {
  const auto packet =
      special_packet({EVENT_READOUT_START, EXTERNAL_INPUT_RISING_EDGE, EXTERNAL_INPUT_FALLING_EDGE, EXTERNAL_INPUT_PULSE,
                      EXTERNAL_GENERATOR_RISING_EDGE, EXTERNAL_GENERATOR_FALLING_EDGE, TIMESTAMP_WRAP});
  std::vector<events::Trigger> triggers;
  append_triggers(packet.get(), microseconds{100}, triggers);
  ASSERT_EQ(triggers.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(triggers[i].type, static_cast<std::int8_t>(i + 1));
    EXPECT_EQ(us_of(triggers[i].t), 101 + static_cast<std::int64_t>(i));
  }
}

TEST(LibcaerPackets, KeepWhatTheInertialSensorFelt) {
  const Owned<caer_imu6_event_packet> packet(caerIMU6EventPacketAllocate(2, 1, 0));
  const caerIMU6Event felt = caerIMU6EventPacketGetEvent(packet.get(), 0);
  caerIMU6EventSetTimestamp(felt, 77);
  caerIMU6EventSetTemp(felt, 31.5F);
  caerIMU6EventSetAccelX(felt, 0.1F);
  caerIMU6EventSetAccelY(felt, -0.9F);
  caerIMU6EventSetAccelZ(felt, 0.3F);
  caerIMU6EventSetGyroX(felt, 1.0F);
  caerIMU6EventSetGyroY(felt, 2.0F);
  caerIMU6EventSetGyroZ(felt, 3.0F);
  caerIMU6EventValidate(felt, packet.get());
  caerEventPacketHeaderSetEventNumber(&packet->packetHeader, 2);  // the second stays invalid
  std::vector<events::ImuSample> samples;
  append_imu(packet.get(), microseconds{-7}, samples);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(us_of(samples[0].t), 70);
  EXPECT_EQ(samples[0].temperature_c, 31.5F);
  EXPECT_EQ(samples[0].acceleration_g[1], -0.9F);
  EXPECT_EQ(samples[0].angular_rate_dps[2], 3.0F);
}

TEST(LibcaerPackets, ReportTheEarliestTimeOfAContainerAndAClockSetBack) {
  const std::unique_ptr<caer_event_packet_container, decltype(&caerEventPacketContainerFree)> container(
      caerEventPacketContainerAllocate(3), &caerEventPacketContainerFree);
  EXPECT_EQ(lowest_device_time(container.get()), std::nullopt);
  EXPECT_FALSE(has_timestamp_reset(container.get()));
  auto events = polarity_packet(2, 1);
  add(events.get(), 0, 40, 1, 1, true, false);
  add(events.get(), 1, 50, 1, 1, true);
  caerEventPacketContainerSetEventPacket(container.get(), 1, &events.release()->packetHeader);
  EXPECT_EQ(lowest_device_time(container.get()), (std::int64_t{1} << 31) + 50);
  caerEventPacketContainerSetEventPacket(container.get(), 0, &special_packet({EVENT_READOUT_START}).release()->packetHeader);
  EXPECT_FALSE(has_timestamp_reset(container.get()));
  EXPECT_EQ(lowest_device_time(container.get()), 0) << "packets of every type count";
}

TEST(LibcaerPackets, KnowAClockThatWasSetBack) {
  const std::unique_ptr<caer_event_packet_container, decltype(&caerEventPacketContainerFree)> container(
      caerEventPacketContainerAllocate(1), &caerEventPacketContainerFree);
  caerEventPacketContainerSetEventPacket(container.get(), 0, &special_packet({TIMESTAMP_RESET}).release()->packetHeader);
  EXPECT_TRUE(has_timestamp_reset(container.get()));
}

}  // namespace
}  // namespace tactile::capture
