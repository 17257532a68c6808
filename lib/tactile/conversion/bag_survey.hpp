#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/bags/bag.hpp"
#include "tactile/conversion/bag_import.hpp"
#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/events/event.hpp"

// The first of the two readings of a bag: its topics, and the choice of those that the run uses.
namespace tactile::conversion {

/// The kinds of topics, each with its option and a description.
enum class BagTopicKind : std::uint8_t { events, joints, pose, video, imu };
struct BagTopicKindNames {
  BagTopicKind kind;
  std::string_view use, option, what;
  std::string BagImportOptions::*choice;
};
inline constexpr std::array bag_topic_kinds{
    BagTopicKindNames{BagTopicKind::events, "events", "--events-topic", "events", &BagImportOptions::events_topic},
    BagTopicKindNames{BagTopicKind::joints, "joints", "--joints-topic", "joint states of the robot",
                      &BagImportOptions::joints_topic},
    BagTopicKindNames{BagTopicKind::pose, "pose", "--pose-topic", "poses of the tool in the frame base",
                      &BagImportOptions::pose_topic},
    BagTopicKindNames{BagTopicKind::video, "video", "--video-topic", "images", &BagImportOptions::video_topic},
    BagTopicKindNames{BagTopicKind::imu, "imu", "--imu-topic", "samples of an IMU", &BagImportOptions::imu_topic}};

std::optional<BagTopicKind> bag_topic_kind_of(bags::RosMessage message);

/// A topic as the first reading found it.
struct SurveyedTopic {
  std::string type, md5sum;
  bags::RosMessage message = bags::RosMessage::other;
  std::uint64_t messages = 0;
  std::uint64_t useful = 0;                         ///< that have events, a known joint, or the pose
  JointStates first_joints;                         ///< the first known of each, of up to 64 arms
  std::optional<events::SensorSize> size;           ///< of the first message that can be decoded
  std::string encoding;                             ///< of its events or image
  std::optional<events::SensorSize> unusable_size;  ///< of the first image that is too large for a video
  std::string other_encoding;                       ///< the first unknown encoding of events
};

struct BagSurvey {
  std::map<std::string, SurveyedTopic> topics;
  bags::BagProblems problems;
};

/// Reads the bag to its end. @throws Error  if it cannot be read, or has more than 4096 topics
BagSurvey survey_bag(bags::BagReader& bag, const ProgressCallback& progress, const std::string& name);

/// Of which arms a topic has all six joints.
std::vector<std::string> arms_of(const SurveyedTopic& topic);

/// The topic used for each kind.
using BagTopicChoice = std::map<BagTopicKind, std::string>;

/// @param warnings  receives a sentence for everything that the run omits
/// @throws Error  as `import_bag`, if topics are missing or ambiguous
BagTopicChoice choose_topics(const std::string& bag, const BagSurvey& found, const BagImportOptions& options,
                             std::vector<std::string>& warnings);

/// The damage to a bag, as the end of a sentence; empty if there is none.
std::string damage_text(const bags::BagProblems& problems);

}  // namespace tactile::conversion
