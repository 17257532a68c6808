#include "tactile/evaluation/label_uncertainty.hpp"

#include <algorithm>
#include <cmath>

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

using RunsByDraw = std::function<std::optional<double>(const RunsByObject&, std::size_t draw)>;

/// @param labelled  by the labels as they are
results::SpreadByLabels spread_of(const CrossedResults& objects, const Statistic& labelled, const RunsByDraw& by_draw,
                                  const Range& range, const results::BootstrapOptions& options) {
  results::SpreadByLabels spread;
  const RunsByObject all = all_of(objects);
  std::vector<double> values;
  for (std::size_t draw = 0; draw < label_draws; ++draw) {
    if (const auto value = by_draw(all, draw)) values.push_back(*value);
  }
  if (values.empty()) return spread;
  const double outside = (1 - options.confidence) / 2;
  for (const double value : values) spread.mean = (std::isnan(spread.mean) ? 0 : spread.mean) + value;
  spread.mean /= static_cast<double>(values.size());
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
  return {.interval = {.touch = drawn.touch, .start = {}, .end = {}},
          .outcome = drawn.outcome,
          .delay = drawn.delay,
          .limit = drawn.delay,
          .ahead = drawn.ahead};
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
      std::transform(run.drawn[draw].detections.begin(), run.drawn[draw].detections.end(), std::back_inserter(of_run.detections),
                     detection_of);
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

std::vector<DrawnLabelsScore> scores_by_drawn_labels(const TickRange& ticks, std::span<const Touch> verdicts,
                                                     std::span<const std::size_t> samples, const RunTruth& truth,
                                                     const DelayOptions& options, std::uint64_t seed) {
  std::vector<DrawnLabelsScore> scores;
  const bool is_exact = std::all_of(truth.bounds.begin(), truth.bounds.end(), [](const LabelBounds& bounds) {
    return bounds.start.low == bounds.start.high && bounds.end.low == bounds.end.high;
  });
  if (is_exact) return scores;
  Random random(seed);
  for (std::size_t draw = 0; draw < label_draws; ++draw) {
    const std::vector<TouchInterval> labels = drawn_labels(truth, random);
    DrawnLabelsScore& score = scores.emplace_back();
    score.samples = static_cast<std::uint32_t>(samples.size());
    score.correct = static_cast<std::uint32_t>(std::count_if(samples.begin(), samples.end(), [&](std::size_t k) {
      return touch_at(ticks.at(static_cast<std::int64_t>(k)), labels) == verdicts[k];
    }));
    for (const results::Detection& detection : detections_of(ticks, verdicts, labels, options)) {
      const bool is_missed = detection.outcome == results::DetectionOutcome::missed;
      score.detections.push_back(
          {is_missed ? detection.limit : detection.delay, detection.interval.touch, detection.outcome, detection.ahead});
    }
    score.detections.shrink_to_fit();
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
      return {runs[i].drawn[draw].samples, runs[i].drawn[draw].correct};
    };
  };
  const CrossedResults with_samples =
      without_names(results_by_object(runs, [](const RunByDrawnLabels& run) { return run.as_labelled.confusion.samples() > 0; }));
  std::vector<results::RunConfusion> confusions;
  for (const RunByDrawnLabels& run : runs) confusions.push_back({run, run.as_labelled.confusion});
  const Range range = range_of_shares(confusions);
  uncertainty.accuracy = spread_of(
      with_samples, accuracy_by(labelled),
      [&](const RunsByObject& chosen, std::size_t draw) { return accuracy_by(by_draw(draw))(chosen); }, range, options);

  // Each draw is made when it is needed: all of them together would need far more memory than their results.
  const std::vector<results::RunDetections> as_labelled = detections_as_labelled(runs);
  for (const auto& [touch, mean, median] : {std::tuple(Touch::press, &uncertainty.press_mean_ms, &uncertainty.press_median_ms),
                                            std::tuple(Touch::slip, &uncertainty.slip_mean_ms, &uncertainty.slip_median_ms)}) {
    const CrossedResults chosen =
        without_names(results_by_object(std::span<const results::RunDetections>(as_labelled), [t = touch](const auto& run) {
          return std::any_of(run.detections.begin(), run.detections.end(),
                             [t](const results::Detection& detection) { return detection.interval.touch == t; });
        }));
    *mean = spread_of(
        chosen, [&, t = touch](const RunsByObject& of) { return mean_delay_ms(as_labelled, of, t); },
        [&, t = touch](const RunsByObject& of, std::size_t draw) { return mean_delay_ms(detections_by_draw(runs, draw), of, t); },
        Range{.lowest = 0}, options);
    const DetectionTimes times(as_labelled, touch);
    *median = spread_of(
        chosen, [&](const RunsByObject& of) { return median_of_all_ms(times, of); },
        [&, t = touch](const RunsByObject& of, std::size_t draw) {
          return median_of_all_ms(DetectionTimes(detections_by_draw(runs, draw), t), of);
        },
        Range{.lowest = 0}, options);
  }
  return uncertainty;
}

}  // namespace tactile::evaluation
