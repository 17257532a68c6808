#include "tactile/conversion/bag_survey.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/bags/ros_events.hpp"
#include "tactile/core/error.hpp"

namespace tactile::conversion {
namespace {

constexpr std::string_view nothing = "none";
constexpr std::size_t most_topics = 4096;
constexpr std::size_t most_arms = 64;    // of a topic
constexpr int most_video_side = 16'384;  // [px], the limit of H.264

/// The types that we decode. One of these with another MD5 sum is another version.
constexpr std::array<std::string_view, 8> known_types{"dvs_msgs/EventArray",         "event_camera_msgs/EventPacket",
                                                      "sensor_msgs/JointState",      "tf2_msgs/TFMessage",
                                                      "geometry_msgs/PoseStamped",   "sensor_msgs/Image",
                                                      "sensor_msgs/CompressedImage", "sensor_msgs/Imu"};

/// Memory that every message is decoded into.
struct Decoded {
  bags::RosEvents events;
  JointStates joints;
  std::vector<ToolPose> poses;
  RosImage image;
};

void look_at(SurveyedTopic& topic, bags::SerialisedMessage data, Decoded& decoded) {
  switch (topic.message) {
    case bags::RosMessage::event_array:
      if (topic.size && topic.useful > 0) return;  // the second reading counts the rest
      if (!bags::decode_event_array(data, decoded.events)) return;
      topic.size = decoded.events.size;
      if (!decoded.events.events.empty()) ++topic.useful;
      break;
    case bags::RosMessage::event_packet: {
      if (topic.size && topic.useful > 0) return;
      const bags::PacketDecoding decoding = bags::EventPacketDecoder().decode(data, decoded.events);
      if (decoding == bags::PacketDecoding::broken) return;
      if (decoding == bags::PacketDecoding::other_encoding && topic.other_encoding.empty())
        topic.other_encoding = decoded.events.encoding.substr(0, 64);
      topic.size = decoded.events.size;
      topic.encoding = decoded.events.encoding.substr(0, 64);
      if (!decoded.events.events.empty()) ++topic.useful;
      break;
    }
    case bags::RosMessage::joint_state:
      if (!decode_joint_state(data, decoded.joints)) return;
      for (const auto& [arm, joints] : decoded.joints.arms) {
        if (topic.first_joints.arms.size() == most_arms && !topic.first_joints.arms.contains(arm)) continue;
        JointPositions& first = topic.first_joints.arms[arm];
        for (std::size_t i = 0; i < joints.size(); ++i) {
          if (!first.at(i)) first.at(i) = joints.at(i);
        }
      }
      if (!decoded.joints.arms.empty()) ++topic.useful;
      break;
    case bags::RosMessage::transforms:
    case bags::RosMessage::pose: {
      std::uint64_t unusable = 0;
      if (decode_poses(topic.message, data, decoded.poses, unusable) && !decoded.poses.empty()) ++topic.useful;
      break;
    }
    case bags::RosMessage::image:
    case bags::RosMessage::compressed_image:
      if (topic.size || !decode_any_image(topic.message, data, decoded.image)) return;
      topic.encoding = decoded.image.encoding;
      if (decoded.image.pixels.empty()) return;
      if (std::max(decoded.image.pixels.cols, decoded.image.pixels.rows) > most_video_side) {
        if (!topic.unusable_size) topic.unusable_size = events::SensorSize{decoded.image.pixels.cols, decoded.image.pixels.rows};
        return;
      }
      topic.size = events::SensorSize{decoded.image.pixels.cols, decoded.image.pixels.rows};
      ++topic.useful;
      break;
    case bags::RosMessage::imu:
      ++topic.useful;
      break;
    case bags::RosMessage::other:
      break;
  }
}

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.size() > 400 ? list.substr(0, 400) + "..." : list;
}

std::string topics_text(const BagSurvey& found) {
  std::vector<std::string> names;
  for (const auto& [name, topic] : found.topics) names.push_back(fmt::format("{} ({})", name, topic.type));
  return names.empty() ? "no message at all" : list_of(names);
}

/// Why a topic's images cannot become a video.
std::string unusable_text(const SurveyedTopic& topic) {
  if (topic.unusable_size) {
    return fmt::format("has images of {}x{} px, and a video holds at most {} px each way", topic.unusable_size->width,
                       topic.unusable_size->height, most_video_side);
  }
  if (topic.encoding.empty()) return "has no image that can be decoded";
  return fmt::format("has images encoded as '{}', which is not known", topic.encoding);
}

/// @throws Error if the topic's type is one of ours in another version, or its events come in an encoding that is not known
void check_topic(const std::string& bag, const std::string& name, const SurveyedTopic& topic) {
  if (topic.message == bags::RosMessage::other &&
      std::find(known_types.begin(), known_types.end(), topic.type) != known_types.end()) {
    throw Error(fmt::format("{}: topic {} has a definition of {} that is not known (MD5 {}); expected the released one", bag,
                            name, topic.type, topic.md5sum.substr(0, 32)));
  }
  if (!topic.other_encoding.empty()) {
    throw Error(fmt::format("{}: topic {} has events encoded as '{}'; expected libcaer, libcaer_cmp, mono or evt3", bag, name,
                            topic.other_encoding));
  }
}

/// The topic for one kind: the asked one, or the only suitable one. @return  nothing if there is none, or "none" was asked for
std::optional<std::string> choose_topic(const std::string& bag, const BagSurvey& found, const BagTopicKindNames& kind,
                                        const std::string& asked) {
  if (asked == nothing) {
    if (kind.kind == BagTopicKind::events)
      throw Error(fmt::format("{}: a run needs events; expected a topic's name", kind.option));
    return std::nullopt;
  }
  std::vector<std::string> able;
  for (const auto& [name, topic] : found.topics) {
    const bool is_fit = bag_topic_kind_of(topic.message) == kind.kind;
    // Other links of the robot, or a gripper's joints, have the same types. Only topics with the expected content count.
    const bool is_useful = topic.useful > 0 || kind.kind == BagTopicKind::events || kind.kind == BagTopicKind::video;
    if (is_fit && is_useful && (asked.empty() || name == asked)) able.push_back(name);
  }
  if (!asked.empty() && able.empty()) {
    const auto there = found.topics.find(asked);
    if (there != found.topics.end()) check_topic(bag, asked, there->second);
    throw Error(
        fmt::format("{}: has no topic {} with {}; expected one of its own: {}", bag, asked, kind.what, topics_text(found)));
  }
  if (kind.kind == BagTopicKind::pose && able.size() > 1) {  // the driver of ROS 2 publishes the tool twice
    const auto is_stamped = [&](const std::string& name) { return found.topics.at(name).message == bags::RosMessage::pose; };
    if (!std::all_of(able.begin(), able.end(), is_stamped)) std::erase_if(able, is_stamped);
  }
  if (able.size() > 1) {
    throw Error(fmt::format("{}: {} topics have {}: {}; expected a choice by {}", bag, able.size(), kind.what, list_of(able),
                            kind.option));
  }
  if (able.empty()) return std::nullopt;
  check_topic(bag, able.front(), found.topics.at(able.front()));
  return able.front();
}

/// Joint positions need one arm, and a value for every joint.
void drop_unusable_joints(const std::string& bag, const BagSurvey& found, BagTopicChoice& choice,
                          std::vector<std::string>& warnings) {
  const auto joints = choice.find(BagTopicKind::joints);
  if (joints == choice.end()) return;
  const SurveyedTopic& topic = found.topics.at(joints->second);
  const std::vector<std::string> arms = arms_of(topic);
  if (arms.size() == 1) return;
  const std::string lacks = choice.contains(BagTopicKind::pose) ? "robot.csv has no actual_q" : "the run has no robot.csv";
  if (arms.size() > 1) {
    warnings.push_back(fmt::format("{}: {} has the joints of {} arms, '{}{}' and '{}{}' among them; expected those of one; {}",
                                   bag, joints->second, arms.size(), arms[0], joint_names[0], arms[1], joint_names[0], lacks));
  } else {
    const auto& [arm, known] = *topic.first_joints.arms.begin();
    const auto missing = std::find(known.begin(), known.end(), std::nullopt) - known.begin();
    warnings.push_back(fmt::format("{}: {} never has a position of '{}{}'; {}", bag, joints->second, arm,
                                   joint_names.at(static_cast<std::size_t>(missing)), lacks));
  }
  choice.erase(joints);
}

}  // namespace

