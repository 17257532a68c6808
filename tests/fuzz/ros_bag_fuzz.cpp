#include "abort_unless.hpp"
#include "bytes_as_file.hpp"
#include "tactile/bags/ros_bag.hpp"
#include "tactile/bags/ros_events.hpp"
#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/error.hpp"
#include "tactile/robot/rotation.hpp"

namespace {

using namespace tactile;
using test::abort_unless;

/// Decoded events are inside the sensor, and the angles of rotations are at most pi.
void decode(bags::SerialisedMessage message) {
  bags::RosEvents events;
  const auto check = [&] {
    for (const events::Event& event : events.events)
      abort_unless(event.x >= 0 && event.y >= 0 && event.x < events.size.width && event.y < events.size.height && event.on <= 1);
  };
  if (bags::decode_event_array(message, events)) check();
  if (bags::EventPacketDecoder().decode(message, events) == bags::PacketDecoding::whole) check();
  conversion::JointStates joints;
  conversion::decode_joint_state(message, joints);
  std::vector<conversion::ToolPose> poses;
  std::uint64_t unusable = 0;
  conversion::decode_stamped_pose(message, poses, unusable);
  conversion::decode_tool_poses(message, poses, unusable);
  for (const conversion::ToolPose& pose : poses) {
    for (const double component : robot::rotation_vector_of(pose.turn)) abort_unless(component > -3.15 && component < 3.15);
  }
  conversion::RosImage image;
  conversion::decode_image(message, image);
  conversion::decode_compressed_image(message, image);
  events::ImuSample sample;
  conversion::decode_imu_message(message, sample);
}

}  // namespace

/// For any input, the bag is read or there is an Error. Every decoder gets every message, because a bag can name any type for it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  decode(std::as_bytes(std::span(data, size)));
  decode({std::as_bytes(std::span(data, size)), bags::RosSerialisation::cdr});
  const test::BytesAsFile file(data, size);
  try {
    bags::RosBagReader bag(file.path());
    std::uint64_t before = 0;
    while (const auto message = bag.next()) {
      decode(message->data);
      abort_unless(bag.bytes_read() >= before && bag.bytes_read() <= bag.file_size());
      before = bag.bytes_read();
    }
    bag.rewind();
    bag.next();
  } catch (const Error&) {
  }
  return 0;
}
