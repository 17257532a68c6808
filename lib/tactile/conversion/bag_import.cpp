#include "tactile/conversion/bag_import.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "tactile/bags/ros_events.hpp"
#include "tactile/conversion/bag_survey.hpp"
#include "tactile/conversion/convert.hpp"
#include "tactile/conversion/imported_files.hpp"
#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::conversion {
namespace fs = std::filesystem;
namespace {

constexpr std::int32_t events_id = 0, imu_id = 2, triggers_id = 3;  // the vendor's stream ids

RunFolder run_named(const fs::path& folder) {
  fs::path plain = folder.lexically_normal();
  if (!plain.has_filename()) plain = plain.parent_path();  // a slash at the end
  RunFolder run{plain, plain.parent_path().filename().string(), plain.filename().string()};
  if (!is_object_name(run.object) || !is_run_id(run.run)) {
    throw Error(folder.string() +
                ": is not a run folder; expected DATA/OBJECT/NN such as data/fan/01, the object in lower-case letters, " +
                "digits and hyphens, the run two digits from 01");
  }
  return run;
}

events::Stream further_stream(std::int32_t id, events::StreamType type, const std::string& source) {
  events::Stream stream;
  stream.id = id;
  stream.type = type;
  stream.name = name_of(type);
  stream.source = source;
  return stream;
}

/// The second reading. It writes the files of `run`.
class Import {
 public:
  Import(const BagSurvey& found, const BagTopicChoice& choice, const BagImportOptions& options, const RunFolder& run,
         BagImportSummary& summary)
      : choice_(choice), summary_(summary) {
    std::vector<events::Stream> streams{events::event_stream_declaration(summary.size, choice.at(BagTopicKind::events))};
    if (choice.contains(BagTopicKind::imu))
      streams.push_back(further_stream(imu_id, events::StreamType::imu, streams.front().source));
    has_triggers_ = found.topics.at(choice.at(BagTopicKind::events)).encoding == "evt3";
    if (has_triggers_) streams.push_back(further_stream(triggers_id, events::StreamType::triggers, streams.front().source));
    writer_.emplace(run.events(), streams,
                    events::RecordingWriterOptions{.compression = options.compression.value_or(events::Compression::lz4)});
    sorter_.emplace(*writer_, events_id);
    std::optional<JointPositions> first_joints;
    if (const auto joints = choice.find(BagTopicKind::joints); joints != choice.end()) {
      const SurveyedTopic& topic = found.topics.at(joints->second);
      arm_ = arms_of(topic).front();
      first_joints = topic.first_joints.arms.at(arm_);
    }
    summary.has_joints = first_joints.has_value();
    summary.has_poses = choice.contains(BagTopicKind::pose);
    if (summary.has_joints || summary.has_poses) robot_.emplace(run.robot(), first_joints, summary.has_poses);
    if (const auto video = choice.find(BagTopicKind::video); video != choice.end())
      film_.emplace(run, *found.topics.at(video->second).size);
  }

  void take(const bags::BagMessage& message) {
    const bags::BagConnection& connection = *message.connection;
    const bags::RosMessage type = connection.message;
    const std::optional<BagTopicKind> kind = bag_topic_kind_of(type);
    const auto chosen = kind ? choice_.find(*kind) : choice_.end();
    if (chosen == choice_.end() || chosen->second != connection.topic) return;
    begin = begin ? std::min(*begin, message.received) : message.received;
    end = end ? std::max(*end, message.received) : message.received;
    switch (*kind) {
      case BagTopicKind::events:
        take_events(type, message);
        break;
      case BagTopicKind::joints:
        if (!decode_joint_state(message.serialised(), joints_)) {
          ++summary_.drops.broken_messages;
        } else if (const auto of_arm = joints_.arms.find(arm_); of_arm != joints_.arms.end()) {
          robot_->set(of_arm->second);
          if (!summary_.has_poses && !robot_->add(joints_.t, message.received)) ++summary_.drops.robot_states;
        }
        break;
      case BagTopicKind::pose:
        if (!decode_poses(type, message.serialised(), poses_, summary_.drops.robot_states)) ++summary_.drops.broken_messages;
        for (const ToolPose& pose : poses_) {
          if (!robot_->add(pose, message.received)) ++summary_.drops.robot_states;
        }
        break;
      case BagTopicKind::video:
        if (!decode_any_image(type, message.serialised(), image_)) {
          ++summary_.drops.broken_messages;
        } else if (!film_->add(image_, message.received)) {
          ++summary_.drops.frames;
        }
        break;
      case BagTopicKind::imu:
        take_imu(message);
        break;
    }
  }

