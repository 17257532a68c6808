#include "tactile/conversion/bag_import.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <string_view>
#include <utility>

#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/video/video_writer.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view nothing = "none";
constexpr microseconds sorted_span{20'000};                 // messages of several threads overlap by less
constexpr std::size_t most_waiting = std::size_t{4} << 20;  // events; a faster camera's are sorted over less time
constexpr std::int32_t events_id = 0, imu_id = 2;           // as the vendor numbers its streams
constexpr std::size_t most_topics = 4096;
constexpr int most_video_side = 16'384;  // [px], of a frame that H.264 takes

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// The kinds of topics, each with its option and the types that serve it.
enum class Kind : std::uint8_t { events, joints, pose, video, imu };
struct KindNames {
  Kind kind;
  std::string_view use, option, what;
  std::string BagImportOptions::*choice;
};
constexpr std::array kinds{
    KindNames{Kind::events, "events", "--events-topic", "events", &BagImportOptions::events_topic},
    KindNames{Kind::joints, "joints", "--joints-topic", "joint states of the robot", &BagImportOptions::joints_topic},
    KindNames{Kind::pose, "pose", "--pose-topic", "transforms from base to tool0_controller", &BagImportOptions::pose_topic},
    KindNames{Kind::video, "video", "--video-topic", "images", &BagImportOptions::video_topic},
    KindNames{Kind::imu, "imu", "--imu-topic", "samples of an IMU", &BagImportOptions::imu_topic}};

std::optional<Kind> kind_of(RosMessage message) {
  switch (message) {
    case RosMessage::event_array:
    case RosMessage::event_packet:
      return Kind::events;
    case RosMessage::joint_state:
      return Kind::joints;
    case RosMessage::transforms:
      return Kind::pose;
    case RosMessage::image:
      return Kind::video;
    case RosMessage::imu:
      return Kind::imu;
    case RosMessage::other:
      break;
  }
  return std::nullopt;
}

/// Types that we decode, by name: one of these with another MD5 sum is another version of it.
constexpr std::array<std::string_view, 6> known_types{"dvs_msgs/EventArray",    "event_camera_msgs/EventPacket",
                                                      "sensor_msgs/JointState", "tf2_msgs/TFMessage",
                                                      "sensor_msgs/Image",      "sensor_msgs/Imu"};

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

struct Survey {
  std::map<std::string, SurveyedTopic> topics;
  BagProblems problems;
};

/// Decodes again and again into the same memory.
struct Decoded {
  RosEvents events;
  JointPositions joints;
  std::vector<ToolPose> poses;
  RosImage image;
};

void look_at(SurveyedTopic& topic, std::span<const std::byte> data, Decoded& decoded) {
  switch (topic.message) {
    case RosMessage::event_array:
      if (topic.size && topic.useful > 0) return;  // the second reading counts the rest
      if (!decode_event_array(data, decoded.events)) return;
      topic.size = decoded.events.size;
      if (!decoded.events.events.empty()) ++topic.useful;
      break;
    case RosMessage::event_packet: {
      if (topic.size && topic.useful > 0) return;
      const PacketDecoding decoding = decode_event_packet(data, decoded.events);
      if (decoding == PacketDecoding::broken) return;
      if (decoding == PacketDecoding::other_encoding && topic.other_encoding.empty())
        topic.other_encoding = decoded.events.encoding.substr(0, 64);
      topic.size = decoded.events.size;
      topic.encoding = decoded.events.encoding.substr(0, 64);
      if (!decoded.events.events.empty()) ++topic.useful;
      break;
    }
    case RosMessage::joint_state:
      if (!decode_joint_state(data, decoded.joints)) return;
      for (std::size_t i = 0; i < decoded.joints.size(); ++i) {
        if (!topic.first_joints.at(i)) topic.first_joints.at(i) = decoded.joints.at(i);
      }
      if (std::any_of(decoded.joints.begin(), decoded.joints.end(), [](const auto& q) { return q.has_value(); })) ++topic.useful;
      break;
    case RosMessage::transforms: {
      std::uint64_t unusable = 0;
      if (decode_tool_poses(data, decoded.poses, unusable) && !decoded.poses.empty()) ++topic.useful;
      break;
    }
    case RosMessage::image:
      if (topic.size || !decode_image(data, decoded.image)) return;
      topic.encoding = decoded.image.encoding;
      if (decoded.image.pixels.empty()) return;
      if (std::max(decoded.image.pixels.cols, decoded.image.pixels.rows) > most_video_side) {
        if (!topic.unusable_size) topic.unusable_size = SensorSize{decoded.image.pixels.cols, decoded.image.pixels.rows};
        return;
      }
      topic.size = SensorSize{decoded.image.pixels.cols, decoded.image.pixels.rows};
      ++topic.useful;
      break;
    case RosMessage::imu:
      ++topic.useful;
      break;
    case RosMessage::other:
      break;
  }
}

Survey survey(RosBagReader& bag, const ProgressCallback& progress, const std::string& name) {
  Survey found;
  Decoded decoded;
  while (const auto message = bag.next()) {
    const BagConnection& connection = *message->connection;
    if (found.topics.size() == most_topics && !found.topics.contains(connection.topic))
      throw Error(fmt::format("{}: has more than {} topics; expected fewer", name, most_topics));
    SurveyedTopic& topic = found.topics[connection.topic];
    if (topic.messages++ == 0) {
      topic.type = connection.type;
      topic.md5sum = connection.md5sum;
      topic.message = ros_message_with(connection.md5sum);
    }
    if (connection.md5sum == topic.md5sum) look_at(topic, message->data, decoded);
    tell(progress, bag.bytes_read() / 2, bag.file_size(), name);
  }
  found.problems = bag.problems();
  return found;
}

/// The topic taken for each kind.
using Choice = std::map<Kind, std::string>;

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.size() > 400 ? list.substr(0, 400) + "..." : list;
}