std::optional<BagTopicKind> bag_topic_kind_of(bags::RosMessage message) {
  switch (message) {
    case bags::RosMessage::event_array:
    case bags::RosMessage::event_packet:
      return BagTopicKind::events;
    case bags::RosMessage::joint_state:
      return BagTopicKind::joints;
    case bags::RosMessage::transforms:
    case bags::RosMessage::pose:
      return BagTopicKind::pose;
    case bags::RosMessage::image:
    case bags::RosMessage::compressed_image:
      return BagTopicKind::video;
    case bags::RosMessage::imu:
      return BagTopicKind::imu;
    case bags::RosMessage::other:
      break;
  }
  return std::nullopt;
}

std::vector<std::string> arms_of(const SurveyedTopic& topic) {
  std::vector<std::string> whole;
  for (const auto& [arm, joints] : topic.first_joints.arms) {
    if (std::find(joints.begin(), joints.end(), std::nullopt) == joints.end()) whole.push_back(arm);
  }
  return whole;
}

BagSurvey survey_bag(bags::BagReader& bag, const ProgressCallback& progress, const std::string& name) {
  BagSurvey found;
  Decoded decoded;
  while (const auto message = bag.next()) {
    const bags::BagConnection& connection = *message->connection;
    if (found.topics.size() == most_topics && !found.topics.contains(connection.topic))
      throw Error(fmt::format("{}: has more than {} topics; expected fewer", name, most_topics));
    SurveyedTopic& topic = found.topics[connection.topic];
    if (topic.messages++ == 0) {
      topic.type = connection.type;
      topic.md5sum = connection.md5sum;
      topic.message = connection.message;
    }
    if (connection.md5sum == topic.md5sum && connection.message == topic.message) look_at(topic, message->serialised(), decoded);
    report_progress(progress, bag.bytes_read() / 2, bag.file_size(), name);
  }
  found.problems = bag.problems();
  return found;
}