  void finish() {
    sorter_->finish();
    writer_->close();
    summary_.events = sorter_->written();
    summary_.sorted_events = sorter_->sorted();
    summary_.drops.late_events = sorter_->late();
    summary_.first = sorter_->first();
    summary_.last = sorter_->last();
    if (robot_) {
      summary_.robot_states = robot_->rows();
      robot_->close();
    }
    if (film_) {
      summary_.frames = film_->frames();
      film_->close();
    }
  }

  std::optional<HostTime> first_frame() const { return film_ ? film_->first() : std::nullopt; }

  std::optional<HostTime> begin, end;  ///< times at which the recorder received the used messages

 private:
  void take_events(bags::RosMessage type, const bags::BagMessage& message) {
    if (type == bags::RosMessage::event_array ? !bags::decode_event_array(message.serialised(), events_)
                                              : packets_.decode(message.serialised(), events_) != bags::PacketDecoding::whole) {
      ++summary_.drops.broken_messages;
      return;
    }
    if (events_.size != summary_.size) {  // of another sensor, which the stream's declaration excludes
      ++summary_.drops.other_sensor_messages;
      return;
    }
    if (__builtin_add_overflow(summary_.drops.event_packets, events_.lost_packets, &summary_.drops.event_packets))
      summary_.drops.event_packets = std::numeric_limits<std::uint64_t>::max();
    summary_.drops.unplaced_events += events_.unplaced;
    take_triggers();
    summary_.drops.events += events_.outside;
    sorter_->add(events_.events);
  }

  void take_triggers() {
    for (const events::Evt3Trigger& edge : events_.triggers) {
      const events::Trigger trigger = events::trigger_of(edge);
      if (!has_triggers_ || (newest_trigger_ && trigger.t < *newest_trigger_)) {
        ++summary_.drops.triggers;
        continue;
      }
      writer_->write_triggers(triggers_id, {&trigger, 1});
      newest_trigger_ = trigger.t;
      ++summary_.triggers;
    }
  }

  void take_imu(const bags::BagMessage& message) {
    events::ImuSample sample;
    if (!decode_imu_message(message.serialised(), sample)) {
      ++summary_.drops.broken_messages;
    } else if (newest_imu_ && sample.t <= *newest_imu_) {
      ++summary_.drops.imu_samples;
    } else {
      writer_->write_imu(imu_id, {&sample, 1});
      newest_imu_ = sample.t;
      ++summary_.imu_samples;
    }
  }

  const BagTopicChoice& choice_;
  BagImportSummary& summary_;
  bool has_triggers_ = false;
  std::optional<events::RecordingWriter> writer_;
  std::optional<EventSorter> sorter_;
  std::optional<ImportedRobotLog> robot_;
  std::optional<ImportedFilm> film_;
  std::optional<CameraTime> newest_imu_;
  std::string arm_;  ///< whose joints are used
  std::optional<CameraTime> newest_trigger_;
  bags::EventPacketDecoder packets_;

