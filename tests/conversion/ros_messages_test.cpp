#include "tactile/conversion/ros_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace tactile::conversion {
namespace {

std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}
std::string u32(std::uint64_t value) { return little_endian(value, 4); }
std::string f64(double value) { return {reinterpret_cast<const char*>(&value), 8}; }
std::string text(const std::string& value) { return u32(value.size()) + value; }
std::string header(std::uint32_t seconds, std::uint32_t nanoseconds, const std::string& frame = "") {
  return u32(7) + u32(seconds) + u32(nanoseconds) + text(frame);
}
std::span<const std::byte> bytes_of(const std::string& message) { return std::as_bytes(std::span(message)); }

TEST(DecodeJointState, GoesByNameNotByOrder) {
  const std::string message = header(1, 5'000) + u32(3) + text("wrist_3_joint") + text("finger") + text("shoulder_pan_joint") +
                              u32(3) + f64(0.6) + f64(9.0) + f64(-0.1) + u32(0) + u32(0);
  JointStates joints;
  ASSERT_TRUE(decode_joint_state(bytes_of(message), joints));
  EXPECT_EQ(us_of(joints.t), 1'000'005);
  ASSERT_EQ(joints.arms.size(), 1U);
  EXPECT_EQ(joints.arms.at(""), (JointPositions{-0.1, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0.6}));
}

TEST(DecodeJointState, DistinguishesArmsByWhatPrecedesTheNames) {
  const std::string message = header(1, 0) + u32(4) + text("left_elbow_joint") + text("elbow_joint_2") + text("r/elbow_joint") +
                              text("left_wrist_1_joint") + u32(4) + f64(0.1) + f64(9.0) + f64(0.2) + f64(0.3);
  JointStates joints;
  ASSERT_TRUE(decode_joint_state(bytes_of(message), joints));
  ASSERT_EQ(joints.arms.size(), 2U);
  EXPECT_EQ(joints.arms.at("left_"), (JointPositions{std::nullopt, std::nullopt, 0.1, 0.3, std::nullopt, std::nullopt}));
  EXPECT_EQ(joints.arms.at("r/").at(2), 0.2);
}

TEST(DecodeJointState, GivesNoPositionThatIsNotThere) {
  JointStates joints;
  ASSERT_TRUE(decode_joint_state(
      bytes_of(header(1, 0) + u32(2) + text("elbow_joint") + text("wrist_1_joint") + u32(1) + f64(NAN)), joints));
  EXPECT_TRUE(joints.arms.empty());
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

TEST(DecodeStampedPose, TakesPosesInTheFrameBase) {
  const auto pose = [](const std::string& frame, double w) {
    std::string message = header(5, 1'000, frame);
    for (const double number : {1.0, 2.0, 3.0, 0.0, 0.0, 0.0, w}) message += f64(number);
    return message;
  };
  std::vector<ToolPose> poses;
  std::uint64_t unusable = 0;
  ASSERT_TRUE(decode_stamped_pose(bytes_of(pose("base", 1)), poses, unusable));
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].place, (std::array<double, 3>{1, 2, 3}));
  ASSERT_TRUE(decode_stamped_pose(bytes_of(pose("world", 1)), poses, unusable));
  EXPECT_TRUE(poses.empty());
  ASSERT_TRUE(decode_stamped_pose(bytes_of(pose("base", 0)), poses, unusable));
  EXPECT_EQ(unusable, 1U);
  EXPECT_FALSE(decode_stamped_pose(bytes_of(pose("base", 1).substr(8)), poses, unusable));
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

TEST(DecodeCompressedImage, ReadsJpegAndPngAndChecksTheirSizeFirst) {
  cv::Mat picture(20, 30, CV_8UC3, cv::Scalar(10, 20, 200));
  for (const char* extension : {".png", ".jpg"}) {
    std::vector<unsigned char> file;
    cv::imencode(extension, picture, file);
    const std::string bytes(file.begin(), file.end());
    RosImage decoded;
    ASSERT_TRUE(decode_compressed_image(bytes_of(header(3, 5'000) + text("bgr8; compressed") + text(bytes)), decoded));
    EXPECT_EQ(us_of(decoded.t), 3'000'005);
    ASSERT_EQ(decoded.pixels.size(), cv::Size(30, 20)) << extension;
    EXPECT_NEAR(decoded.pixels.at<cv::Vec3b>(5, 5)[2], 200, 3);
    EXPECT_FALSE(decode_compressed_image(bytes_of(header(3, 0) + text("png") + u32(9'999) + bytes), decoded));
  }
  std::vector<unsigned char> file;
  cv::imencode(".png", picture, file);
  file[18] = file[22] = 0x7F;  // 32 542 x 32 532 pixels
  RosImage decoded;
  ASSERT_TRUE(decode_compressed_image(bytes_of(header(3, 0) + text("png") + text({file.begin(), file.end()})), decoded));
  EXPECT_TRUE(decoded.pixels.empty());
  ASSERT_TRUE(decode_compressed_image(bytes_of(header(3, 0) + text("tiff") + text("II*")), decoded));
  EXPECT_TRUE(decoded.pixels.empty());
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

}  // namespace
}  // namespace tactile::conversion
