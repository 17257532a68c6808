#include "record_preview.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <system_error>

#include "quantity_text.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/machine.hpp"

namespace tactile::cli {
namespace {

using Steady = std::chrono::steady_clock;

constexpr std::chrono::seconds silent_after{2};
constexpr double least_minutes = 10;
constexpr std::uintmax_t least_bytes = 1'000'000'000;

bool has_imu(const capture::RunRecorder& recorder) {
  const auto& streams = recorder.streams();
  return std::any_of(streams.begin(), streams.end(),
                     [](const events::Stream& stream) { return stream.type == events::StreamType::imu; });
}

/// Room on the disk of the runs, and for how long it lasts at the run's pace.
nlohmann::json disk_json(const std::filesystem::path& data, const capture::RunState* run, std::vector<std::string>& warnings) {
  const std::optional<std::uint64_t> free = free_bytes_at(data);
  if (!free) return nullptr;
  nlohmann::json json = {{"free_bytes", *free}, {"minutes", nullptr}};
  double minutes = least_minutes;
  if (run != nullptr && run->bytes > 0 && in_s(run->elapsed) > 1) {
    minutes = static_cast<double>(*free) * in_s(run->elapsed) / static_cast<double>(run->bytes) / 60;
    json["minutes"] = minutes;
  }
  if (minutes < least_minutes)
    warnings.push_back(fmt::format("the disk is full in {:.1f} min at this rate", minutes));
  else if (*free < least_bytes)
    warnings.push_back("the disk has only " + bytes_text(*free) + " left");
  return json;
}

nlohmann::json robot_json(const capture::RunRecorder& recorder, std::vector<std::string>& warnings) {
  if (recorder.robot() == nullptr) {
    if (!has_imu(recorder)) warnings.emplace_back("no robot and no IMU: a slip is known only by the order of the touches");
    return nullptr;
  }
  const robot::RobotMonitorState robot = recorder.robot()->state();
  if (!robot.connected) warnings.emplace_back("the robot is not connected: its motion is not in the log");
  if (!robot.error.empty()) warnings.push_back(robot.error);
  return {{"connected", robot.connected}, {"rate_hz", robot.rate_hz}, {"rows", robot.rows},
          {"gaps", robot.gaps},           {"missing", robot.missing}, {"reconnects", robot.reconnects}};
}

nlohmann::json video_json(const std::optional<video::VideoCaptureState>& video, std::vector<std::string>& warnings) {
  if (!video) return nullptr;
  if (!video->running) warnings.emplace_back("the video has ended or is lost");
  if (video->dropped > 0) warnings.push_back(counted(video->dropped, "frame") + " of the video dropped");
  return {{"running", video->running},
          {"frames_per_s", video->frames_per_second},
          {"frames", video->frames},
          {"dropped", video->dropped}};
}

nlohmann::json run_json(const capture::RunState& run, std::vector<std::string>& warnings) {
  const capture::LostElements lost = run.drops.total();
  if (lost.events + lost.others > 0)
    warnings.push_back(fmt::format("dropped: {}, {}", counted(lost.events, "event"), counted(lost.others, "other element")));
  else if (lost.packets > 0)
    warnings.push_back("dropped: " + counted(lost.packets, "packet"));
  return {{"elapsed_s", in_s(run.elapsed)}, {"events", run.events},         {"others", run.others}, {"bytes", run.bytes},
          {"queue_bytes", run.queue_bytes}, {"dropped", json_of(run.drops)}};
}

}  // namespace

std::string RecordPreview::open(const capture::RunRecorder& recorder) {
  return view_.open(
      {.sensor = recorder.streams().front().size.value(),
       .choose = [this](std::uint64_t question, const std::string& choice) { return choices_.choose(question, choice); }});
}

nlohmann::json RecordPreview::sources_json(const capture::RunRecorder& recorder, std::vector<std::string>& warnings) {
  const Steady::time_point now = Steady::now();
  const std::vector<capture::SourceState> sources = recorder.sources();
  seen_.resize(sources.size(), {.last = now, .counted_at = now});
  nlohmann::json all = nlohmann::json::array();
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const capture::SourceState& source = sources[i];
    SeenSource& seen = seen_[i];
    if (source.packets != seen.packets) seen.last = now;
    seen.packets = source.packets;
    if (now - seen.counted_at >= std::chrono::seconds(1)) {
      seen.packets_per_s = static_cast<double>(source.packets - seen.counted) / in_s(now - seen.counted_at);
      seen.counted = source.packets;
      seen.counted_at = now;
    }
    const bool is_silent = now - seen.last > silent_after;
    const char* state = !source.error.empty() ? "lost" : source.has_ended ? "ended" : is_silent ? "silent" : "sends";
    if (!source.error.empty()) {
      warnings.push_back(source.name + " is lost: " + source.error);
    } else if (!source.has_ended && is_silent) {
      warnings.push_back(fmt::format("nothing has come from {} for {:.0f} s", source.name, in_s(now - seen.last)));
    }
    all.push_back({{"name", source.name},
                   {"state", state},
                   {"packets_per_s", seen.packets_per_s},
                   {"error", source.error.empty() ? nlohmann::json() : nlohmann::json(source.error)}});
  }
  return all;
}

void RecordPreview::show(const RecordMoment& moment) {
  if (!view_.is_due()) return;
  std::vector<std::string> warnings;
  nlohmann::json state = {{"kind", "record"},
                          {"state", moment.state},
                          {"run", moment.run.empty() ? nlohmann::json() : nlohmann::json(moment.run)},
                          {"words", moment.words.empty() ? nlohmann::json() : nlohmann::json(moment.words)}};
  const RecordQuestion question = choices_.question();
  state["question"] = question.number;
  state["choices"] = nlohmann::json::array();
  for (const OfferedChoice& offered : question.offered)
    state["choices"].push_back({{"choice", name_of(offered.choice)}, {"words", offered.words}});
  state["recording"] = moment.now != nullptr ? run_json(*moment.now, warnings) : nlohmann::json();
  state["sources"] = sources_json(*moment.recorder, warnings);
  state["robot"] = robot_json(*moment.recorder, warnings);
  state["video"] = moment.now != nullptr ? video_json(moment.now->video, warnings) : nlohmann::json();
  state["disk"] = disk_json(data_, moment.now, warnings);
  state["warnings"] = warnings;
  view_.publish(std::move(state));
}

void RecordPreview::end(const capture::RunRecorder& recorder, const RecordedRuns& recorded) {
  std::vector<std::string> none;
  nlohmann::json runs = nlohmann::json::array();
  for (const capture::RunSummary& run : recorded.runs) runs.push_back(json_of(run));
  view_.end({{"kind", "record"},
             {"state", "ended"},
             {"run", nullptr},
             {"words", recorded.error.empty() ? nlohmann::json() : nlohmann::json(recorded.error)},
             {"recording", nullptr},
             {"sources", sources_json(recorder, none)},
             {"robot", nullptr},
             {"video", nullptr},
             {"disk", disk_json(data_, nullptr, none)},
             {"runs", runs},
             {"warnings", nlohmann::json::array()}});
}

}  // namespace tactile::cli