std::string damage_text(const bags::BagProblems& problems) {
  std::string text;
  if (problems.truncated_bytes > 0) text += fmt::format("; {} bytes cut off", problems.truncated_bytes);
  if (problems.broken_chunks > 0)
    text += fmt::format("{} {} chunks could not be read", text.empty() ? ";" : ",", problems.broken_chunks);
  return text;
}

BagTopicChoice choose_topics(const std::string& bag, const BagSurvey& found, const BagImportOptions& options,
                             std::vector<std::string>& warnings) {
  BagTopicChoice choice;
  for (const BagTopicKindNames& kind : bag_topic_kinds) {
    if (const auto topic = choose_topic(bag, found, kind, options.*kind.choice)) choice[kind.kind] = *topic;
  }
  if (!choice.contains(BagTopicKind::events)) {
    for (const auto& [name, topic] : found.topics) check_topic(bag, name, topic);  // the reason may be a version
    throw Error(fmt::format("{}: no topic has events; expected dvs_msgs/EventArray or event_camera_msgs/EventPacket among {}{}",
                            bag, topics_text(found), damage_text(found.problems)));
  }
  const std::string& events = choice.at(BagTopicKind::events);
  if (!found.topics.at(events).size)
    throw Error(fmt::format("{}: topic {} has no message that can be decoded; expected events{}", bag, events,
                            damage_text(found.problems)));
  drop_unusable_joints(bag, found, choice, warnings);
  if (const auto video = choice.find(BagTopicKind::video); video != choice.end() && !found.topics.at(video->second).size) {
    const std::string why = unusable_text(found.topics.at(video->second));
    if (!options.video_topic.empty())
      throw Error(fmt::format("{}: topic {} {}; expected images such as mono8, bgr8 or rgb8", bag, video->second, why));
    warnings.push_back(fmt::format("{}: {} {}; the run has no video", bag, video->second, why));
    choice.erase(video);
  }
  return choice;
}

}  // namespace tactile::conversion
