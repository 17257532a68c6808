#include "tactile/conversion/ros_messages.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "tactile/bags/bag_file.hpp"
#include "tactile/bags/ros_events.hpp"
#include "tactile/video/picture_codec.hpp"

namespace tactile::conversion {
namespace {

using bags::Bytes;
using bags::number_at;
using bags::RosFields;

std::string_view without_slash(std::string_view frame) {
  if (frame.starts_with('/')) frame.remove_prefix(1);
  return frame;
}

/// Adds a pose, or counts it if it is none.
void add_pose(ToolPose pose, std::vector<ToolPose>& into, std::uint64_t& unusable) {
  const double length = std::sqrt(pose.turn[0] * pose.turn[0] + pose.turn[1] * pose.turn[1] + pose.turn[2] * pose.turn[2] +
                                  pose.turn[3] * pose.turn[3]);
  const bool is_place = std::all_of(pose.place.begin(), pose.place.end(), [](double along) { return std::isfinite(along); });
  if (!is_place || !(std::abs(length - 1) < 0.1)) {  // a quaternion of another length is not a rotation
    ++unusable;
    return;
  }
  for (double& part : pose.turn) part /= length;
  into.push_back(pose);
}

/// The size of a JPEG or PNG; nothing if it is neither, or has none at its start.
std::optional<cv::Size> size_of_picture(Bytes data) {
  const auto byte = [&](std::size_t at) { return std::to_integer<int>(data[at]); };
  const auto big_endian = [&](std::size_t at) { return byte(at) << 8 | byte(at + 1); };
  if (data.size() >= 24 && big_endian(0) == 0x8950 && big_endian(2) == 0x4E47) {
    if (big_endian(16) != 0 || big_endian(20) != 0) return std::nullopt;  // a side of 65536 pixels or more
    return cv::Size(big_endian(18), big_endian(22));
  }
  if (data.size() < 4 || big_endian(0) != 0xFFD8) return std::nullopt;
  for (std::size_t at = 2; at + 9 <= data.size() && byte(at) == 0xFF;) {
    const int marker = byte(at + 1);
    const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame) return cv::Size(big_endian(at + 7), big_endian(at + 5));
    at += marker == 0xFF ? 1 : 2 + static_cast<std::size_t>(big_endian(at + 2));
  }
  return std::nullopt;
}

}  // namespace

bool decode_joint_state(bags::SerialisedMessage message, JointStates& into) {
  into.arms.clear();
  RosFields fields(message);
  into.t = HostTime{microseconds{fields.header().first}};
  const std::size_t count = fields.count(4);
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < count && fields.ok(); ++i) names.push_back(fields.text());
  const Bytes positions = fields.array(sizeof(double));
  if (!fields.ok()) return false;
  for (std::size_t i = 0; i < std::min(names.size(), positions.size() / sizeof(double)); ++i) {
    const auto* joint =
        std::find_if(joint_names.begin(), joint_names.end(), [&](std::string_view known) { return names[i].ends_with(known); });
    const auto position = number_at<double>(positions, i * sizeof(double));
    if (joint == joint_names.end() || !std::isfinite(position)) continue;
    const std::string_view arm = names[i].substr(0, names[i].size() - joint->size());
    into.arms[std::string(arm)].at(static_cast<std::size_t>(joint - joint_names.begin())) = position;
  }
  return true;
}

bool decode_tool_poses(bags::SerialisedMessage message, std::vector<ToolPose>& into, std::uint64_t& unusable) {
  into.clear();
  RosFields fields(message);
  const std::size_t transforms = fields.count(76);
  for (std::size_t i = 0; i < transforms && fields.ok(); ++i) {
    const auto [stamp_us, frame] = fields.header();
    const std::string_view child = fields.text();
    ToolPose pose{.t = HostTime{microseconds{stamp_us}}};
    for (double& along : pose.place) along = fields.number<double>();
    for (double& part : pose.turn) part = fields.number<double>();
    if (!fields.ok() || without_slash(frame) != "base" || without_slash(child) != "tool0_controller") continue;
    add_pose(pose, into, unusable);
  }
  if (!fields.ok()) into.clear();
  return fields.ok();
}

bool decode_stamped_pose(bags::SerialisedMessage message, std::vector<ToolPose>& into, std::uint64_t& unusable) {
  into.clear();
  RosFields fields(message);
  const auto [stamp_us, frame] = fields.header();
  ToolPose pose{.t = HostTime{microseconds{stamp_us}}};
  for (double& along : pose.place) along = fields.number<double>();
  for (double& part : pose.turn) part = fields.number<double>();
  if (fields.ok() && without_slash(frame) == "base") add_pose(pose, into, unusable);
  return fields.ok();
}

bool decode_poses(bags::RosMessage type, bags::SerialisedMessage message, std::vector<ToolPose>& into, std::uint64_t& unusable) {
  return type == bags::RosMessage::pose ? decode_stamped_pose(message, into, unusable)
                                        : decode_tool_poses(message, into, unusable);
}

bool decode_image(bags::SerialisedMessage message, RosImage& into) {
  struct Encoding {
    std::string_view name;
    int type;
    int to_bgr;  ///< OpenCV's conversion; negative: none
  };
  static const Encoding encodings[] = {{"mono8", CV_8UC1, -1},
                                       {"8UC1", CV_8UC1, -1},
                                       {"mono16", CV_16UC1, -1},
                                       {"16UC1", CV_16UC1, -1},
                                       {"bgr8", CV_8UC3, -1},
                                       {"8UC3", CV_8UC3, -1},
                                       {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
                                       {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
                                       {"8UC4", CV_8UC4, cv::COLOR_BGRA2BGR},
                                       {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR}};
  into = {};
  RosFields fields(message);
  const std::int64_t stamp_us = fields.header().first;
  events::SensorSize size;
  if (!bags::take_size(fields, size)) return false;
  const std::string_view encoding = fields.text();
  const bool is_big_endian = fields.number<std::uint8_t>() != 0;
  const std::size_t step = fields.number<std::uint32_t>();
  const Bytes data = fields.array(1);
  if (!fields.ok()) return false;
  into.t = HostTime{microseconds{stamp_us}};
  into.encoding = encoding.substr(0, 64);
  const auto* found =
      std::find_if(std::begin(encodings), std::end(encodings), [&](const Encoding& e) { return e.name == encoding; });
  if (found == std::end(encodings)) return true;
  const auto width = static_cast<std::size_t>(size.width), height = static_cast<std::size_t>(size.height);
  if (step < width * static_cast<std::size_t>(CV_ELEM_SIZE(found->type)) || data.size() / height < step) return false;
  if (found->type == CV_16UC1) {
    into.pixels = cv::Mat(size.height, size.width, CV_8UC1);
    const std::size_t upper = is_big_endian ? 0 : 1;
    for (std::size_t y = 0; y < height; ++y) {
      auto* row = into.pixels.ptr<std::uint8_t>(static_cast<int>(y));
      for (std::size_t x = 0; x < width; ++x) row[x] = std::to_integer<std::uint8_t>(data[y * step + 2 * x + upper]);
    }
    return true;
  }
  const cv::Mat stored(size.height, size.width, found->type, const_cast<std::byte*>(data.data()), step);
  if (found->to_bgr < 0) {
    into.pixels = stored.clone();
  } else {
    cv::cvtColor(stored, into.pixels, found->to_bgr);
  }
  return true;
}

bool decode_compressed_image(bags::SerialisedMessage message, RosImage& into) {
  constexpr std::int64_t most_pixels = 64'000'000;
  into = {};
  RosFields fields(message);
  into.t = HostTime{microseconds{fields.header().first}};
  into.encoding = fields.text().substr(0, 64);
  const Bytes data = fields.array(1);
  if (!fields.ok()) return false;
  const std::optional<cv::Size> size = size_of_picture(data);  // before memory is allocated for the pixels
  if (!size || std::int64_t{size->width} * size->height > most_pixels) return true;
  into.pixels = video::decoded_picture(data);
  return !into.pixels.empty();
}

bool decode_any_image(bags::RosMessage type, bags::SerialisedMessage message, RosImage& into) {
  return type == bags::RosMessage::compressed_image ? decode_compressed_image(message, into) : decode_image(message, into);
}

bool decode_imu_message(bags::SerialisedMessage message, events::ImuSample& into) {
  into = {};
  RosFields fields(message);
  into.t = camera_time(fields.header().first);
  fields.take((4 + 9) * sizeof(double));  // orientation and its covariance
  for (float& rate : into.angular_rate_dps) rate = static_cast<float>(fields.number<double>() * 180 / std::numbers::pi);
  fields.take(9 * sizeof(double));
  for (float& along : into.acceleration_g) along = static_cast<float>(fields.number<double>() / events::standard_gravity);
  fields.take(9 * sizeof(double));
  return fields.ok();
}

}  // namespace tactile::conversion
