#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"

// Decoders for the messages of a run, in ROS 1's serialisation. They check every length before use. They fail if the bytes are
// not such a message, or have more than 8 million events.
namespace tactile::conversion {

/// The type of a message. The MD5 sum identifies the definition, whatever its name: tf/tfMessage is tf2_msgs/TFMessage.
enum class RosMessage : std::uint8_t { other, event_array, event_packet, joint_state, transforms, image, imu };

RosMessage ros_message_with(std::string_view md5sum);  ///< `other` if it is unknown

/// The events of a message, in its order.
struct RosEvents {
  events::SensorSize size;
  std::vector<events::Event> events;
  std::uint64_t outside = 0;              ///< events outside the sensor; dropped
  std::optional<std::uint64_t> sequence;  ///< of an EventPacket: each is one above the last
  std::string encoding;                   ///< of an EventPacket
};

/// dvs_msgs/EventArray.
bool decode_event_array(std::span<const std::byte> message, RosEvents& into);

/// event_camera_msgs/EventPacket in the encodings libcaer, libcaer_cmp and mono. Of a packet in another encoding, or with
/// big-endian numbers, only the part up to `encoding` is decoded.
enum class PacketDecoding : std::uint8_t { whole, broken, other_encoding };
PacketDecoding decode_event_packet(std::span<const std::byte> message, RosEvents& into);

/// The UR's six joints, from the base to the wrist, as RTDE numbers them.
inline constexpr std::array<std::string_view, 6> joint_names{"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
                                                             "wrist_1_joint",      "wrist_2_joint",       "wrist_3_joint"};

/// Positions of those joints that the sensor_msgs/JointState names [rad].
using JointPositions = std::array<std::optional<double>, 6>;
bool decode_joint_state(std::span<const std::byte> message, JointPositions& into);

/// The tool's place in the robot's base frame.
struct ToolPose {
  HostTime t;                     ///< the transform's stamp
  std::array<double, 3> place{};  ///< x, y, z [m]
  std::array<double, 4> turn{};   ///< quaternion x, y, z, w, of length 1
};

/// Every transform base -> tool0_controller of a tf2_msgs/TFMessage. `unusable` counts those that are not a valid pose.
bool decode_tool_poses(std::span<const std::byte> message, std::vector<ToolPose>& into, std::uint64_t& unusable);

/// The rotation as axis times angle [rad], the angle at most pi.
std::array<double, 3> rotation_vector(const std::array<double, 4>& turn);
/// The rotation that leads from `before` to `after`, in the base frame.
std::array<double, 4> turn_between(const std::array<double, 4>& before, const std::array<double, 4>& after);

struct RosImage {
  HostTime t;            ///< its stamp
  std::string encoding;  ///< such as "bgr8"
  cv::Mat pixels;        ///< 8-bit grey or BGR; empty if the encoding is not listed below
};

/// sensor_msgs/Image: mono8, 8UC1, mono16, 16UC1 (the upper 8 bits), bgr8, 8UC3, rgb8, bgra8, 8UC4, rgba8.
bool decode_image(std::span<const std::byte> message, RosImage& into);

/// sensor_msgs/Imu, which has neither temperature nor magnetic field: they are 0.
bool decode_imu_message(std::span<const std::byte> message, events::ImuSample& into);

}  // namespace tactile::conversion
