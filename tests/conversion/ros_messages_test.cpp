#include "tactile/conversion/ros_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

namespace tactile::conversion {
namespace {

std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}
std::string u16(std::uint64_t value) { return little_endian(value, 2); }
std::string u32(std::uint64_t value) { return little_endian(value, 4); }
std::string u64(std::uint64_t value) { return little_endian(value, 8); }
std::string f64(double value) { return {reinterpret_cast<const char*>(&value), 8}; }
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
  EXPECT_EQ(decode_event_packet(bytes_of(packet), events), PacketDecoding::whole);
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
  EXPECT_FALSE(events.sequence);
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
  EXPECT_EQ(decode_event_packet(bytes_of(event_packet("evt3", 0, "xx")), events), PacketDecoding::other_encoding);
  EXPECT_EQ(events.encoding, "evt3");
  EXPECT_EQ(decode_event_packet(bytes_of(event_packet("mono", 0, "12345678", true)), events), PacketDecoding::other_encoding);
  EXPECT_EQ(events.encoding, "mono (big-endian)");
}

TEST(DecodeEventPacket, GivesNothingOfAMessageWithMoreEventsThanAnyDriverSends) {
  RosEvents events;
  std::string masks;
  for (std::size_t i = 0; i < 1'100'000; ++i) masks += u16(0x4000) + u16(0x50FF);  // 8 events each
  EXPECT_EQ(decode_event_packet(bytes_of(event_packet("libcaer_cmp", 0, masks)), events), PacketDecoding::broken);
  EXPECT_LE(events.events.size(), (std::size_t{8} << 20) + 8);
}

TEST(DecodeJointState, GoesByNameNotByOrder) {
  const std::string message = header(1, 0) + u32(3) + text("wrist_3_joint") + text("finger") + text("shoulder_pan_joint") +
                              u32(3) + f64(0.6) + f64(9.0) + f64(-0.1) + u32(0) + u32(0);
  JointPositions joints;
  ASSERT_TRUE(decode_joint_state(bytes_of(message), joints));
  EXPECT_EQ(joints, (JointPositions{-0.1, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0.6}));
}

TEST(DecodeJointState, GivesNoPositionThatIsNotThere) {
  JointPositions joints;
  ASSERT_TRUE(decode_joint_state(
      bytes_of(header(1, 0) + u32(2) + text("elbow_joint") + text("wrist_1_joint") + u32(1) + f64(NAN)), joints));
  EXPECT_EQ(joints, JointPositions{});
  EXPECT_FALSE(decode_joint_state(bytes_of(header(1, 0) + u32(0xFFFFFFFF)), joints));
}

std::string transform(const std::string& frame, const std::string& child, std::array<double, 7> numbers) {
  std::string message = header(5, 1'000, frame) + text(child);
  for (const double number : numbers) message += f64(number);
  return message;
}

TEST(DecodeToolPoses, TakesBaseToToolAloneAndCountsWhatIsNoPose) {
  const std::string message = u32(4) + transform("base", "tool0_controller", {1, 2, 3, 0, 0, 0, 1}) +
                              transform("base_link", "tool0_controller", {9, 9, 9, 0, 0, 0, 1}) +
                              transform("/base", "/tool0_controller", {4, 5, 6, 0, 0, 1, 0}) +
                              transform("base", "tool0_controller", {1, 2, 3, 0, 0, 0, 0});
  std::vector<ToolPose> poses;
  std::uint64_t unusable = 0;
  ASSERT_TRUE(decode_tool_poses(bytes_of(message), poses, unusable));
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(us_of(poses[0].t), 5'000'001);
  EXPECT_EQ(poses[1].place, (std::array<double, 3>{4, 5, 6}));
  EXPECT_EQ(unusable, 1U);
  EXPECT_FALSE(decode_tool_poses(bytes_of(message.substr(0, message.size() - 1)), poses, unusable));
  EXPECT_TRUE(poses.empty());
}

TEST(RotationVector, IsAxisTimesTheSmallerAngle) {
  const auto expect = [](const std::array<double, 4>& turn, const std::array<double, 3>& vector) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(rotation_vector(turn).at(i), vector.at(i), 1e-12) << i;
  };
  expect({0, 0, 0, 1}, {0, 0, 0});
  expect({0, 0, std::sin(0.25), std::cos(0.25)}, {0, 0, 0.5});
  expect({0, 0, -std::sin(0.25), -std::cos(0.25)}, {0, 0, 0.5});
  expect({0, 1, 0, 0}, {0, std::numbers::pi, 0});
  expect({1e-13, 0, 0, 1}, {2e-13, 0, 0});
}