std::string topics_text(const Survey& found) {
  std::vector<std::string> names;
  for (const auto& [name, topic] : found.topics) names.push_back(fmt::format("{} ({})", name, topic.type));
  return names.empty() ? "no message at all" : list_of(names);
}

/// What a bag lost, for the end of a sentence; empty of a sound one.
std::string damage_text(const BagProblems& problems) {
  std::string text;
  if (problems.truncated_bytes > 0) text += fmt::format("; {} bytes cut off", problems.truncated_bytes);
  if (problems.broken_chunks > 0)
    text += fmt::format("{} {} chunks could not be read", text.empty() ? ";" : ",", problems.broken_chunks);
  return text;
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
  if (topic.message == RosMessage::other && std::find(known_types.begin(), known_types.end(), topic.type) != known_types.end()) {
    throw Error(fmt::format("{}: topic {} has a definition of {} that is not known (MD5 {}); expected the released one", bag,
                            name, topic.type, topic.md5sum.substr(0, 32)));
  }
  if (!topic.other_encoding.empty()) {
    throw Error(fmt::format("{}: topic {} has events encoded as '{}'; expected libcaer, libcaer_cmp or mono", bag, name,
                            topic.other_encoding));
  }
}

Choice choose_topics(const std::string& bag, const Survey& found, const BagImportOptions& options,
                     std::vector<std::string>& warnings) {
  Choice choice;
  for (const KindNames& kind : kinds) {
    const std::string& asked = options.*kind.choice;
    if (asked == nothing) {
      if (kind.kind == Kind::events)
        throw Error(fmt::format("{}: a run without events is none; expected a topic's name", kind.option));
      continue;
    }
    std::vector<std::string> able;
    for (const auto& [name, topic] : found.topics) {
      const bool is_fit = kind_of(topic.message) == kind.kind;
      // Links of the robot and joints of a gripper come as the same types; only topics with what we look for count.
      const bool is_useful = topic.useful > 0 || kind.kind == Kind::events || kind.kind == Kind::video;
      if (name == asked && is_fit && is_useful) able = {name};
      if (asked.empty() && is_fit && is_useful) able.push_back(name);
    }
    if (!asked.empty() && able.empty()) {
      const auto there = found.topics.find(asked);
      if (there != found.topics.end()) check_topic(bag, asked, there->second);
      throw Error(
          fmt::format("{}: has no topic {} with {}; expected one of its own: {}", bag, asked, kind.what, topics_text(found)));
    }
    if (able.size() > 1) {
      throw Error(fmt::format("{}: {} topics hold {}: {}; expected a choice by {}", bag, able.size(), kind.what, list_of(able),
                              kind.option));
    }
    if (able.size() == 1) {
      check_topic(bag, able.front(), found.topics.at(able.front()));
      choice[kind.kind] = able.front();
    }
  }
  if (!choice.contains(Kind::events)) {
    for (const auto& [name, topic] : found.topics) check_topic(bag, name, topic);  // the reason may be a version
    throw Error(fmt::format("{}: no topic holds events; expected dvs_msgs/EventArray or event_camera_msgs/EventPacket among {}{}",
                            bag, topics_text(found), damage_text(found.problems)));
  }
  const std::string& events = choice.at(Kind::events);
  if (!found.topics.at(events).size)
    throw Error(fmt::format("{}: topic {} holds no message that can be decoded; expected events{}", bag, events,
                            damage_text(found.problems)));

  if (choice.contains(Kind::joints) && !choice.contains(Kind::pose)) {
    warnings.push_back(
        fmt::format("{}: {} has joint positions, but no topic a transform from base to tool0_controller, which a robot "
                    "log needs; the run has no robot.csv",
                    bag, choice.at(Kind::joints)));
    choice.erase(Kind::joints);
  }
  if (const auto joints = choice.find(Kind::joints); joints != choice.end()) {
    const JointPositions& known = found.topics.at(joints->second).first_joints;
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (known.at(i)) continue;
      warnings.push_back(fmt::format("{}: {} never names {}; robot.csv has no actual_q", bag, joints->second, joint_names.at(i)));
      choice.erase(joints);
      break;
    }
  }
  if (const auto video = choice.find(Kind::video); video != choice.end() && !found.topics.at(video->second).size) {
    const std::string why = unusable_text(found.topics.at(video->second));
    if (!options.video_topic.empty())
      throw Error(fmt::format("{}: topic {} {}; expected images as mono8, bgr8, rgb8 or the like", bag, video->second, why));
    warnings.push_back(fmt::format("{}: {} {}; the run has no video", bag, video->second, why));
    choice.erase(video);
  }
  return choice;
}

/// A text file written line by line.
class LineFile {
 public:
  LineFile(const fs::path& file, std::string_view header) : name_(file.string()), file_(std::fopen(file.c_str(), "wbxe")) {
    if (!file_) throw Error(name_ + ": cannot be made (" + std::strerror(errno) + "); expected a writable folder");
    write(std::string(header) + "\n");
  }
  void write(const std::string& line) {
    if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size()) fail();
  }
  void close() {
    if (std::fclose(file_.release()) != 0) fail();
    sync_to_disk(name_);
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(name_ + ": cannot be written (" + std::strerror(errno) + "); expected a place with room");
  }
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string name_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// Events in the order of time, held back as long as others may come before them.
class EventSorter {
 public:
  EventSorter(RecordingWriter& writer, BagImportSummary& summary) : writer_(writer), summary_(summary) {}

  void add(std::span<const Event> events) {
    for (const Event& event : events) {
      if (any_written_ && event.t < written_) {
        ++summary_.drops.late_events;
        continue;
      }
      if (!waiting_.empty() && event.t < waiting_.back().t) {
        ++summary_.sorted_events;
        is_sorted_ = false;
      }
      newest_ = waiting_.empty() && !any_written_ ? event.t : std::max(newest_, event.t);
      waiting_.push_back(event);
    }
    put(waiting_.size() > most_waiting ? CameraTime::max() : before(newest_, sorted_span));
  }
  void finish() { put(CameraTime::max()); }

 private:
  void put(CameraTime until) {
    if (waiting_.empty()) return;
    if (!is_sorted_) std::stable_sort(waiting_.begin(), waiting_.end(), [](const Event& a, const Event& b) { return a.t < b.t; });
    is_sorted_ = true;
    const auto end = std::partition_point(waiting_.begin(), waiting_.end(), [&](const Event& e) { return e.t <= until; });
    if (end == waiting_.begin()) return;
    if (!any_written_) summary_.first = waiting_.front().t;
    any_written_ = true;
    written_ = summary_.last = std::prev(end)->t;
    summary_.events += static_cast<std::uint64_t>(end - waiting_.begin());
    writer_.write_events(events_id, {waiting_.begin(), end});
    waiting_.erase(waiting_.begin(), end);
  }

  RecordingWriter& writer_;
  BagImportSummary& summary_;
  std::vector<Event> waiting_;
  CameraTime newest_{}, written_{};
  bool any_written_ = false, is_sorted_ = true;
};

/// robot.csv, a row behind what comes: a row's speed needs the row behind it.
class RobotRows {
 public:
  RobotRows(const fs::path& file, std::optional<JointPositions> joints)
      : joints_(joints), file_(file, header(joints.has_value())) {}

  void set(const JointPositions& joints) {
    for (std::size_t i = 0; joints_ && i < joints.size(); ++i) {
      if (joints.at(i)) joints_->at(i) = joints.at(i);
    }
  }
  /// Whether the row is later than the one before; another is left out.
  bool add(const ToolPose& pose, HostTime received) {
    if (current_ && pose.t <= current_->pose.t) return false;
    if (current_) write(*current_, previous_ ? previous_->pose : current_->pose, pose);
    previous_ = current_;
    current_ = Row{pose, received, joints_.value_or(JointPositions{})};
    ++rows_;
    return true;
  }
  std::uint64_t rows() const { return rows_; }
  void close() {
    if (current_) write(*current_, previous_ ? previous_->pose : current_->pose, current_->pose);
    file_.close();
  }

 private:
  struct Row {
    ToolPose pose;
    HostTime received;
    JointPositions joints;
  };

  static std::string header(bool has_joints) {
    std::string text = "timestamp";
    const auto add_six = [&](std::string_view name) {
      for (int i = 0; i < 6; ++i) text += fmt::format(",{}_{}", name, i);
    };
    if (has_joints) add_six("actual_q");
    add_six("actual_TCP_pose");
    add_six("actual_TCP_speed");
    return text + ",host_time_us";
  }

  void write(const Row& row, const ToolPose& before, const ToolPose& after) {
    const std::int64_t us = us_of(row.pose.t);
    std::string line = fmt::format("{}.{:06}", us / 1'000'000, us % 1'000'000);
    const auto add = [&](const auto& values) {
      for (const double value : values) line += fmt::format(",{}", value);
    };
    for (std::size_t i = 0; joints_ && i < row.joints.size(); ++i) line += fmt::format(",{}", row.joints.at(i).value_or(0));
    add(row.pose.place);
    add(rotation_vector(row.pose.turn));
    const double seconds = 1e-6 * static_cast<double>((after.t - before.t).count());
    std::array<double, 3> velocity{}, turning{};
    if (seconds > 0) {
      turning = rotation_vector(turn_between(before.turn, after.turn));
      for (std::size_t i = 0; i < 3; ++i) {
        velocity.at(i) = (after.place.at(i) - before.place.at(i)) / seconds;
        turning.at(i) /= seconds;
      }
    }
    add(velocity);
    add(turning);
    file_.write(line + fmt::format(",{}\n", us_of(row.received)));
  }

  std::optional<JointPositions> joints_;
  LineFile file_;
  std::optional<Row> previous_, current_;
  std::uint64_t rows_ = 0;
};

/// video.mp4 and video.csv.
class Film {
 public:
  Film(const RunFolder& run, SensorSize size)
      : size_(size),
        times_(run.video_times(), "index,pts_us,host_time_us"),
        writer_(run.video(), {.width = size.width + size.width % 2, .height = size.height + size.height % 2}) {}

  /// Whether the frame has the film's size and is later than the one before; another is left out.
  bool add(const RosImage& image, HostTime received) {
    if (image.pixels.cols != size_.width || image.pixels.rows != size_.height) return false;
    if (first_ && image.t <= last_) return false;
    if (!first_) first_ = image.t;
    last_ = image.t;
    const auto pts = VideoTime{image.t - *first_};
    cv::Mat even = image.pixels;
    if (size_.width % 2 != 0 || size_.height % 2 != 0)
      cv::copyMakeBorder(image.pixels, even, 0, size_.height % 2, 0, size_.width % 2, cv::BORDER_REPLICATE);
    writer_.write(even, pts);
    times_.write(fmt::format("{},{},{}\n", frames_++, us_of(pts), us_of(received)));
    return true;
  }
  std::uint64_t frames() const { return frames_; }
  std::optional<HostTime> first() const { return first_; }
  void close(const fs::path& video) {
    writer_.close();
    sync_to_disk(video);
    times_.close();
  }

 private:
  SensorSize size_;
  LineFile times_;
  VideoWriter writer_;
  std::optional<HostTime> first_;
  HostTime last_{};
  std::uint64_t frames_ = 0;
};

RunFolder run_named(const fs::path& folder) {
  fs::path plain = folder.lexically_normal();
  if (!plain.has_filename()) plain = plain.parent_path();  // a slash at the end
  RunFolder run{plain, plain.parent_path().filename().string(), plain.filename().string()};
  if (!is_object_name(run.object) || !is_run_id(run.run)) {
    throw Error(folder.string() +
                ": is no run folder; expected DATA/OBJECT/NN such as data/fan/01, the object in lower-case letters, " +
                "digits and hyphens, the run two digits from 01");
  }
  return run;
}

/// The second reading, into the files of `run`.
class Import {
 public:
  Import(const Survey& found, const Choice& choice, const BagImportOptions& options, const RunFolder& run,
         BagImportSummary& summary)
      : choice_(choice), summary_(summary) {
    std::vector<Stream> streams{event_stream_declaration(summary.size, choice.at(Kind::events))};
    if (choice.contains(Kind::imu)) {
      Stream imu;
      imu.id = imu_id;
      imu.type = StreamType::imu;
      imu.name = name_of(StreamType::imu);
      imu.source = streams.front().source;
      streams.push_back(imu);
    }
    writer_.emplace(run.events(), streams, RecordingWriterOptions{.compression = options.compression.value_or(Compression::lz4)});
    sorter_.emplace(*writer_, summary);
    if (choice.contains(Kind::pose)) {
      const auto joints = choice.find(Kind::joints);
      summary.has_joints = joints != choice.end();
      robot_.emplace(run.robot(),
                     joints == choice.end() ? std::nullopt : std::optional(found.topics.at(joints->second).first_joints));
    }
    if (const auto video = choice.find(Kind::video); video != choice.end())
      film_.emplace(run, *found.topics.at(video->second).size);
  }

  void take(const BagMessage& message) {
    const BagConnection& connection = *message.connection;
    const RosMessage type = ros_message_with(connection.md5sum);
    const std::optional<Kind> kind = kind_of(type);
    const auto chosen = kind ? choice_.find(*kind) : choice_.end();
    if (chosen == choice_.end() || chosen->second != connection.topic) return;
    begin = begin ? std::min(*begin, message.received) : message.received;
    end = end ? std::max(*end, message.received) : message.received;
    switch (*kind) {
      case Kind::events:
        take_events(type, message);
        break;
      case Kind::joints:
        if (!decode_joint_state(message.data, decoded_.joints)) ++summary_.drops.broken_messages;
        if (robot_) robot_->set(decoded_.joints);
        break;
      case Kind::pose:
        if (!decode_tool_poses(message.data, decoded_.poses, summary_.drops.robot_states)) ++summary_.drops.broken_messages;
        for (const ToolPose& pose : decoded_.poses) {
          if (!robot_->add(pose, message.received)) ++summary_.drops.robot_states;
        }
        break;
      case Kind::video:
        if (!decode_image(message.data, decoded_.image)) {
          ++summary_.drops.broken_messages;
        } else if (!film_->add(decoded_.image, message.received)) {
          ++summary_.drops.frames;
        }
        break;
      case Kind::imu:
        take_imu(message);
        break;
    }
  }

