#include "tactile/evaluation/label_uncertainty.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/detection_curve.hpp"

namespace tactile::evaluation {
namespace {

constexpr double sigmas_per_interval = 1.959964;  // half the width of a normal's 95 % interval

CameraTime drawn_time(const alignment::UncertainTime& time, Random& random) {
  const double z = random.normal();
  const microseconds side = z < 0 ? between(time.low, time.at) : between(time.at, time.high);
  return after(time.at, microseconds{std::llround(z / sigmas_per_interval * static_cast<double>(side.count()))});
}

/// A figure by each draw of the labels that has one.
using ValuesByDraw = std::vector<double>;

/// @param labelled  by the labels as they are
results::SpreadByLabels spread_of(const ValuesByDraw& values, const CrossedResults& objects, const Statistic& labelled,
                                  const Range& range, const results::BootstrapOptions& options) {
  results::SpreadByLabels spread;
  if (values.empty()) return spread;
  const double outside = (1 - options.confidence) / 2;
  spread.mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  spread.low = quantile(values, outside);
  spread.high = quantile(values, 1 - outside);
  spread.with_runs = figure_over_objects(objects, labelled, options, range);
  results::Figure& figure = spread.with_runs;
  if (figure.low)
    figure.low = std::max(range.lowest, figure.value - std::hypot(figure.value - *figure.low, spread.mean - spread.low));
  if (figure.high)
    figure.high = std::min(range.highest, figure.value + std::hypot(*figure.high - figure.value, spread.high - spread.mean));
  return spread;
}

/// The correct ones of a run's balanced samples, by its labels as they are or by a draw.
struct CountedSamples {
  std::uint64_t samples = 0, correct = 0;
};

/// The accuracy over the samples of some runs. @param count  gives the samples of a run by its index
template <class Count>
Statistic accuracy_by(const Count& count) {
  return mean_over_objects([count](std::span<const std::size_t> indexes) -> std::optional<double> {
    CountedSamples sum;
    for (const std::size_t i : indexes) {
      const CountedSamples of_run = count(i);
      sum.samples += of_run.samples;
      sum.correct += of_run.correct;
    }
    if (sum.samples == 0) return std::nullopt;
    return static_cast<double>(sum.correct) / static_cast<double>(sum.samples);
  });
}

results::Detection detection_of(const DrawnDetection& drawn) {
  return {.interval = {.touch = static_cast<Touch>(drawn.touch), .start = {}, .end = {}},
          .outcome = static_cast<results::DetectionOutcome>(drawn.outcome),
          .delay = microseconds{static_cast<std::int64_t>(drawn.us)},
          .limit = microseconds{static_cast<std::int64_t>(drawn.us)},
          .ahead = drawn.ahead == 1};
}

std::vector<results::RunDetections> detections_as_labelled(std::span<const RunByDrawnLabels> runs) {
  std::vector<results::RunDetections> detections;
  for (const RunByDrawnLabels& run : runs) detections.push_back({run, run.as_labelled.detections});
  return detections;
}

/// All runs by one draw of labels.
std::vector<results::RunDetections> detections_by_draw(std::span<const RunByDrawnLabels> runs, std::size_t draw) {
  std::vector<results::RunDetections> detections;
  for (const RunByDrawnLabels& run : runs) {
    results::RunDetections& of_run = detections.emplace_back(results::RunDetections{run, {}});
    if (run.drawn.empty()) {
      of_run.detections = run.as_labelled.detections;
    } else {
      const std::span<const DrawnDetection> drawn = run.drawn.detections_by(draw);
      std::transform(drawn.begin(), drawn.end(), std::back_inserter(of_run.detections), detection_of);
    }
  }
  return detections;
}

std::optional<double> mean_delay_ms(std::span<const results::RunDetections> runs, const RunsByObject& chosen, Touch touch) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) {
      for (const results::Detection& detection : runs[i].detections) {
        if (detection.interval.touch != touch || detection.outcome != results::DetectionOutcome::detected) continue;
        sum += in_ms(detection.delay);
        ++count;
      }
    }
  }
  return count == 0 ? std::nullopt : std::optional(sum / static_cast<double>(count));
}

std::optional<double> median_of_all_ms(const DetectionTimes& times, const RunsByObject& chosen) {
  const auto median = times.quantile(chosen, 0.5);
  return median ? std::optional(median->ms) : std::nullopt;
}

/// The mean and the median delay of one class, by the labels as they are and by each draw.
class TouchDelays {
 public:
  /// @param as_labelled  must outlive this
  TouchDelays(const std::vector<results::RunDetections>& as_labelled, Touch touch)
      : as_labelled_(as_labelled),
        touch_(touch),
        times_(as_labelled, touch),
        objects_(without_names(results_by_object(std::span(as_labelled),
                                                 [touch](const results::RunDetections& run) {
                                                   return std::any_of(run.detections.begin(), run.detections.end(),
                                                                      [touch](const results::Detection& detection) {
                                                                        return detection.interval.touch == touch;
                                                                      });
                                                 }))),
        all_(all_of(objects_)) {}

  /// Takes the detections of all runs by one draw.
  void add(const std::vector<results::RunDetections>& by_draw) {
    if (const auto mean = mean_delay_ms(by_draw, all_, touch_)) means_.push_back(*mean);
    if (const auto median = median_of_all_ms(DetectionTimes(by_draw, touch_), all_)) medians_.push_back(*median);
  }

  results::SpreadByLabels mean(const results::BootstrapOptions& options) const {
    return spread_of(
        means_, objects_, [this](const RunsByObject& of) { return mean_delay_ms(as_labelled_, of, touch_); }, range(), options);
  }

