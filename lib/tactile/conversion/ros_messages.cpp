#include "tactile/conversion/ros_messages.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "tactile/conversion/ros_bytes.hpp"

namespace tactile::conversion {
namespace {

constexpr std::pair<std::string_view, RosMessage> known_messages[] = {
    {"5e8beee5a6c107e504c2e78903c224b8", RosMessage::event_array}, {"8a6101b351a64529ac77bd8b71074e52", RosMessage::event_packet},
    {"3066dcd76a6cfaef579bd0f34173e9fd", RosMessage::joint_state}, {"94810edda583a504dfda3829e70d7eec", RosMessage::transforms},
    {"060021388200f6f0f447d0fcd9c64743", RosMessage::image},       {"6a62c6daae103f4ff57a132d6f95cec2", RosMessage::imu}};

constexpr std::size_t most_events = std::size_t{8} << 20;  // of a message; drivers send less than a hundredth of it
constexpr std::size_t event_bytes = 13;                    // x, y, seconds, nanoseconds, polarity
constexpr std::size_t libcaer_event_bytes = 8;             // place and polarity, microseconds
constexpr double standard_gravity = 9.80665;               // [m/s^2]

/// Reads a message from front to back. Values after its end read as 0, and the cursor fails.
class Cursor {
 public:
  explicit Cursor(Bytes bytes) : rest_(bytes) {}

  bool ok() const { return ok_; }

