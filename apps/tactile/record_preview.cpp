#include "record_preview.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include "quantity_text.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/video/film_picture.hpp"
#include "tactile/video/picture_codec.hpp"

namespace tactile::cli {
namespace {

using Steady = std::chrono::steady_clock;

constexpr std::chrono::seconds silent_after{2};
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

bool has_imu(const capture::RunRecorder& recorder) {
  const auto& streams = recorder.streams();
  return std::any_of(streams.begin(), streams.end(),
                     [](const events::Stream& stream) { return stream.type == events::StreamType::imu; });
}

std::optional<double> bytes_per_s(const capture::RunState* run) {
  if (run == nullptr || run->bytes == 0 || in_s(run->elapsed) <= 1) return std::nullopt;
  return static_cast<double>(run->bytes) / in_s(run->elapsed);
}

/// [mm/s, mm]: how fast the robot's tool moves, and its height; NaN while that is not known.
std::array<double, 2> tool_motion(const robot::RobotMonitor& robot) {
  const auto mm = [&](const char* column) { return 1e3 * robot.newest(column).value_or(unknown); };
  return {std::hypot(mm("actual_TCP_speed_0"), mm("actual_TCP_speed_1"), mm("actual_TCP_speed_2")), mm("actual_TCP_pose_2")};
}

nlohmann::json offset_json(const std::optional<ClockOffset>& clock) {
  if (!clock) return nullptr;
  return {{"offset_us", clock->offset.count()}, {"change_ms", in_ms(clock->change)}, {"seconds", in_s(clock->span)}};
}

nlohmann::json robot_json(const capture::RunRecorder& recorder, std::vector<std::string>& warnings) {
  if (recorder.robot() == nullptr) {
    if (!has_imu(recorder)) warnings.emplace_back("no robot and no IMU: press and slip are distinguished by the events alone");
    return nullptr;
  }
  if (!has_imu(recorder)) warnings.emplace_back("no IMU: the robot's clock is known less exactly");
  const robot::RobotMonitorState robot = recorder.robot()->state();
  if (!robot.connected) warnings.emplace_back("the robot is not connected: its motion is not in the log");
  if (!robot.error.empty()) warnings.push_back(robot.error);
  return {{"connected", robot.connected},
          {"rate_hz", robot.rate_hz},
          {"rows", robot.rows},
          {"gaps", robot.gaps},
          {"missing", robot.missing},
          {"reconnects", robot.reconnects},
          {"clock", offset_json(robot.clock)}};
}

nlohmann::json video_json(const std::optional<video::VideoCaptureState>& video, std::vector<std::string>& warnings) {
  if (!video) return nullptr;
  if (!video->running) warnings.emplace_back("the video has ended or is lost");
  if (video->dropped > 0) warnings.push_back(counted(video->dropped, "frame") + " of the video dropped");
  return {{"running", video->running},
          {"frames_per_s", video->frames_per_second},
          {"frames", video->frames},
          {"dropped", video->dropped},
          {"clock", offset_json(video->clock)}};
}

nlohmann::json clock_json(const capture::RunState& run) {
  nlohmann::json json = offset_json(run.clock);
  if (run.clock) json["lateness_ms"] = in_ms(run.lateness);
  return json;
}

nlohmann::json run_json(const capture::RunState& run, std::vector<std::string>& warnings) {
  const capture::LostElements lost = run.drops.total();
  if (lost.events + lost.others > 0)
    warnings.push_back(fmt::format("dropped: {}, {}", counted(lost.events, "event"), counted(lost.others, "other element")));
  else if (lost.packets > 0)
    warnings.push_back("dropped: " + counted(lost.packets, "packet"));
  return {{"elapsed_s", in_s(run.elapsed)}, {"events", run.events},          {"others", run.others},    {"bytes", run.bytes},
          {"queue_bytes", run.queue_bytes}, {"dropped", json_of(run.drops)}, {"clock", clock_json(run)}};
}

/// The newest picture of the film, as small as a page needs it. Each picture is encoded once.
class FilmOnPage {
 public:
  explicit FilmOnPage(std::shared_ptr<const video::VideoCapture> film) : film_(std::move(film)) {}

  std::string jpeg() {
    const std::scoped_lock lock(guard_);
    const cv::Mat newest = film_->newest_picture();
    if (newest.empty() || newest.data == encoded_.data) return jpeg_;
    encoded_ = newest;
    const int width = std::min(newest.cols, video::widest_page_picture);
    const cv::Mat small = video::film_picture(newest, {width, std::max(1, newest.rows * width / newest.cols)});
    const std::vector<unsigned char> bytes = small.empty() ? std::vector<unsigned char>() : video::page_jpeg_of(small, "film");
    jpeg_.assign(bytes.begin(), bytes.end());
    return jpeg_;
  }

 private:
  std::shared_ptr<const video::VideoCapture> film_;
  std::mutex guard_;
  cv::Mat encoded_;  ///< kept, so that its memory is not another picture's
  std::string jpeg_;
};

}  // namespace

std::string RecordPreview::open(const capture::RunRecorder& recorder) {
  live::LivePageOptions options{
      .sensor = recorder.streams().front().size.value(),
      .values = {"lateness_ms"},
      .choose = [this](std::uint64_t question, const std::string& choice) { return choices_.choose(question, choice); }};
  if (has_imu(recorder)) options.values.emplace_back("imu_m_per_s2");
  if (recorder.robot() != nullptr) options.values.insert(options.values.end(), {"robot_mm_per_s", "robot_height_mm"});
  if (recorder.video() != nullptr)
    options.film = [film = std::make_shared<FilmOnPage>(recorder.video())] { return film->jpeg(); };
  return view_.open(std::move(options));
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

void RecordPreview::see(std::span<const events::ImuSample> samples) {
  std::array<double, 2> values{unknown, unknown};  // as `open` names them
  for (const events::ImuSample& sample : samples) values.back() = std::fmax(values.back(), sample.acceleration());
  view_.note(values);
}

void RecordPreview::show(const RecordMoment& moment) {
  const bool has_lateness = moment.now != nullptr && moment.now->clock;
  std::vector<double> values{has_lateness ? in_ms(moment.now->lateness) : unknown};
  if (has_imu(*moment.recorder)) values.push_back(unknown);  // noted as it comes
  if (const robot::RobotMonitor* robot = moment.recorder->robot()) {
    const std::array<double, 2> motion = tool_motion(*robot);
    values.insert(values.end(), motion.begin(), motion.end());
  }
  view_.note(values);
  strength_.see(moment.now != nullptr ? moment.run : "", moment.now != nullptr ? moment.now->events : 0, Steady::now());
  if (!view_.is_due()) return;
  std::vector<std::string> warnings;
  if (strength_.warning()) warnings.push_back(*strength_.warning());
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
  const auto film = moment.recorder->video();
  state["has_film"] = film != nullptr && film->state().running;
  state["video"] = moment.now != nullptr ? video_json(moment.now->video, warnings) : nlohmann::json();
  state["disk"] = disk_json(data_, bytes_per_s(moment.now), warnings);
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
             {"disk", disk_json(data_, std::nullopt, none)},
             {"runs", runs},
             {"warnings", nlohmann::json::array()}});
}

}  // namespace tactile::cli
