#include "tactile/labels/exchange/run_exchange.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tactile/alignment/event_rate.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/exchange/label_csv.hpp"
#include "tactile/labels/exchange/label_studio.hpp"
#include "tactile/labels/label_options.hpp"
#include "tactile/labels/saved_labels.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::labels {
namespace {

namespace fs = std::filesystem;

/// The film's first frame in camera time, and the film's drift. A player's time 0 is the first frame.
std::optional<ClockRelation> film_clock(const RunFolder& run, const Labels& labels) {
  if (!labels.video_clock || !fs::exists(run.video_times())) return std::nullopt;
  const std::vector<VideoTime> frames = video::read_video_times(run.video_times());
  if (frames.empty()) return std::nullopt;
  const ClockRelation& clock = labels.video_clock->relation;
  return ClockRelation{.offset_us = us_of(clock.camera_from(frames.front())), .drift_ppm = clock.drift_ppm, .reference_us = 0};
}

std::vector<ImportedLabels> read_imported(const fs::path& file, std::optional<ExchangeFormat> format) {
  const std::optional<ExchangeFormat> known = format ? format : exchange_format_by_ending(file);
  if (!known) {
    throw Error(file.string() +
                ": its ending names no format that labels are read from; expected .json of Label Studio, or .csv with the "
                "columns class, start_s and end_s");
  }
  switch (*known) {
    case ExchangeFormat::label_studio:
      return read_label_studio(file);
    case ExchangeFormat::csv:
      return read_label_csv(file);
  }
  return {};
}

std::string list_of(std::span<const RunFolder> runs) {
  constexpr std::size_t most = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(runs.size(), most); ++i) text += (i == 0 ? "" : ", ") + runs[i].name();
  return text + (runs.size() > most ? fmt::format(" and {} more", runs.size() - most) : "");
}

/// The run that the labels belong to.
const RunFolder& run_of(const ImportedLabels& labels, std::span<const RunFolder> runs) {
  const std::string stem = fs::path(labels.where).stem().string();
  const auto found = std::find_if(runs.begin(), runs.end(), [&](const RunFolder& run) {
    return labels.run ? run.name() == *labels.run : file_stem_of(run) == stem;
  });
  if (found != runs.end()) return *found;
  if (labels.run)
    throw Error(fmt::format("{}: has labels of {}; expected labels of {}", labels.where, shown_text(*labels.run), list_of(runs)));
  if (runs.size() != 1) {
    throw Error(fmt::format("{}: names no run; expected a file name such as {}{}, or a single run to import into", labels.where,
                            runs.empty() ? std::string("fan-01") : file_stem_of(runs.front()),
                            fs::path(labels.where).extension().string()));
  }
  return runs.front();
}

FileTimes times_of(TimeOrigin origin, const RunFolder& run, const Labels& labels, CameraTime first_event) {
  if (origin != TimeOrigin::video) return {.origin = origin};
  const std::optional<ClockRelation> film = film_clock(run, labels);
  if (!film) {
    throw Error(fmt::format("{}: its video clock is unknown; expected times of the origin first-event or camera", run.name()));
  }
  return {.origin = origin, .zero_us = saturating_subtract(film->offset_us, us_of(first_event)), .drift_ppm = film->drift_ppm};
}

/// A curve through the samples, constant beyond its ends.
class Curve {
 public:
  void add(CameraTime t, double value) {
    if (!times_.empty() && t <= times_.back()) return;
    times_.push_back(t);
    values_.push_back(value);
  }
  bool empty() const { return times_.empty(); }

  double at(CameraTime t) const {
    const auto next = std::upper_bound(times_.begin(), times_.end(), t) - times_.begin();
    const auto i = static_cast<std::size_t>(next);
    if (i == 0) return values_.front();
    if (i == times_.size()) return values_.back();
    const double share =
        static_cast<double>(between(times_[i - 1], t).count()) / static_cast<double>(between(times_[i - 1], times_[i]).count());
    return values_[i - 1] + share * (values_[i] - values_[i - 1]);
  }

 private:
  std::vector<CameraTime> times_;
  std::vector<double> values_;
};

double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

}  // namespace