  template <class T>
  T number() {
    T value{};
    const Bytes bytes = take(sizeof value);
    if (!bytes.empty()) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  Bytes take(std::size_t count) {
    if (!ok_ || count > rest_.size()) {
      ok_ = false;
      return {};
    }
    const Bytes bytes = rest_.first(count);
    rest_ = rest_.subspan(count);
    return bytes;
  }
  /// The number of elements that follow, of at least `least_bytes` each; fails if the message is too short for them.
  std::size_t count(std::size_t least_bytes) {
    const auto elements = number<std::uint32_t>();
    if (elements > rest_.size() / least_bytes) ok_ = false;
    return ok_ ? elements : 0;
  }
  Bytes array(std::size_t element_bytes) {
    const std::size_t elements = count(element_bytes);
    return take(elements * element_bytes);
  }
  std::string_view text() {
    const Bytes bytes = array(1);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  /// Seconds and nanoseconds, less than 10^9 of them.
  std::int64_t stamp_us() {
    const std::int64_t seconds = number<std::uint32_t>();
    const std::int64_t nanoseconds = number<std::uint32_t>();
    if (nanoseconds >= 1'000'000'000) ok_ = false;
    return seconds * 1'000'000 + nanoseconds / 1'000;
  }
  /// A Header's stamp and frame.
  std::pair<std::int64_t, std::string_view> header() {
    number<std::uint32_t>();
    const std::int64_t stamp = stamp_us();
    return {stamp, text()};
  }

 private:
  Bytes rest_;
  bool ok_ = true;
};

/// Reads the sensor's size, which both messages give as height, then width.
bool take_size(Cursor& cursor, events::SensorSize& size) {
  const auto height = cursor.number<std::uint32_t>(), width = cursor.number<std::uint32_t>();
  if (!cursor.ok() || width < 1 || height < 1 || width > events::most_side || height > events::most_side) return false;
  size = {static_cast<int>(width), static_cast<int>(height)};
  return true;
}

void add_event(RosEvents& into, std::int64_t t_us, unsigned x, unsigned y, bool on) {
  if (x >= static_cast<unsigned>(into.size.width) || y >= static_cast<unsigned>(into.size.height)) {
    ++into.outside;
    return;
  }
  events::Event& event = into.events.emplace_back();
  event.t = camera_time(t_us);
  event.x = static_cast<std::int16_t>(x);
  event.y = static_cast<std::int16_t>(y);
  event.on = on ? 1 : 0;
}

/// The camera driver's structs: bit 1 the polarity, 15 bits y, 15 bits x; then the lower 31 bits of the time.
void decode_libcaer(Bytes data, std::int64_t base_ns, RosEvents& into) {
  constexpr std::int64_t overflow_us = std::int64_t{1} << 31;
  std::int64_t carried_us = 0, previous = 0;
  into.events.reserve(data.size() / libcaer_event_bytes);
  for (std::size_t at = 0; at + libcaer_event_bytes <= data.size(); at += libcaer_event_bytes) {
    const auto place = number_at<std::uint32_t>(data, at);
    const std::int64_t us = number_at<std::uint32_t>(data, at + 4) & (overflow_us - 1);
    if (us + overflow_us / 2 < previous) carried_us += overflow_us;  // a small step back is disorder, not an overflow
    previous = us;
    add_event(into, base_ns / 1'000 + carried_us + us, place >> 17, place >> 2 & 0x7FFF, (place & 2) != 0);
  }
}

/// Words of 16 bits, with their kind in the upper four. Times count from the message's base.
void decode_compressed(Bytes data, std::int64_t base_ns, RosEvents& into) {
  enum Code : unsigned { time_high, time_low, address_x, address_y, vector_base_y, vector_8 };
  unsigned high = 0, low = 0, x = 0, base_y = 0;
  bool base_on = false;
  for (std::size_t at = 0; at + 2 <= data.size() && into.events.size() <= most_events; at += 2) {
    const unsigned word = number_at<std::uint16_t>(data, at);
    const unsigned value = word & 0x7FF;
    const bool upper_bit = (word & 0x800) != 0;
    const auto add = [&](unsigned y, bool on) {
      add_event(into, base_ns / 1'000 + static_cast<std::int64_t>(high << 12 | low), x, y, on);
    };
    switch (word >> 12) {
      case time_high:
        high = word & 0xFFF;
        break;
      case time_low:
        low = word & 0xFFF;
        break;
      case address_x:
        x = value;
        break;
      case address_y:
        add(value, upper_bit);
        break;
      case vector_base_y:
        base_y = value;
        base_on = upper_bit;
        break;
      case vector_8:
        for (unsigned bit = 0; bit < 8; ++bit) {
          if ((word >> bit & 1) != 0) add(base_y + bit, base_on);
        }
        base_y += 8;
        break;
      default:
        break;  // codes of a newer writer, without known events
    }
  }
}

/// 32 bits of nanoseconds, 16 of x, 15 of y, the polarity.
void decode_mono(Bytes data, std::int64_t base_ns, RosEvents& into) {
  into.events.reserve(data.size() / sizeof(std::uint64_t));
  for (std::size_t at = 0; at + sizeof(std::uint64_t) <= data.size(); at += sizeof(std::uint64_t)) {
    const auto word = number_at<std::uint64_t>(data, at);
    add_event(into, (base_ns + static_cast<std::int64_t>(word & 0xFFFFFFFF)) / 1'000, word >> 32 & 0xFFFF, word >> 48 & 0x7FFF,
              word >> 63 != 0);
  }
}

std::string_view without_slash(std::string_view frame) {
  if (frame.starts_with('/')) frame.remove_prefix(1);
  return frame;
}

}  // namespace

RosMessage ros_message_with(std::string_view md5sum) {
  for (const auto& [sum, message] : known_messages) {
    if (sum == md5sum) return message;
  }
  return RosMessage::other;
}

bool decode_event_array(Bytes message, RosEvents& into) {
  into = {};
  Cursor cursor(message);
  cursor.header();
  if (!take_size(cursor, into.size)) return false;
  const Bytes events = cursor.array(event_bytes);
  if (!cursor.ok() || events.size() / event_bytes > most_events) return false;
  into.events.reserve(events.size() / event_bytes);
  for (std::size_t at = 0; at < events.size(); at += event_bytes) {
    const auto seconds = number_at<std::uint32_t>(events, at + 4), nanoseconds = number_at<std::uint32_t>(events, at + 8);
    if (nanoseconds >= 1'000'000'000) return false;
    add_event(into, std::int64_t{seconds} * 1'000'000 + nanoseconds / 1'000, number_at<std::uint16_t>(events, at),
              number_at<std::uint16_t>(events, at + 2), events[at + 12] != std::byte{0});
  }
  return true;
}

PacketDecoding decode_event_packet(Bytes message, RosEvents& into) {
  into = {};
  Cursor cursor(message);
  cursor.header();
  if (!take_size(cursor, into.size)) return PacketDecoding::broken;
  into.sequence = cursor.number<std::uint64_t>();
  const auto base_ns = cursor.number<std::uint64_t>();
  into.encoding = cursor.text();
  const bool is_big_endian = cursor.number<std::uint8_t>() != 0;
  const Bytes data = cursor.array(1);
  if (!cursor.ok() || base_ns > std::uint64_t{1} << 62) return PacketDecoding::broken;
  const auto base = static_cast<std::int64_t>(base_ns);
  const bool is_compressed = into.encoding == "libcaer_cmp";
  if (!is_compressed && data.size() / libcaer_event_bytes > most_events) return PacketDecoding::broken;
  if (is_big_endian) into.encoding += " (big-endian)";
  if (into.encoding == "libcaer") {
    decode_libcaer(data, base, into);
  } else if (is_compressed && !is_big_endian) {
    decode_compressed(data, base, into);
  } else if (into.encoding == "mono") {
    decode_mono(data, base, into);
  } else {
    return PacketDecoding::other_encoding;
  }
  return into.events.size() > most_events ? PacketDecoding::broken : PacketDecoding::whole;
}

bool decode_joint_state(Bytes message, JointPositions& into) {
  into = {};
  Cursor cursor(message);
  cursor.header();
  const std::size_t names = cursor.count(4);
  std::array<std::size_t, joint_names.size()> column;
  column.fill(names);
  for (std::size_t i = 0; i < names && cursor.ok(); ++i) {
    const auto* found = std::find(joint_names.begin(), joint_names.end(), cursor.text());
    if (found != joint_names.end()) column.at(static_cast<std::size_t>(found - joint_names.begin())) = i;
  }
  const Bytes positions = cursor.array(sizeof(double));
  if (!cursor.ok()) return false;
  for (std::size_t joint = 0; joint < into.size(); ++joint) {
    if (column.at(joint) >= positions.size() / sizeof(double)) continue;
    const auto position = number_at<double>(positions, column.at(joint) * sizeof(double));
    if (std::isfinite(position)) into.at(joint) = position;
  }
  return true;
}

bool decode_tool_poses(Bytes message, std::vector<ToolPose>& into, std::uint64_t& unusable) {
  into.clear();
  Cursor cursor(message);
  const std::size_t transforms = cursor.count(76);
  for (std::size_t i = 0; i < transforms && cursor.ok(); ++i) {
    const auto [stamp_us, frame] = cursor.header();
    const std::string_view child = cursor.text();
    ToolPose pose{.t = HostTime{microseconds{stamp_us}}};
    for (double& along : pose.place) along = cursor.number<double>();
    for (double& part : pose.turn) part = cursor.number<double>();
    if (!cursor.ok() || without_slash(frame) != "base" || without_slash(child) != "tool0_controller") continue;
    const double length = std::sqrt(pose.turn[0] * pose.turn[0] + pose.turn[1] * pose.turn[1] + pose.turn[2] * pose.turn[2] +
                                    pose.turn[3] * pose.turn[3]);
    const bool is_place = std::all_of(pose.place.begin(), pose.place.end(), [](double along) { return std::isfinite(along); });
    if (!is_place || !(std::abs(length - 1) < 0.1)) {  // a quaternion of another length is not a rotation
      ++unusable;
      continue;
    }
    for (double& part : pose.turn) part /= length;
    into.push_back(pose);
  }
  if (!cursor.ok()) into.clear();
  return cursor.ok();
}

std::array<double, 3> rotation_vector(const std::array<double, 4>& turn) {
  const double sine = std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
  const double sign = turn[3] < 0 ? -1 : 1;  // the same rotation, the short way
  const double angle = 2 * std::atan2(sine, sign * turn[3]);
  const double scale = sine < 1e-12 ? 2 : angle / sine;
  return {sign * scale * turn[0], sign * scale * turn[1], sign * scale * turn[2]};
}

std::array<double, 4> turn_between(const std::array<double, 4>& before, const std::array<double, 4>& after) {
  const auto& [ax, ay, az, aw] = after;
  const double bx = -before[0], by = -before[1], bz = -before[2], bw = before[3];
  return {aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw,
          aw * bw - ax * bx - ay * by - az * bz};
}

bool decode_image(Bytes message, RosImage& into) {
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
  Cursor cursor(message);
  const std::int64_t stamp_us = cursor.header().first;
  events::SensorSize size;
  if (!take_size(cursor, size)) return false;
  const std::string_view encoding = cursor.text();
  const bool is_big_endian = cursor.number<std::uint8_t>() != 0;
  const std::size_t step = cursor.number<std::uint32_t>();
  const Bytes data = cursor.array(1);
  if (!cursor.ok()) return false;
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

bool decode_imu_message(Bytes message, events::ImuSample& into) {
  into = {};
  Cursor cursor(message);
  into.t = camera_time(cursor.header().first);
  cursor.take((4 + 9) * sizeof(double));  // orientation and its covariance
  for (float& rate : into.angular_rate_dps) rate = static_cast<float>(cursor.number<double>() * 180 / std::numbers::pi);
  cursor.take(9 * sizeof(double));
  for (float& along : into.acceleration_g) along = static_cast<float>(cursor.number<double>() / standard_gravity);
  cursor.take(9 * sizeof(double));
  return cursor.ok();
}

}  // namespace tactile::conversion