  // Every message is decoded into the same memory.
  bags::RosEvents events_;
  JointStates joints_;
  std::vector<ToolPose> poses_;
  RosImage image_;
};

/// The name of a file, or of a folder with or without a slash at its end.
std::string file_name_of(const fs::path& place) {
  return (place.has_filename() ? place : place.parent_path()).filename().string();
}

nlohmann::json run_json_extra(const fs::path& bag, const BagTopicChoice& choice, const BagSurvey& found, const Import& import,
                              const BagImportSummary& summary, const RunFolder& written) {
  const SurveyedTopic& events = found.topics.at(choice.at(BagTopicKind::events));
  nlohmann::json camera = {{"source", choice.at(BagTopicKind::events)}, {"message", events.type}};
  if (!events.encoding.empty()) camera["encoding"] = events.encoding;
  nlohmann::json topics;
  for (const BagTopicKindNames& kind : bag_topic_kinds) {
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
                            {"triggers", drops.triggers},
                            {"unplaced_events", drops.unplaced_events},
                            {"broken_messages", drops.broken_messages},
                            {"other_sensor_messages", drops.other_sensor_messages}}},
                          {"files", files_json(files)},
                          {"bag",
                           {{"file", file_name_of(bag)},
                            {"format", summary.format},
                            {"bytes", summary.bytes_in},
                            {"topics", topics},
                            {"problems",
                             {{"truncated_bytes", summary.problems.truncated_bytes},
                              {"broken_chunks", summary.problems.broken_chunks},
                              {"broken_records", summary.problems.broken_records},
                              {"unknown_messages", summary.problems.unknown_messages}}}}}};
  if (fs::is_directory(bag)) {
    extra["bag"]["files"] = files_json(bags::files_of_bag(bag));
  } else {
    extra["bag"]["sha256"] = sha256_of_file(bag);
  }
  if (summary.has_joints || summary.has_poses) extra["robot_clock"] = "host";
  if (summary.has_poses) extra["robot_speed"] = "differences of the pose";
  if (import.first_frame()) extra["video_start_us"] = us_of(*import.first_frame());
  return extra;
}

/// @throws Error  if the poses or joints of the bag make no robot log that can be read
void check_robot_log(const std::string& bag, const RunFolder& written) {
  if (!fs::exists(written.robot())) return;
  try {
    robot::read_robot_log(written.robot());
  } catch (const Error& e) {
    std::string why = e.what();
    if (const std::string folder = written.folder.string() + "/"; why.starts_with(folder)) why.erase(0, folder.size());
    throw Error(fmt::format("{}: {}; or leave the robot out, with --pose-topic none --joints-topic none", bag, why));
  }
}

}  // namespace

BagImportSummary import_bag(const fs::path& bag, const fs::path& folder, const BagImportOptions& options,
                            const ProgressCallback& progress) {
  BagImportSummary summary;
  summary.run = run_named(folder);
  if (fs::exists(fs::symlink_status(summary.run.folder)))
    throw Error(summary.run.folder.string() + ": exists already; expected a new run, runs are never replaced");
  const std::string name = bag.string();
  const std::unique_ptr<bags::BagReader> reader = bags::open_bag(bag);
  summary.format = reader->format();
  summary.bytes_in = reader->file_size();
  const BagSurvey found = survey_bag(*reader, progress, file_name_of(bag));
  const BagTopicChoice choice = choose_topics(name, found, options, summary.warnings);
  summary.size = *found.topics.at(choice.at(BagTopicKind::events)).size;
  for (const auto& [topic, surveyed] : found.topics) {
    BagTopic& listed = summary.topics.emplace_back(BagTopic{topic, surveyed.type, surveyed.messages, {}});
    for (const BagTopicKindNames& kind : bag_topic_kinds) {
      const auto chosen = choice.find(kind.kind);
      if (chosen != choice.end() && chosen->second == topic) listed.use = kind.use;
    }
  }

  WholeFile whole(summary.run.folder, IfThere::refuse);
  fs::create_directory(whole.path());
  const RunFolder written{whole.path(), summary.run.object, summary.run.run};
  Import import(found, choice, options, written, summary);
  reader->rewind();
  while (const auto message = reader->next()) {
    import.take(*message);
    report_progress(progress, reader->file_size() / 2 + reader->bytes_read() / 2, reader->file_size(), summary.run.name());
  }
  import.finish();
  check_robot_log(name, written);
  summary.problems = reader->problems();
  if (summary.events == 0)
    throw Error(fmt::format("{}: topic {} has no event; expected events{}", name, choice.at(BagTopicKind::events),
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
  for (const fs::directory_entry& file : fs::directory_iterator(summary.run.folder)) summary.bytes_out += file.file_size();
  return summary;
}

}  // namespace tactile::conversion
