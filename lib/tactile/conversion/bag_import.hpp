#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/conversion/ros_bag.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

/// Which topics to take: the only one of its kind where empty, and nothing where "none" (which is no choice for events).
struct BagImportOptions {
  std::string events_topic{};                ///< dvs_msgs/EventArray or event_camera_msgs/EventPacket
  std::string joints_topic{};                ///< sensor_msgs/JointState that names the UR's joints
  std::string pose_topic{};                  ///< tf2_msgs/TFMessage that has base -> tool0_controller
  std::string video_topic{};                 ///< sensor_msgs/Image
  std::string imu_topic{};                   ///< sensor_msgs/Imu
  std::optional<Compression> compression{};  ///< of events.aedat4; else LZ4
};

/// What a run lost on its way out of the bag, or had lost before.
struct BagImportDrops {
  std::uint64_t events = 0;                 ///< outside the sensor
  std::uint64_t late_events = 0;            ///< more than 20 ms earlier than what came before them
  std::uint64_t event_packets = 0;          ///< missing in the row of EventPackets' numbers
  std::uint64_t broken_messages = 0;        ///< of the topics taken, that could not be decoded
  std::uint64_t other_sensor_messages = 0;  ///< of events for a sensor of another size than the first's
  std::uint64_t robot_states = 0;           ///< no pose, not later than the one before, or out of reach of it
  std::uint64_t frames = 0;                 ///< of another size, or not later than the one before
  std::uint64_t imu_samples = 0;            ///< not later than the one before
};

struct BagTopic {
  std::string name, type;
  std::uint64_t messages = 0;
  std::string use;  ///< "events", "joints", "pose", "video", "imu"; empty: left out
};

/// What an import did.
struct BagImportSummary {
  RunFolder run;
  std::vector<BagTopic> topics;  ///< of the bag, by name
  SensorSize size;
  std::uint64_t events = 0, sorted_events = 0, imu_samples = 0, robot_states = 0, frames = 0;
  CameraTime first{}, last{};  ///< of the events
  bool has_joints = false;     ///< robot.csv has `actual_q_0` to `_5`
  BagImportDrops drops;
  BagProblems problems;
  std::vector<std::string> warnings;  ///< a sentence each
  std::uint64_t bytes_in = 0, bytes_out = 0;
};

bool is_ros_bag(const std::filesystem::path& file);  ///< ends in .bag, whatever its case

/// @throws Error  that names the command which makes a ROS 1 bag of it, if `file` is a ROS 2 bag: .db3, .mcap, or their folder
void refuse_ros2_bag(const std::filesystem::path& file);

/// Makes a run folder, whole or not at all, of a ROS 1 bag: `events.aedat4` (with the IMU), `robot.csv`, `video.mp4`, `video.csv`
/// and `run.json`, as far as the bag has what they are made of. The bag is read twice; memory follows the chunk and the message.
///
/// - `complete` in run.json is false if the bag is cut off or has a chunk that cannot be read.
/// - Events keep their own stamps as camera time. Those up to 20 ms out of order are sorted, earlier ones dropped and counted.
/// - A bag holds no controller time: `timestamp` is the transform's stamp in seconds, and run.json says `"robot_clock": "host"`.
///   A row is a pose; its joint positions are the newest before it, its speed the pose's difference from the row before to the
///   row behind, divided by the time between. `host_time_us` is when the bag's recorder got it.
/// - Frames have the time from the first one's stamp to theirs; an odd width or height gains one pixel, for H.264 has even ones.
///
/// @param folder  DATA/<object>/<run>, which must not exist
/// @throws Error  if the bag cannot be read, has no event, or several topics of a kind and none is chosen; if events come in an
///                encoding that is not known, as the images of a topic that is chosen by name do; if a topic's type has another
///                definition, or the run exists already
BagImportSummary import_bag(const std::filesystem::path& bag, const std::filesystem::path& folder,
                            const BagImportOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile
