#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace tactile::bags {

/// How the fields of a message follow each other.
enum class RosSerialisation : std::uint8_t {
  ros1,  ///< ROS 1: without gaps
  cdr,   ///< ROS 2: XCDR1, little-endian; 4 bytes name the encoding, then every number is aligned to its size
  other
};

/// A message as a bag has it.
struct SerialisedMessage {
  SerialisedMessage(std::span<const std::byte> in_bytes, RosSerialisation how = RosSerialisation::ros1)
      : bytes(in_bytes), serialisation(how) {}

  std::span<const std::byte> bytes;
  RosSerialisation serialisation;
};

/// The types of messages that we decode.
enum class RosMessage : std::uint8_t {
  other,
  event_array,       ///< dvs_msgs/EventArray
  event_packet,      ///< event_camera_msgs/EventPacket, and its former name event_array_msgs/EventArray
  joint_state,       ///< sensor_msgs/JointState
  transforms,        ///< tf2_msgs/TFMessage
  pose,              ///< geometry_msgs/PoseStamped
  image,             ///< sensor_msgs/Image
  compressed_image,  ///< sensor_msgs/CompressedImage
  imu                ///< sensor_msgs/Imu
};

/// The type by the MD5 sum of its definition, as ROS 1 identifies it: tf/tfMessage is tf2_msgs/TFMessage. `other` if unknown.
RosMessage ros_message_with(std::string_view md5sum);

/// The type by its name, as ROS 2 identifies it, with or without "/msg". `other` if unknown.
RosMessage ros_message_named(std::string_view type);

}  // namespace tactile::bags
