#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/bags/bag.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::conversion {

/// The topics to use. Empty: the only topic of its kind. "none": no topic; not allowed for events.
struct BagImportOptions {
  std::string events_topic{};  ///< dvs_msgs/EventArray or event_camera_msgs/EventPacket
  std::string joints_topic{};  ///< sensor_msgs/JointState that names the UR's joints, with a prefix or without
  std::string pose_topic{};    ///< tf2_msgs/TFMessage that has base -> tool0_controller, or geometry_msgs/PoseStamped in base
  std::string video_topic{};   ///< sensor_msgs/Image or CompressedImage
  std::string imu_topic{};     ///< sensor_msgs/Imu
  std::optional<events::Compression> compression{};  ///< of events.aedat4; default LZ4
};

/// What is missing in the run, lost before or during the import.
struct BagImportDrops {
  std::uint64_t events = 0;                 ///< outside the sensor
  std::uint64_t late_events = 0;            ///< more than 20 ms earlier than an event before them
  std::uint64_t event_packets = 0;          ///< gaps in the sequence numbers of EventPackets
  std::uint64_t broken_messages = 0;        ///< of the used topics, not decodable
  std::uint64_t other_sensor_messages = 0;  ///< of events from a sensor of another size
  std::uint64_t robot_states = 0;           ///< not a pose, not later than the one before, or too far from it
  std::uint64_t frames = 0;                 ///< of another size, or not later than the one before
  std::uint64_t imu_samples = 0;            ///< not later than the one before
  std::uint64_t triggers = 0;               ///< earlier than the one before
  std::uint64_t unplaced_events = 0;        ///< before the first time and row of `evt3`
};

struct BagTopic {
  std::string name, type;
  std::uint64_t messages = 0;
  std::string use;  ///< "events", "joints", "pose", "video", "imu"; empty: not used
};

/// What an import did.
struct BagImportSummary {
  RunFolder run;
  std::vector<BagTopic> topics;  ///< of the bag, by name
  std::string format;            ///< "ROS 2 bag (MCAP)"
  events::SensorSize size;
  std::uint64_t events = 0, sorted_events = 0, imu_samples = 0, triggers = 0, robot_states = 0, frames = 0;
  CameraTime first{}, last{};  ///< of the events
  bool has_joints = false;     ///< robot.csv has `actual_q_0` to `_5`
  bool has_poses = false;      ///< robot.csv has `actual_TCP_pose_0` to `_5`, and speeds
  BagImportDrops drops;
  bags::BagProblems problems;
  std::vector<std::string> warnings;  ///< a sentence each
  std::uint64_t bytes_in = 0, bytes_out = 0;
};

/// Makes a run folder of a bag of ROS 1 or ROS 2: `events.aedat4` (with the IMU), `robot.csv`, `video.mp4`, `video.csv` and
/// `run.json`, as far as the bag has the data. The folder appears only when it is complete. The bag is read twice; memory follows
/// the chunk and the message.
///
/// - `complete` in run.json is false if the bag is cut off or has a chunk that cannot be read.
/// - Events keep their own stamps as camera time. Events up to 20 ms out of order are sorted; earlier ones are dropped and
/// counted.
/// - A bag has no controller time: `timestamp` is the transform's stamp in seconds, and run.json has `"robot_clock": "host"`.
///   A row is a pose, or without poses a message of joint positions. A pose's joint positions are the newest before it. Its speed
///   is the difference of the poses in the next row and the row before, divided by the time between them. `host_time_us` is the
///   time at which the recorder received it.
/// - The time of a frame counts from the stamp of the first frame. An odd width or height gains one pixel, as H.264 requires.
///
/// @param folder  DATA/<object>/<run>, which must not exist
/// @throws Error  if the bag cannot be read, has no event, or has several topics of a kind and none is chosen; if events, or the
///                images of a topic chosen by name, have an unknown encoding; if `read_robot_log` refuses the log; if a topic's
///                type has another definition, or the run exists
BagImportSummary import_bag(const std::filesystem::path& bag, const std::filesystem::path& folder,
                            const BagImportOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile::conversion