TEST(TurnBetween, LeadsFromTheOneToTheOther) {
  // A quarter about x, then a quarter about the base's z: what leads there is the quarter about z.
  const double h = std::sqrt(0.5);
  const std::array<double, 4> about_x{h, 0, 0, h}, about_both{0.5, 0.5, 0.5, 0.5};
  const std::array<double, 3> turn = rotation_vector(turn_between(about_x, about_both));
  EXPECT_NEAR(turn[0], 0, 1e-12);
  EXPECT_NEAR(turn[1], 0, 1e-12);
  EXPECT_NEAR(turn[2], std::numbers::pi / 2, 1e-12);
}

std::string image(const std::string& encoding, std::uint32_t step, const std::string& data, std::uint32_t width = 2) {
  return header(3, 5'000) + u32(2) + u32(width) + text(encoding) + '\0' + u32(step) + text(data);
}

TEST(DecodeImage, GivesGreyOrBgrForEveryChannelOrder) {
  RosImage decoded;
  ASSERT_TRUE(decode_image(bytes_of(image("rgb8", 7, "RGBrgb-RGBrgb-")), decoded));  // a byte of padding in each row
  EXPECT_EQ(us_of(decoded.t), 3'000'005);
  ASSERT_EQ(decoded.pixels.type(), CV_8UC3);
  EXPECT_EQ(decoded.pixels.at<cv::Vec3b>(1, 1), cv::Vec3b('b', 'g', 'r'));
  ASSERT_TRUE(decode_image(bytes_of(image("bgra8", 8, "BGRAbgraBGRAbgra")), decoded));
  EXPECT_EQ(decoded.pixels.at<cv::Vec3b>(0, 0), cv::Vec3b('B', 'G', 'R'));
  ASSERT_TRUE(decode_image(bytes_of(image("mono16", 4, "aAbBcCdD")), decoded));
  ASSERT_EQ(decoded.pixels.type(), CV_8UC1);
  EXPECT_EQ(decoded.pixels.at<std::uint8_t>(1, 0), 'C');
}

TEST(DecodeImage, ChecksThatThePixelsAreThere) {
  RosImage decoded;
  EXPECT_FALSE(decode_image(bytes_of(image("mono8", 2, "abc")), decoded));
  EXPECT_FALSE(decode_image(bytes_of(image("mono8", 1, "abcd")), decoded));
  EXPECT_FALSE(decode_image(bytes_of(image("mono8", 0xFFFFFFFF, "abcd")), decoded));
  EXPECT_FALSE(decode_image(bytes_of(image("mono8", 4, "abcdefgh", 40'000)), decoded));
  ASSERT_TRUE(decode_image(bytes_of(image("bayer_rggb8", 2, "abcd")), decoded));
  EXPECT_TRUE(decoded.pixels.empty());
  EXPECT_EQ(decoded.encoding, "bayer_rggb8");
}

TEST(DecodeImuMessage, TurnsUnitsIntoTheCameras) {
  std::string message = header(2, 0);
  for (int i = 0; i < 4 + 9; ++i) message += f64(77);
  message += f64(std::numbers::pi) + f64(0) + f64(-std::numbers::pi / 2);
  for (int i = 0; i < 9; ++i) message += f64(77);
  message += f64(0) + f64(9.80665) + f64(-19.6133);
  for (int i = 0; i < 9; ++i) message += f64(77);
  events::ImuSample sample;
  ASSERT_TRUE(decode_imu_message(bytes_of(message), sample));
  EXPECT_EQ(us_of(sample.t), 2'000'000);
  EXPECT_FLOAT_EQ(sample.angular_rate_dps[0], 180);
  EXPECT_FLOAT_EQ(sample.angular_rate_dps[2], -90);
  EXPECT_FLOAT_EQ(sample.acceleration_g[1], 1);
  EXPECT_FLOAT_EQ(sample.acceleration_g[2], -2);
  EXPECT_FALSE(decode_imu_message(bytes_of(message.substr(8)), sample));
}

TEST(RosMessageWith, KnowsItsTypesByTheirDefinition) {
  EXPECT_EQ(ros_message_with("5e8beee5a6c107e504c2e78903c224b8"), RosMessage::event_array);
  EXPECT_EQ(ros_message_with("94810edda583a504dfda3829e70d7eec"), RosMessage::transforms);
  EXPECT_EQ(ros_message_with("992ce8a1687cec8c8bd883ec73ca41d1"), RosMessage::other);
}

}  // namespace
}  // namespace tactile::conversion
