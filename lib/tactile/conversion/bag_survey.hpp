#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/conversion/bag_import.hpp"
#include "tactile/conversion/ros_bag.hpp"
#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/events/event.hpp"

// The first of the two readings of a bag: what it holds, and which of it a run is made of.
namespace tactile {

/// The kinds of topics, each with its option and the types that serve it.
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
    BagTopicKindNames{BagTopicKind::pose, "pose", "--pose-topic", "transforms from base to tool0_controller",
                      &BagImportOptions::pose_topic},
    BagTopicKindNames{BagTopicKind::video, "video", "--video-topic", "images", &BagImportOptions::video_topic},
    BagTopicKindNames{BagTopicKind::imu, "imu", "--imu-topic", "samples of an IMU", &BagImportOptions::imu_topic}};

std::optional<BagTopicKind> bag_topic_kind_of(RosMessage message);

/// What the first reading found of a topic.
struct SurveyedTopic {
  std::string type, md5sum;
  RosMessage message = RosMessage::other;
  std::uint64_t messages = 0;
  std::uint64_t useful = 0;                 ///< that hold what we look for: events, a joint, the pose
  JointPositions first_joints{};            ///< the first known of each
  std::optional<SensorSize> size;           ///< of the first message that decodes
  std::string encoding;                     ///< of its events or image
  std::optional<SensorSize> unusable_size;  ///< of the first image that no video can hold
  std::string other_encoding;               ///< of events, where one is not known
};

struct BagSurvey {
  std::map<std::string, SurveyedTopic> topics;
  BagProblems problems;
};

/// Reads the bag to its end. @throws Error  if it cannot be read, or has more than 4096 topics
BagSurvey survey_bag(RosBagReader& bag, const ProgressCallback& progress, const std::string& name);

/// The topic taken for each kind.
using BagTopicChoice = std::map<BagTopicKind, std::string>;

/// @throws Error  as `import_bag` does for what a bag lacks or has too much of. What is merely left out is told in `warnings`
BagTopicChoice choose_topics(const std::string& bag, const BagSurvey& found, const BagImportOptions& options,
                             std::vector<std::string>& warnings);

/// What a bag lost, for the end of a sentence; empty of a sound one.
std::string damage_text(const BagProblems& problems);

}  // namespace tactile
