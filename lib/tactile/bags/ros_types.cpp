#include "tactile/bags/ros_types.hpp"

#include <string>

namespace tactile::bags {
namespace {

struct KnownMessage {
  std::string_view md5sum, name;
  RosMessage message;
};

constexpr KnownMessage known_messages[] = {
    {"5e8beee5a6c107e504c2e78903c224b8", "dvs_msgs/EventArray", RosMessage::event_array},
    {"8a6101b351a64529ac77bd8b71074e52", "event_camera_msgs/EventPacket", RosMessage::event_packet},
    {"", "event_array_msgs/EventArray", RosMessage::event_packet},
    {"3066dcd76a6cfaef579bd0f34173e9fd", "sensor_msgs/JointState", RosMessage::joint_state},
    {"94810edda583a504dfda3829e70d7eec", "tf2_msgs/TFMessage", RosMessage::transforms},
    {"d3812c3cbc69362b77dc0b19b345f8f5", "geometry_msgs/PoseStamped", RosMessage::pose},
    {"060021388200f6f0f447d0fcd9c64743", "sensor_msgs/Image", RosMessage::image},
    {"8f7a12909da2c9d3332d540a0977563f", "sensor_msgs/CompressedImage", RosMessage::compressed_image},
    {"6a62c6daae103f4ff57a132d6f95cec2", "sensor_msgs/Imu", RosMessage::imu}};

}  // namespace

RosMessage ros_message_with(std::string_view md5sum) {
  for (const KnownMessage& known : known_messages) {
    if (!md5sum.empty() && known.md5sum == md5sum) return known.message;
  }
  return RosMessage::other;
}

RosMessage ros_message_named(std::string_view type) {
  std::string name(type);
  if (const std::size_t middle = name.find("/msg/"); middle != std::string::npos) name.erase(middle, 4);
  for (const KnownMessage& known : known_messages) {
    if (known.name == name) return known.message;
  }
  return RosMessage::other;
}

}  // namespace tactile::bags