  void finish(const RunFolder& run) {
    sorter_->finish();
    writer_->close();
    if (robot_) {
      summary_.robot_states = robot_->rows();
      robot_->close();
    }
    if (film_) {
      summary_.frames = film_->frames();
      film_->close(run.video());
    }
  }

  std::optional<HostTime> first_frame() const { return film_ ? film_->first() : std::nullopt; }

  std::optional<HostTime> begin, end;  ///< of the messages taken, as the bag's recorder got them

 private:
  void take_events(RosMessage type, const BagMessage& message) {
    RosEvents& events = decoded_.events;
    if (type == RosMessage::event_array ? !decode_event_array(message.data, events)
                                        : decode_event_packet(message.data, events) != PacketDecoding::whole) {
      ++summary_.drops.broken_messages;
      return;
    }
    if (events.size != summary_.size) {  // another sensor's, which its declaration cannot hold
      ++summary_.drops.other_sensor_messages;
      return;
    }
    if (events.sequence) {
      if (sequence_ && *events.sequence > *sequence_ + 1) {
        const std::uint64_t missing = *events.sequence - *sequence_ - 1;
        if (__builtin_add_overflow(summary_.drops.event_packets, missing, &summary_.drops.event_packets))
          summary_.drops.event_packets = std::numeric_limits<std::uint64_t>::max();
      }
      sequence_ = events.sequence;
    }
    summary_.drops.events += events.outside;
    sorter_->add(events.events);
  }

  void take_imu(const BagMessage& message) {
    ImuSample sample;
    if (!decode_imu_message(message.data, sample)) {
      ++summary_.drops.broken_messages;
    } else if (newest_imu_ && sample.t <= *newest_imu_) {
      ++summary_.drops.imu_samples;
    } else {
      writer_->write_imu(imu_id, {&sample, 1});
      newest_imu_ = sample.t;
      ++summary_.imu_samples;
    }
  }

  const Choice& choice_;
  BagImportSummary& summary_;
  std::optional<RecordingWriter> writer_;
  std::optional<EventSorter> sorter_;
  std::optional<RobotRows> robot_;
  std::optional<Film> film_;
  std::optional<std::uint64_t> sequence_;
  std::optional<CameraTime> newest_imu_;
  Decoded decoded_;
};

nlohmann::json run_json_extra(const fs::path& bag, const Choice& choice, const Survey& found, const Import& import,
                              const BagImportSummary& summary, const RunFolder& written) {
  const SurveyedTopic& events = found.topics.at(choice.at(Kind::events));
  nlohmann::json camera = {{"source", choice.at(Kind::events)}, {"message", events.type}};
  if (!events.encoding.empty()) camera["encoding"] = events.encoding;
  nlohmann::json topics;
  for (const KindNames& kind : kinds) {
    if (choice.contains(kind.kind)) topics[std::string(kind.use)] = choice.at(kind.kind);
  }
  std::vector<fs::path> files{written.events(), written.robot(), written.video(), written.video_times()};
  std::erase_if(files, [](const fs::path& file) { return !fs::exists(file); });
  const BagImportDrops& drops = summary.drops;
  nlohmann::json extra = {{"camera", camera},
                          {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
                          {"host_time_us", {{"begin", us_of(*import.begin)}, {"end", us_of(*import.end)}}},
                          {"dropped",
                           {{"events", drops.events},
                            {"late_events", drops.late_events},
                            {"event_packets", drops.event_packets},
                            {"robot_packages", drops.robot_states},
                            {"frames", drops.frames},
                            {"imu_samples", drops.imu_samples},
                            {"broken_messages", drops.broken_messages},
                            {"other_sensor_messages", drops.other_sensor_messages}}},
                          {"files", files_json(files)},
                          {"bag",
                           {{"file", bag.filename().string()},
                            {"bytes", fs::file_size(bag)},
                            {"sha256", sha256_of_file(bag)},
                            {"topics", topics},
                            {"problems",
                             {{"truncated_bytes", summary.problems.truncated_bytes},
                              {"broken_chunks", summary.problems.broken_chunks},
                              {"broken_records", summary.problems.broken_records},
                              {"unknown_messages", summary.problems.unknown_messages}}}}}};
  if (choice.contains(Kind::pose)) {
    extra["robot_clock"] = "host";
    extra["robot_speed"] = "differences of the pose";
  }
  if (import.first_frame()) extra["video_start_us"] = us_of(*import.first_frame());
  return extra;
}

}  // namespace

