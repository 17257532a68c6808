#include "tactile/bags/ros_events.hpp"

#include <gtest/gtest.h>

#include <string>

namespace tactile::bags {
namespace {

std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}
std::string u16(std::uint64_t value) { return little_endian(value, 2); }
std::string u32(std::uint64_t value) { return little_endian(value, 4); }
std::string u64(std::uint64_t value) { return little_endian(value, 8); }
std::string text(const std::string& value) { return u32(value.size()) + value; }
std::string header(std::uint32_t seconds, std::uint32_t nanoseconds, const std::string& frame = "") {
  return u32(7) + u32(seconds) + u32(nanoseconds) + text(frame);
}
std::span<const std::byte> bytes_of(const std::string& message) { return std::as_bytes(std::span(message)); }

std::string event_packet(const std::string& encoding, std::uint64_t base_ns, const std::string& data,
                         bool is_big_endian = false) {
  return header(1, 0) + u32(480) + u32(640) + u64(12) + u64(base_ns) + text(encoding) +
         std::string(1, is_big_endian ? '\1' : '\0') + text(data);
}
std::vector<events::Event> events_in(const std::string& packet) {
  RosEvents events;
  EXPECT_EQ(EventPacketDecoder().decode(bytes_of(packet), events), PacketDecoding::whole);
  return events.events;
}
events::Event event(std::int64_t t_us, int x, int y, int on) {
  events::Event made{.t = camera_time(t_us), .x = static_cast<std::int16_t>(x), .y = static_cast<std::int16_t>(y)};
  made.on = static_cast<std::uint8_t>(on);
  return made;
}

TEST(DecodeEventArray, ReadsEveryFieldAndDropsWhatLiesOutside) {
  const std::string message = header(1, 0) + u32(480) + u32(640) + u32(3) +                //
                              u16(639) + u16(479) + u32(1700) + u32(999'999'999) + '\1' +  //
                              u16(640) + u16(0) + u32(1700) + u32(0) + '\1' +              //
                              u16(0) + u16(1) + u32(1701) + u32(1'000) + '\0';
  RosEvents events;
  ASSERT_TRUE(decode_event_array(bytes_of(message), events));
  EXPECT_EQ(events.size, (events::SensorSize{640, 480}));
  EXPECT_EQ(events.events, (std::vector<events::Event>{event(1'700'999'999, 639, 479, 1), event(1'701'000'001, 0, 1, 0)}));
  EXPECT_EQ(events.outside, 1U);
  EXPECT_EQ(events.lost_packets, 0U);
}

TEST(DecodeEventArray, RefusesCountsThatTheMessageCannotHold) {
  RosEvents events;
  for (const std::uint32_t count : {2U, 0xFFFFFFFFU, 0x13B13B14U}) {  // the last times 13 is 4 in 32 bits
    const std::string message = header(1, 0) + u32(480) + u32(640) + u32(count) + u16(1) + u16(1) + u32(1) + u32(1) + '\1';
    EXPECT_FALSE(decode_event_array(bytes_of(message), events)) << count;
  }
  const std::string whole = header(1, 0) + u32(480) + u32(640) + u32(1) + u16(1) + u16(1) + u32(1) + u32(1) + '\1';
  EXPECT_TRUE(decode_event_array(bytes_of(whole), events));
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(decode_event_array(bytes_of(whole.substr(0, size)), events)) << size;
}

TEST(DecodeEventArray, RefusesImpossibleSizesAndTimes) {
  RosEvents events;
  EXPECT_FALSE(decode_event_array(bytes_of(header(1, 0) + u32(0) + u32(640) + u32(0)), events));
  EXPECT_FALSE(decode_event_array(bytes_of(header(1, 0) + u32(480) + u32(32'768) + u32(0)), events));
  const std::string late = header(1, 0) + u32(480) + u32(640) + u32(1) + u16(1) + u16(1) + u32(1) + u32(1'000'000'000) + '\1';
  EXPECT_FALSE(decode_event_array(bytes_of(late), events));
}

TEST(DecodeEventPacket, ReadsLibcaerAndCarriesItsOverflow) {
  const auto raw = [](unsigned x, unsigned y, unsigned on, std::uint32_t us) {
    return u32(1 | on << 1 | y << 2 | x << 17) + u32(us);
  };
  const std::string data = raw(639, 479, 1, 0x7FFFFFFF) + raw(0, 3, 0, 0x7FFFFFFE) + raw(5, 0, 1, 4);
  EXPECT_EQ(events_in(event_packet("libcaer", 1'700'000'000'000'000'900, data)),
            (std::vector<events::Event>{event(1'700'000'000'000'000 + 0x7FFFFFFF, 639, 479, 1),
                                        event(1'700'000'000'000'000 + 0x7FFFFFFE, 0, 3, 0),  // disorder, no overflow
                                        event(1'700'000'000'000'000 + 0x80000004, 5, 0, 1)}));
}

TEST(DecodeEventPacket, ReadsTheCompressedWordsOfLibcaer) {
  // x 7; y 9 on; low time 5; x 8; from y 16, off, pixels 0, 2 and 7; then 8 further on pixel 1; high time 3.
  const std::string data =
      u16(0x2007) + u16(0x3809) + u16(0x1005) + u16(0x2008) + u16(0x4010) + u16(0x5085) + u16(0x5002) + u16(0x0003) + u16(0x300A);
  EXPECT_EQ(events_in(event_packet("libcaer_cmp", 2'000'000, data)),
            (std::vector<events::Event>{event(2'000, 7, 9, 1), event(2'005, 8, 16, 0), event(2'005, 8, 18, 0),
                                        event(2'005, 8, 23, 0), event(2'005, 8, 25, 0), event(2'000 + 3 * 4096 + 5, 8, 10, 0)}));
}

TEST(DecodeEventPacket, ReadsMono) {
  const std::uint64_t on = std::uint64_t{1} << 63;
  const std::string data = u64(1'500 | std::uint64_t{3} << 32 | std::uint64_t{4} << 48) + u64(on | 0xFFFFFFFF);
  EXPECT_EQ(events_in(event_packet("mono", 1'000'600, data)),
            (std::vector<events::Event>{event(1'002, 3, 4, 0), event(4'295'967, 0, 0, 1)}));
}

TEST(DecodeEventPacket, NamesAnEncodingThatItDoesNotKnow) {
  RosEvents events;
  EXPECT_EQ(EventPacketDecoder().decode(bytes_of(event_packet("evt2", 0, "xx")), events), PacketDecoding::other_encoding);
  EXPECT_EQ(events.encoding, "evt2");
  EXPECT_EQ(EventPacketDecoder().decode(bytes_of(event_packet("mono", 0, "12345678", true)), events),
            PacketDecoding::other_encoding);
  EXPECT_EQ(events.encoding, "mono (big-endian)");
}

TEST(DecodeEventPacket, GivesNothingOfAMessageWithMoreEventsThanAnyDriverSends) {
  RosEvents events;
  std::string masks;
  for (std::size_t i = 0; i < 1'100'000; ++i) masks += u16(0x4000) + u16(0x50FF);  // 8 events each
  EXPECT_EQ(EventPacketDecoder().decode(bytes_of(event_packet("libcaer_cmp", 0, masks)), events), PacketDecoding::broken);
  EXPECT_LE(events.events.size(), (std::size_t{8} << 20) + 8);
}

TEST(EventPacketDecoder, KeepsTheStateOfEvt3FromPacketToPacket) {
  EventPacketDecoder decoder;
  RosEvents events;
  const auto packet = [](std::uint64_t sequence, const std::string& data) {
    return header(1, 0) + u32(480) + u32(640) + u64(sequence) + u64(0) + text("evt3") + std::string(1, '\0') + text(data);
  };
  ASSERT_EQ(decoder.decode(bytes_of(packet(7, u16(0x8001) + u16(0x6002) + u16(0x0003) + u16(0xA001))), events),
            PacketDecoding::whole);
  EXPECT_TRUE(events.events.empty());
  EXPECT_EQ(events.triggers, (std::vector<events::Evt3Trigger>{{camera_time(4098), 0, true}}));
  ASSERT_EQ(decoder.decode(bytes_of(packet(8, u16(0x2804) + u16(0x2280))), events), PacketDecoding::whole);
  EXPECT_EQ(events.events, std::vector<events::Event>{event(4098, 4, 3, 1)});
  EXPECT_EQ(events.outside, 1U);
  ASSERT_EQ(decoder.decode(bytes_of(packet(11, u16(0x2804))), events), PacketDecoding::whole);  // two packets are lost
  EXPECT_TRUE(events.events.empty());
  EXPECT_EQ(events.lost_packets, 2U);
  EXPECT_EQ(events.unplaced, 1U);
}

/// XCDR1: the bytes that name the encoding, then fields that are aligned to their size from there.
struct Cdr {
  std::string bytes = std::string("\0\1\0\0", 4);
  Cdr& add(std::uint64_t value, int size) {
    while ((bytes.size() - 4) % static_cast<std::size_t>(size) != 0) bytes += '\0';
    bytes += little_endian(value, size);
    return *this;
  }
  Cdr& add(const std::string& value) {
    add(value.size() + 1, 4);
    bytes += value + '\0';
    return *this;
  }
  SerialisedMessage message() const { return {bytes_of(bytes), RosSerialisation::cdr}; }
};

TEST(DecodeEventArray, ReadsTheAlignedFieldsOfRos2) {
  Cdr cdr;
  cdr.add(1, 4).add(2, 4).add("cam").add(480, 4).add(640, 4).add(2, 4);
  cdr.add(5, 2).add(6, 2).add(1700, 4).add(3'000, 4).add(1, 1);
  cdr.add(7, 2).add(8, 2).add(1700, 4).add(4'000, 4).add(0, 1);
  RosEvents events;
  ASSERT_TRUE(decode_event_array(cdr.message(), events));
  EXPECT_EQ(events.events, (std::vector<events::Event>{event(1'700'000'003, 5, 6, 1), event(1'700'000'004, 7, 8, 0)}));
  for (std::size_t size = 0; size < cdr.bytes.size(); ++size)
    EXPECT_FALSE(decode_event_array({bytes_of(cdr.bytes).first(size), RosSerialisation::cdr}, events)) << size;
  cdr.bytes[1] = '\0';  // big-endian
  EXPECT_FALSE(decode_event_array(cdr.message(), events));
}

TEST(EventPacketDecoder, ReadsTheAlignedFieldsOfRos2) {
  Cdr cdr;
  cdr.add(1, 4).add(2, 4).add("c").add(480, 4).add(640, 4).add(3, 8).add(1'000'000, 8).add("mono").add(0, 1).add(8, 4);
  cdr.bytes += u64(1'500 | std::uint64_t{3} << 32 | std::uint64_t{4} << 48);
  RosEvents events;
  ASSERT_EQ(EventPacketDecoder().decode(cdr.message(), events), PacketDecoding::whole);
  EXPECT_EQ(events.events, std::vector<events::Event>{event(1'001, 3, 4, 0)});
  EXPECT_EQ(events.size, (events::SensorSize{640, 480}));
}

TEST(RosMessageWith, KnowsItsTypesByTheirDefinition) {
  EXPECT_EQ(ros_message_with("5e8beee5a6c107e504c2e78903c224b8"), RosMessage::event_array);
  EXPECT_EQ(ros_message_with("94810edda583a504dfda3829e70d7eec"), RosMessage::transforms);
  EXPECT_EQ(ros_message_with("992ce8a1687cec8c8bd883ec73ca41d1"), RosMessage::other);
  EXPECT_EQ(ros_message_with(""), RosMessage::other);
}

TEST(RosMessageNamed, KnowsTheNamesOfBothVersionsOfRos) {
  EXPECT_EQ(ros_message_named("sensor_msgs/msg/Imu"), RosMessage::imu);
  EXPECT_EQ(ros_message_named("sensor_msgs/Imu"), RosMessage::imu);
  EXPECT_EQ(ros_message_named("event_array_msgs/msg/EventArray"), RosMessage::event_packet);
  EXPECT_EQ(ros_message_named("sensor_msgs/srv/Imu"), RosMessage::other);
}

}  // namespace
}  // namespace tactile::bags