LabelsToExport labels_to_export(const RunFolder& run, TimeOrigin origin) {
  const RecordingSpan span = span_of_events(run);
  LabelsToExport labels{
      .run = run.name(), .labels = read_labels(run.labels()), .times = {}, .first_event = span.first, .last_event = span.last};
  labels.times = times_of(origin, run, labels.labels, span.first);
  return labels;
}

LabelSignals signals_of(const RunFolder& run, const LabelsToExport& labels) {
  constexpr std::int64_t most_points = 20'000;
  const std::int64_t length_us = between(labels.first_event, labels.last_event).count();
  const microseconds bin{1000 * (1 + length_us / (1000 * most_points))};
  events::RecordingReader recording(run.events());
  const alignment::EventRate rate = alignment::event_rate(recording, events::event_stream(recording).id, {.bin = bin});
  const ClockRelation axis = labels.times.to_camera(labels.first_event);
  const double per_s = 1e6 / static_cast<double>(bin.count());

  LabelSignals signals;
  signals.curves.emplace_back("events_per_s", std::vector<double>());
  std::vector<CameraTime> middles;
  for (std::size_t i = 0; i < rate.counts.size(); ++i) {
    middles.push_back(after(rate.begin_of(i), bin / 2));
    signals.time_s.push_back(static_cast<double>(axis.clock_us_from(middles.back())) / 1e6);
    signals.curves[0].second.push_back(rounded(rate.counts[i] * per_s));
  }
  if (labels.labels.robot_clocks.empty() || !fs::exists(run.robot())) return signals;
  const robot::RobotLogFile file = robot::read_robot_log(run.robot(), robot_log_options_of(labels.labels.provenance));
  Curve height, speed;
  for (const robot::RobotLog& log : file.pieces) {
    const alignment::FittedClock* clock = labels.labels.robot_clock_of(log.states.front().t);
    if (clock == nullptr) continue;
    for (const robot::RobotState& state : log.states) {
      const CameraTime t = clock->relation.camera_from(state.t);
      height.add(t, 1000.0 * state.tcp_pose[2]);
      speed.add(t, 1000.0 * std::hypot(state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]));
    }
  }
  if (height.empty()) return signals;
  for (const auto& [name, curve] : {std::pair("tcp_height_mm", &height), std::pair("tcp_speed_mm_s", &speed)}) {
    std::vector<double> values;
    values.reserve(middles.size());
    for (const CameraTime t : middles) values.push_back(rounded(curve->at(t)));
    signals.curves.emplace_back(name, std::move(values));
  }
  return signals;
}

std::vector<ImportedRun> read_edits(std::span<const fs::path> files, std::optional<ExchangeFormat> format,
                                    std::optional<TimeOrigin> origin, std::span<const RunFolder> runs) {
  std::vector<ImportedRun> edited;
  std::map<std::string, std::string> file_of;
  for (const fs::path& file : files) {
    for (const ImportedLabels& imported : read_imported(file, format)) {
      const RunFolder& run = run_of(imported, runs);
      if (const auto [before, is_new] = file_of.try_emplace(run.folder.string(), file.string()); !is_new)
        throw Error(
            fmt::format("{}: has labels of {}, as {}; expected each run once", file.string(), run.name(), before->second));
      if (!fs::exists(run.labels())) {
        throw Error(fmt::format("{}: {} has no labels; 'tactile label' makes them", file.string(), run.name()));
      }
      const VersionedLabels before = read_versioned_labels(run);
      const RecordingSpan span = span_of_events(run);
      const TimeOrigin from = imported.origin.value_or(origin.value_or(TimeOrigin::first_event));
      const FileTimes times = imported.times ? *imported.times : times_of(from, run, before.labels, span.first);
      EditCounts counts;
      const Labels after = with_edits(before.labels, imported, times, span.first, span.last, counts);
      edited.push_back({.run = run,
                        .file = file.string(),
                        .before_version = before.version,
                        .edit = {.labels = imported, .times = times},
                        .counts = counts,
                        .changes = words_of_changes(before.labels, after, span),
                        .looked_at = imported.looked_at});
    }
  }
  return edited;
}

std::string file_stem_of(const RunFolder& run) { return run.object + "-" + run.run; }

}  // namespace tactile::labels
