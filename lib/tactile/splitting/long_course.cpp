#include "tactile/splitting/long_course.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "tactile/alignment/quiet_rate.hpp"
#include "tactile/alignment/run_signals.hpp"
#include "tactile/events/camera_streams.hpp"
#include "tactile/labels/posterior/run_inference.hpp"

namespace tactile::splitting {
namespace {

using labels::LikelyRest;

constexpr microseconds drifts_by = 100ms;         // from part to part
constexpr std::int64_t known_within_us = 50'000;  // then a part's motions tell the robot's clock
constexpr std::size_t longest_part_times = 8;     // of the usual length; then a part ends wherever it is

/// All samples of the IMU of an event stream's camera, by time.
std::vector<events::ImuSample> imu_of(events::RecordingReader& recording, std::int32_t event_stream) {
  const std::vector<events::Stream> streams = events::camera_streams(recording.streams(), recording.stream(event_stream));
  std::vector<events::ImuSample> all;
  for (const events::PacketRecord& packet : recording.packets()) {
    const bool is_of_imu = std::any_of(streams.begin(), streams.end(), [&](const events::Stream& stream) {
      return stream.id == packet.stream_id && stream.type == events::StreamType::imu;
    });
    if (!is_of_imu) continue;
    const std::vector<events::ImuSample> samples = recording.read_imu(packet);
    all.insert(all.end(), samples.begin(), samples.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return all;
}

/// By the stretches of two seconds and more without a pause; by the whole recording if there is none. So the pauses do not count,
/// nor do the touches of a sensor that is silent but for them.
alignment::QuietRate quiet_rate_beside_pauses(const alignment::EventRate& rate, microseconds silence) {
  constexpr microseconds longer_than_touches = 2s;
  alignment::EventRate recorded = rate;
  recorded.counts.clear();
  const auto bins_in = [&](microseconds t) { return static_cast<std::size_t>(std::max<std::int64_t>(1, t / rate.bin)); };
  for (std::size_t begin = 0; begin < rate.counts.size();) {
    std::size_t end = begin + 1, silent = rate.counts[begin] == 0 ? 1 : 0;
    for (; end < rate.counts.size() && silent < bins_in(silence); ++end) silent = rate.counts[end] == 0 ? silent + 1 : 0;
    const std::size_t recorded_end = end - silent;
    if (recorded_end >= begin + bins_in(longer_than_touches))
      recorded.counts.insert(recorded.counts.end(), rate.counts.begin() + static_cast<std::ptrdiff_t>(begin),
                             rate.counts.begin() + static_cast<std::ptrdiff_t>(recorded_end));
    begin = end;
  }
  return alignment::quiet_rate(recorded.counts.empty() ? rate : recorded);
}

microseconds length_of(const LikelyRest& rest) { return between(rest.begin, rest.end); }

/// What the model says of one part.
struct Part {
  labels::RunPosterior posterior;
  std::vector<LikelyRest> rests;
  CameraTime end{};
};

/// One call of `long_course`.
class Parts {
 public:
  Parts(events::RecordingReader& recording, std::int32_t stream, const alignment::EventRate& rate, robot::RobotLogFile log,
        const std::optional<DeviceClock>& clock, const LongCourseOptions& options)
      : recording_(recording), options_(options), known_clock_(clock), imu_(imu_of(recording, stream)) {
    signals_.event_stream = stream;
    signals_.rate = rate;
    signals_.quiet = quiet_rate_beside_pauses(rate, options.silence);
    signals_.gaps = alignment::gaps_in(rate, signals_.quiet, options.silence);
    // Which of several pieces a part lies in is not known.
    if (clock || log.pieces.size() == 1) signals_.robot = std::move(log.pieces);
    std::erase_if(signals_.robot,
                  [&](const robot::RobotLog& piece) { return alignment::are_too_far_apart(rate.begin, piece.states.front().t); });
    signals_.coarse_offsets.resize(signals_.robot.size());
    course_.quiet_per_s = signals_.quiet.mean * 1e6 / static_cast<double>(rate.bin.count());
  }

  LongCourse course(const ProgressCallback& progress) {
    std::size_t begin = 0;
    for (const alignment::CameraSpan& gap : signals_.gaps) {
      add_recorded(begin, bin_at(gap.begin), progress);
      add_rest({.begin = gap.begin, .end = gap.end, .calm_begin = gap.begin, .calm_end = gap.end, .let_go = 1});
      begin = bin_at(gap.end);
    }
    add_recorded(begin, signals_.rate.counts.size(), progress);
    relate_robot();
    return std::move(course_);
  }

 private:
  std::size_t bin_at(CameraTime t) const { return static_cast<std::size_t>(between(signals_.rate.begin, t) / signals_.rate.bin); }

  /// A stretch of bins without a pause, part by part.
  void add_recorded(std::size_t begin, std::size_t end, const ProgressCallback& progress) {
    const auto usual = static_cast<std::size_t>(std::max<std::int64_t>(1, options_.part / signals_.rate.bin));
    for (std::size_t length = usual; begin < end;) {
      report_progress(progress, begin, signals_.rate.counts.size(), recording_.file().filename().string() + ": touches");
      const std::size_t until = end - begin > length + length / 2 ? begin + length : end;
      const Part part = infer(begin, until);
      std::size_t next = until == end ? end : begin_of_next(part);
      if (next <= begin && length >= longest_part_times * usual) next = until;
      if (next <= begin) {
        length *= 2;
        continue;
      }
      add(part, next == until ? part.end : signals_.rate.begin_of(next));
      begin = next;
      length = usual;
    }
  }

  Part infer(std::size_t begin, std::size_t end) {
    const alignment::EventRate rate = alignment::part_of(signals_.rate, begin, end);
    const auto at = [&](CameraTime t) {
      return std::lower_bound(imu_.begin(), imu_.end(), t,
                              [](const events::ImuSample& s, CameraTime time) { return s.t < time; });
    };
    signals_.imu.assign(at(rate.begin), at(rate.last));
    const CameraTime middle = after(rate.begin, between(rate.begin, rate.last) / 2);
    for (std::size_t i = 0; known_clock_ && i < signals_.robot.size(); ++i)
      signals_.coarse_offsets[i] = offset_around(*known_clock_, signals_.robot[i], middle);
    labels::PlaceCounts counts = labels::place_counts(recording_, signals_.event_stream, rate, signals_.gaps, rate.bin);
    counts.several_runs = true;
    labels::RunInference inference(signals_, std::move(counts));
    return {.posterior = inference.posterior({}), .rests = inference.rests(), .end = signals_.rate.begin_of(end)};
  }

  /// The bin in the middle of the last rest between touches that ends a run; 0 if there is none.
  std::size_t begin_of_next(const Part& part) const {
    const auto rest = std::find_if(part.rests.rbegin(), part.rests.rend(), [&](const LikelyRest& one) {
      return !one.is_first && !one.is_last && ends_run(one, options_);
    });
    return rest == part.rests.rend() ? 0 : bin_at(rest->middle());
  }

  /// What begins before `end`.
  void add(const Part& part, CameraTime end) {
    for (const labels::LikelyTouch& touch : part.posterior.touches) {
      if (touch.start.at < end && is_likeliest(touch, part.posterior.touches)) course_.touches.push_back(touch);
    }
    for (const TouchInterval& release : part.posterior.releases) {
      if (release.start < end) course_.releases.push_back(release);
    }
    for (LikelyRest rest : part.rests) {
      if (rest.begin >= end) continue;
      rest.end = std::min(rest.end, end);
      rest.calm_begin = std::min(rest.calm_begin, end);
      rest.calm_end = std::min(rest.calm_end, end);
      add_rest(rest);
    }
    if (known_clock_ || part.posterior.robot.empty()) return;
    const labels::LikelyOffset& offset = part.posterior.robot.front();
    if (offset.high_us - offset.low_us >= 2 * known_within_us) return;
    offsets_.push_back(offset);
    signals_.coarse_offsets.front() = alignment::CoarseOffset{.offset_us = offset.median_us, .within = drifts_by};
  }

  /// A rest that begins where the one before ends is one with it.
  void add_rest(const LikelyRest& rest) {
    if (course_.rests.empty() || course_.rests.back().end < rest.begin) return course_.rests.push_back(rest);
    LikelyRest& whole = course_.rests.back();
    if (rest.calm_begin == whole.calm_end)
      whole.calm_end = rest.calm_end;
    else if (between(rest.calm_begin, rest.calm_end) > between(whole.calm_begin, whole.calm_end))
      std::tie(whole.calm_begin, whole.calm_end) = std::pair(rest.calm_begin, rest.calm_end);
    whole.end = rest.end;
    whole.let_go = std::max(whole.let_go, rest.let_go);
  }

  /// By the offsets of all parts.
  void relate_robot() {
    if (offsets_.empty()) return;
    std::int64_t low_us = offsets_.front().low_us, high_us = offsets_.front().high_us;
    for (const labels::LikelyOffset& offset : offsets_) {
      low_us = std::min(low_us, offset.low_us);
      high_us = std::max(high_us, offset.high_us);
    }
    const std::int64_t half_us = (high_us - low_us) / 2;
    course_.robot = DeviceClock{
        .relation = {.offset_us = low_us + half_us}, .within = microseconds{half_us}, .how = "motions in log and recording"};
  }

  events::RecordingReader& recording_;
  const LongCourseOptions& options_;
  const std::optional<DeviceClock>& known_clock_;
  const std::vector<events::ImuSample> imu_;
  alignment::RunSignals signals_;
  std::vector<labels::LikelyOffset> offsets_;  ///< of the robot's clock, part by part
  LongCourse course_;
};

}  // namespace

bool ends_run(const LikelyRest& rest, const LongCourseOptions& options) {
  return rest.let_go > options.let_go && length_of(rest) >= options.quiet;
}

LongCourse long_course(events::RecordingReader& recording, std::int32_t stream, const alignment::EventRate& rate,
                       robot::RobotLogFile log, const std::optional<DeviceClock>& clock, const LongCourseOptions& options,
                       const ProgressCallback& progress) {
  return Parts(recording, stream, rate, std::move(log), clock, options).course(progress);
}

}  // namespace tactile::splitting
