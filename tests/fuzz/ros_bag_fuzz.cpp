#include "bytes_as_file.hpp"
#include "tactile/conversion/ros_bag.hpp"
#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/error.hpp"

namespace {

using namespace tactile;

/// Whatever the bytes, what is decoded lies inside the sensor, and rotations are rotations.
void decode(std::span<const std::byte> message) {
  RosEvents events;
  const auto check = [&] {
    for (const Event& event : events.events) {
      if (event.x < 0 || event.y < 0 || event.x >= events.size.width || event.y >= events.size.height || event.on > 1)
        std::abort();
    }
  };
  if (decode_event_array(message, events)) check();
  if (decode_event_packet(message, events) == PacketDecoding::whole) check();
  JointPositions joints;
  decode_joint_state(message, joints);
  std::vector<ToolPose> poses;
  std::uint64_t unusable = 0;
  decode_tool_poses(message, poses, unusable);
  for (const ToolPose& pose : poses) {
    for (const double along : rotation_vector(pose.turn)) {
      if (!(along > -3.15 && along < 3.15)) std::abort();
    }
  }
  RosImage image;
  decode_image(message, image);
  ImuSample sample;
  decode_imu_message(message, sample);
}

}  // namespace

/// The container, and every decoder over every message whatever its type: a definition's name is easily forged.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  decode(std::as_bytes(std::span(data, size)));
  const test::BytesAsFile file(data, size);
  try {
    RosBagReader bag(file.path());
    std::uint64_t before = 0;
    while (const auto message = bag.next()) {
      decode(message->data);
      if (bag.bytes_read() < before || bag.bytes_read() > bag.file_size()) std::abort();
      before = bag.bytes_read();
    }
    bag.rewind();
    bag.next();
  } catch (const Error&) {
  }
  return 0;
}
