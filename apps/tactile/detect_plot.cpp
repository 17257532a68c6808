#include "detect_plot.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "quantity_text.hpp"
#include "tactile/core/error.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/pictures/prediction_picture.hpp"

namespace tactile::cli {
void draw_ticks(const std::vector<detect::ReportedTick>& ticks, const heatmaps::HeatmapOptions& rendering,
                const std::string& title, const std::optional<RunFolder>& run, const std::filesystem::path& file) {
  if (ticks.empty()) throw Error(file.string() + ": there is no tick to draw; expected a stream longer than the history");
  const auto first = std::find_if(ticks.begin(), ticks.end(),
                                  [&](const detect::ReportedTick& tick) { return tick.beginning == ticks.back().beginning; });
  const std::uint32_t beginnings = first->beginning - ticks.front().beginning;
  pictures::PredictionPicture picture;
  picture.title = title;
  picture.first_event = first->first_event;
  const double history_ms = static_cast<double>(rendering.history.count()) / 1000;
  TickRange range{.first = first->verdict.t, .count = 0, .tick = rendering.tick};
  std::vector<Touch> verdicts;
  const auto add = [&](CameraTime t, const detect::TickVerdict& verdict) {
    picture.ticks.push_back({t, static_cast<double>(verdict.events) / history_ms, static_cast<double>(verdict.probabilities[1]),
                             static_cast<double>(verdict.probabilities[2]), verdict.verdict});
    verdicts.push_back(verdict.verdict);
    ++range.count;
  };
  std::uint64_t skipped = 0;
  for (auto tick = first; tick != ticks.end(); ++tick) {
    for (; range.count > 0 && range.at(range.count) < tick->verdict.t; ++skipped)
      add(range.at(range.count), std::prev(tick)->verdict);
    add(tick->verdict.t, tick->verdict);
  }
  picture.remarks.push_back(fmt::format("History t_h {} ms, a tick every {} ms; {} of {} ticks were skipped.", history_ms,
                                        static_cast<double>(rendering.tick.count()) / 1000, skipped, range.count));
  if (beginnings > 0)
    picture.remarks.push_back(
        fmt::format("The stream restarted {} before; earlier ticks are not drawn.", counted(beginnings, "time")));
  if (run) {
    const evaluation::RunTruth truth = evaluation::read_run_truth(*run);
    picture.has_labels = !truth.labels.empty();
    picture.has_truth = truth.has_truth;
    picture.unlabelled = truth.unlabelled;
    if (truth.has_truth) {
      for (const TouchInterval& label : truth.all_labelled()) picture.labels.push_back({label, {}});
    }
    std::vector<pictures::PredictedInterval>& reference = truth.has_truth ? picture.truth : picture.labels;
    std::vector<TouchInterval> wanted = truth.has_truth ? truth.true_ones : truth.used();
    std::erase_if(wanted, [&](const TouchInterval& interval) {
      return interval.end < range.first || interval.start > range.at(range.count - 1);
    });
    for (const results::Detection& detection : evaluation::detections_of(range, verdicts, wanted)) {
      pictures::PredictedInterval& interval =
          reference.emplace_back(pictures::PredictedInterval{detection.interval, results::words_of(detection), {}});
      if (detection.outcome == results::DetectionOutcome::detected) interval.first_right = detection.first_right;
    }
    if (!reference.empty())
      picture.remarks.push_back(
          fmt::format("Line: onset, {}; dashed: first right verdict.", truth.has_truth ? "as it truly was" : "as labelled"));
  }
  pictures::draw_prediction(picture, file);
}

}  // namespace tactile::cli