  results::SpreadByLabels median(const results::BootstrapOptions& options) const {
    return spread_of(
        medians_, objects_, [this](const RunsByObject& of) { return median_of_all_ms(times_, of); }, range(), options);
  }

 private:
  Range range() const { return range_of_delays(as_labelled_, touch_); }

  const std::vector<results::RunDetections>& as_labelled_;
  Touch touch_;
  DetectionTimes times_;
  CrossedResults objects_;
  RunsByObject all_;
  ValuesByDraw means_, medians_;
};

}  // namespace

std::vector<TouchInterval> drawn_labels(const RunTruth& truth, Random& random) {
  std::vector<TouchInterval> drawn;
  CameraTime free_from = CameraTime::min();
  for (std::size_t i = 0; i < truth.labels.size(); ++i) {
    // Labels in doubt are drawn too, so that the others do not depend on them.
    const CameraTime start = std::max(drawn_time(truth.bounds[i].start, random), free_from);
    const CameraTime end = std::max(drawn_time(truth.bounds[i].end, random), start);
    free_from = end;
    if (truth.labels[i].used) drawn.push_back({truth.labels[i].interval.touch, start, end});
  }
  return drawn;
}

// The masks have the widths of the members.
DrawnDetection::DrawnDetection(const results::Detection& detection)
    : us(static_cast<std::uint64_t>(
             (detection.outcome == results::DetectionOutcome::missed ? detection.limit : detection.delay).count()) &
         0xff'ffff'ffff'ffff),
      touch(static_cast<std::uint64_t>(detection.interval.touch) & 0xf),
      outcome(static_cast<std::uint64_t>(detection.outcome) & 0x7),
      ahead(detection.ahead ? 1 : 0) {}

std::span<const DrawnDetection> DrawnLabelsScores::detections_by(std::size_t draw) const {
  const std::size_t labels = detections.size() / correct.size();
  return std::span(detections).subspan(draw * labels, labels);
}

DrawnLabelsScores scores_by_drawn_labels(const TickRange& ticks, std::span<const Touch> verdicts,
                                         std::span<const std::size_t> samples, const RunTruth& truth, const DelayOptions& options,
                                         std::uint64_t seed) {
  DrawnLabelsScores scores;
  const bool is_exact = std::all_of(truth.bounds.begin(), truth.bounds.end(), [](const LabelBounds& bounds) {
    return bounds.start.low == bounds.start.high && bounds.end.low == bounds.end.high;
  });
  if (is_exact) return scores;
  Random random(seed);
  scores.samples = static_cast<std::uint32_t>(samples.size());
  scores.correct.reserve(label_draws);
  scores.detections.reserve(label_draws * truth.used().size());
  for (std::size_t draw = 0; draw < label_draws; ++draw) {
    const std::vector<TouchInterval> labels = drawn_labels(truth, random);
    scores.correct.push_back(static_cast<std::uint32_t>(std::count_if(samples.begin(), samples.end(), [&](std::size_t k) {
      return touch_at(ticks.at(static_cast<std::int64_t>(k)), labels) == verdicts[k];
    })));
    for (const results::Detection& detection : detections_of(ticks, verdicts, labels, options))
      scores.detections.emplace_back(detection);
  }
  return scores;
}

results::LabelUncertainty label_uncertainty(std::span<const RunByDrawnLabels> runs, const results::BootstrapOptions& options) {
  results::LabelUncertainty uncertainty;
  if (std::all_of(runs.begin(), runs.end(), [](const RunByDrawnLabels& run) { return run.drawn.empty(); })) return uncertainty;
  uncertainty.draws = label_draws;
  const auto labelled = [runs](std::size_t i) -> CountedSamples {
    return {runs[i].as_labelled.confusion.samples(), runs[i].as_labelled.confusion.correct()};
  };
  const auto by_draw = [runs, labelled](std::size_t draw) {
    return [runs, labelled, draw](std::size_t i) -> CountedSamples {
      if (runs[i].drawn.empty()) return labelled(i);
      return {runs[i].drawn.samples, runs[i].drawn.correct[draw]};
    };
  };
  const CrossedResults with_samples =
      without_names(results_by_object(runs, [](const RunByDrawnLabels& run) { return run.as_labelled.confusion.samples() > 0; }));
  const std::vector<results::RunDetections> as_labelled = detections_as_labelled(runs);
  std::array<TouchDelays, 2> delays{TouchDelays(as_labelled, Touch::press), TouchDelays(as_labelled, Touch::slip)};

  // One draw at a time: all of them together would need far more memory than their results.
  ValuesByDraw accuracies;
  const RunsByObject all = all_of(with_samples);
  for (std::size_t draw = 0; draw < label_draws; ++draw) {
    if (const auto accuracy = accuracy_by(by_draw(draw))(all)) accuracies.push_back(*accuracy);
    const std::vector<results::RunDetections> detections = detections_by_draw(runs, draw);
    for (TouchDelays& of_touch : delays) of_touch.add(detections);
  }

  std::vector<results::RunConfusion> confusions;
  for (const RunByDrawnLabels& run : runs) confusions.push_back({run, run.as_labelled.confusion});
  uncertainty.accuracy = spread_of(accuracies, with_samples, accuracy_by(labelled), range_of_shares(confusions), options);
  uncertainty.press_mean_ms = delays[0].mean(options);
  uncertainty.press_median_ms = delays[0].median(options);
  uncertainty.slip_mean_ms = delays[1].mean(options);
  uncertainty.slip_median_ms = delays[1].median(options);
  return uncertainty;
}

}  // namespace tactile::evaluation