bool is_ros_bag(const fs::path& file) { return lower_extension(file) == ".bag"; }

void refuse_ros2_bag(const fs::path& file) {
  const std::string extension = lower_extension(file);
  if (extension != ".db3" && extension != ".mcap" && !fs::exists(file / "metadata.yaml")) return;
  const fs::path plain = file.has_filename() ? file : file.parent_path();
  throw Error(
      fmt::format("{0}: is a ROS 2 bag; expected a ROS 1 bag, such as 'rosbags-convert --src {0} --dst {1}.bag' of the Python "
                  "package rosbags makes of it",
                  plain.string(), plain.stem().string()));
}

BagImportSummary import_bag(const fs::path& bag, const fs::path& folder, const BagImportOptions& options,
                            const ProgressCallback& progress) {
  BagImportSummary summary;
  summary.run = run_named(folder);
  if (fs::exists(fs::symlink_status(summary.run.folder)))
    throw Error(summary.run.folder.string() + ": is there already, and a run is never written over; expected a free run");
  if (!fs::is_regular_file(bag)) throw Error(bag.string() + ": no such file; expected a ROS 1 bag");
  const std::string name = bag.string();
  RosBagReader reader(bag);
  const Survey found = survey(reader, progress, bag.filename().string());
  const Choice choice = choose_topics(name, found, options, summary.warnings);
  summary.size = *found.topics.at(choice.at(Kind::events)).size;
  for (const auto& [topic, surveyed] : found.topics) {
    BagTopic& listed = summary.topics.emplace_back(BagTopic{topic, surveyed.type, surveyed.messages, {}});
    for (const KindNames& kind : kinds) {
      const auto chosen = choice.find(kind.kind);
      if (chosen != choice.end() && chosen->second == topic) listed.use = kind.use;
    }
  }

  remove_leftovers(summary.run.folder);
  WholeFile whole(summary.run.folder);
  fs::create_directory(whole.path());
  const RunFolder written{whole.path(), summary.run.object, summary.run.run};
  Import import(found, choice, options, written, summary);
  reader.rewind();
  while (const auto message = reader.next()) {
    import.take(*message);
    tell(progress, reader.file_size() / 2 + reader.bytes_read() / 2, reader.file_size(), summary.run.name());
  }
  import.finish(written);
  summary.problems = reader.problems();
  if (summary.events == 0)
    throw Error(fmt::format("{}: topic {} holds no event; expected some{}", name, choice.at(Kind::events),
                            damage_text(summary.problems)));

  write_run_info(written, {.object = summary.run.object,
                           .run = summary.run.run,
                           .session = {},
                           .simulated = false,
                           .complete = summary.problems.truncated_bytes == 0 && summary.problems.broken_chunks == 0,
                           .width = summary.size.width,
                           .height = summary.size.height,
                           .extra = run_json_extra(bag, choice, found, import, summary, written)});
  whole.commit();
  summary.bytes_in = fs::file_size(bag);
  for (const fs::directory_entry& file : fs::directory_iterator(summary.run.folder)) summary.bytes_out += file.file_size();
  return summary;
}

}  // namespace tactile
