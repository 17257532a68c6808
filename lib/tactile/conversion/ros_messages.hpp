#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/bags/ros_types.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/other_streams.hpp"

// Decoders for the messages of a run that have no events. They check every length before use. They fail if the bytes are not such
// a message.
namespace tactile::conversion {

/// The UR's six joints, from the base to the wrist, as RTDE numbers them.
inline constexpr std::array<std::string_view, 6> joint_names{"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
                                                             "wrist_1_joint",      "wrist_2_joint",       "wrist_3_joint"};

using JointPositions = std::array<std::optional<double>, 6>;  ///< [rad]

/// Positions of the joints that a sensor_msgs/JointState names, by arm: what precedes `joint_names`, such as "left_" or nothing.
struct JointStates {
  HostTime t{};  ///< the message's stamp
  std::map<std::string, JointPositions, std::less<>> arms;
};
bool decode_joint_state(bags::SerialisedMessage message, JointStates& into);

/// The tool's place in the robot's base frame.
struct ToolPose {
  HostTime t;                     ///< the transform's stamp
  std::array<double, 3> place{};  ///< x, y, z [m]
  std::array<double, 4> turn{};   ///< quaternion x, y, z, w, of length 1
};

/// Every transform base -> tool0_controller of a tf2_msgs/TFMessage. `unusable` counts those that are not a valid pose.
bool decode_tool_poses(bags::SerialisedMessage message, std::vector<ToolPose>& into, std::uint64_t& unusable);

/// A geometry_msgs/PoseStamped in the frame `base`, as the driver of ROS 2 publishes the tool's; others are omitted.
bool decode_stamped_pose(bags::SerialisedMessage message, std::vector<ToolPose>& into, std::uint64_t& unusable);

/// One of the two, by the message's type.
bool decode_poses(bags::RosMessage type, bags::SerialisedMessage message, std::vector<ToolPose>& into, std::uint64_t& unusable);

struct RosImage {
  HostTime t;            ///< its stamp
  std::string encoding;  ///< such as "bgr8"
  cv::Mat pixels;        ///< 8-bit grey or BGR; empty if the encoding is not listed below
};

/// sensor_msgs/Image: mono8, 8UC1, mono16, 16UC1 (the upper 8 bits), bgr8, 8UC3, rgb8, bgra8, 8UC4, rgba8.
bool decode_image(bags::SerialisedMessage message, RosImage& into);

/// sensor_msgs/CompressedImage: JPEG and PNG, which become BGR. `pixels` is empty for other formats, and for images with more
/// than 64 million pixels.
bool decode_compressed_image(bags::SerialisedMessage message, RosImage& into);

/// One of the two, by the message's type.
bool decode_any_image(bags::RosMessage type, bags::SerialisedMessage message, RosImage& into);

/// sensor_msgs/Imu, which has neither temperature nor magnetic field: they are 0.
bool decode_imu_message(bags::SerialisedMessage message, events::ImuSample& into);

}  // namespace tactile::conversion
