#include "tactile/evaluation/evaluation_table.hpp"

#include <fmt/core.h>

#include <string_view>

#include "tactile/core/csv_table.hpp"
#include "tactile/results/figure_cells.hpp"

namespace tactile::evaluation {
namespace {

std::int64_t in_whole_ms(microseconds us) { return us.count() / 1000; }

class Table {
 public:
  void figure(std::string_view group, std::string_view object, std::string_view touch, std::string_view metric,
              const results::Figure& figure) {
    table_.add_row(group, object, touch, metric, results::figure_cells(figure, digits), figure.n);
  }

  void number(std::string_view group, std::string_view object, std::string_view touch, std::string_view metric, double value) {
    table_.add_row(group, object, touch, metric, csv_number(value, digits), "", "", "");
  }

  void count(std::string_view group, std::string_view object, std::string_view touch, std::string_view metric,
             std::uint64_t count) {
    table_.add_row(group, object, touch, metric, count, "", "", "");
  }

  void accuracy(std::string_view group, const results::Accuracy& accuracy, std::string_view metric = "accuracy") {
    figure(group, "all", "", metric, accuracy.mean);
    for (const auto& [name, of_object] : accuracy.objects) figure(group, name, "", metric, of_object);
  }

  void confusion(std::string_view group, const results::Confusion& confusion) {
    for (const Touch is : all_touches) {
      for (const Touch predicted : all_touches) {
        count(group, "all", name_of(is), fmt::format("said_{}", name_of(predicted)),
              confusion.counts[static_cast<std::size_t>(is)][static_cast<std::size_t>(predicted)]);
      }
    }
  }

  void delay(std::string_view group, std::string_view object, std::string_view touch, const results::DelaySummary& delay) {
    figure(group, object, touch, "mean", delay.mean_ms);
    figure(group, object, touch, "median", delay.median_ms);
    number(group, object, touch, "sem", delay.sem_ms);
    count(group, object, touch, "intervals", delay.intervals);
    count(group, object, touch, "misses", delay.misses);
    count(group, object, touch, "early", delay.early);
    count(group, object, touch, "head_starts", delay.head_starts);
    figure(group, object, touch, "missed", delay.missed);
    quantile(group, object, touch, "median_of_all", delay.median_of_all_ms);
    quantile(group, object, touch, "p90_of_all", delay.quantile_of_all_ms);
  }

  void delays(std::string_view group, std::string_view touch, const results::DelayTable& table) {
    delay(group, "all", touch, table.all);
    for (const auto& [name, of_object] : table.objects) delay(group, name, touch, of_object);
    for (const results::DetectedWithin& point : table.curve)
      figure(group, "all", touch, fmt::format("detected_within_{:g}", point.ms), point.share);
  }

  void false_alarms(std::string_view group, const results::FalseAlarmTable& table) {
    figure(group, "all", "", "per_min", table.per_min);
    for (const auto& [name, per_min] : table.objects) figure(group, name, "", "per_min", per_min);
    count(group, "all", "", "count", table.total.alarms);
    number(group, "all", "", "none_min", results::in_minutes(table.total.none_time));
    count(group, "all", "", "after_intervals", table.total.after_intervals);
    number(group, "all", "", "after_intervals_min", results::in_minutes(table.total.after_intervals_time));
    count(group, "all", "", "releases", table.total.releases);
    number(group, "all", "", "releases_min", results::in_minutes(table.total.releases_time));
    count(group, "all", "", "unlabelled", table.total.unlabelled);
    number(group, "all", "", "unlabelled_min", results::in_minutes(table.total.unlabelled_time));
    figure(group, "all", "", "outside_labels_per_min", table.outside_labels_per_min);
    count(group, "all", "", "outside_labels", table.total.outside_labels);
    number(group, "all", "", "outside_labels_min", results::in_minutes(table.total.outside_labels_time));
    figure(group, "all", "", "outside_labels_share", table.outside_labels_share);
    figure(group, "all", "", "outside_motion_per_min", table.outside_motion_per_min);
    count(group, "all", "", "outside_motion", table.total.outside_motion);
    number(group, "all", "", "outside_motion_min", results::in_minutes(table.total.outside_motion_time));
    figure(group, "all", "", "outside_motion_share", table.outside_motion_share);
    figure(group, "all", "", "none_in_alarm_share", table.none_in_alarm_share);
    figure(group, "all", "", "wrong_class_per_min", table.wrong_class_per_min);
    figure(group, "all", "", "wrong_class_share", table.wrong_class_share);
    count(group, "all", "", "wrong_class", table.total.wrong_class);
    number(group, "all", "", "wrong_class_min", results::in_minutes(table.total.wrong_class_time));
    number(group, "all", "", "labelled_min", results::in_minutes(table.total.labelled_time));
  }

  void spread(std::string_view touch, const std::string& metric, const results::SpreadByLabels& spread) {
    constexpr std::string_view group = "label_uncertainty";
    number(group, "all", touch, metric + "_mean", spread.mean);
    number(group, "all", touch, metric + "_low", spread.low);
    number(group, "all", touch, metric + "_high", spread.high);
    figure(group, "all", touch, metric + "_with_runs", spread.with_runs);
  }

  void over_time(std::string_view group, std::string_view touch, const results::AccuracyOverTime& accuracy) {
    share(group, "all", touch, accuracy.all);
    for (const auto& [name, of_object] : accuracy.objects) share(group, name, touch, of_object);
    for (const results::OverTimeBin& bin : accuracy.since_onset)
      figure(group, "all", touch, fmt::format("{}_to_{}_ms_since_onset", in_whole_ms(bin.from), in_whole_ms(bin.to)),
             bin.accuracy);
    for (const results::OverTimeBin& bin : accuracy.before_end)
      figure(group, "all", touch, fmt::format("{}_to_{}_ms_before_end", in_whole_ms(bin.from), in_whole_ms(bin.to)),
             bin.accuracy);
  }

  const std::string& text() const { return table_.text(); }

 private:
  void quantile(std::string_view group, std::string_view object, std::string_view touch, const std::string& metric,
                const results::CensoredQuantile& quantile) {
    figure(group, object, touch, metric, quantile.ms);
    count(group, object, touch, metric + "_is_lower_bound", quantile.is_lower_bound ? 1 : 0);
  }

  void share(std::string_view group, std::string_view object, std::string_view touch, const results::ShareOverTime& share) {
    figure(group, object, touch, "first", share.first);
    figure(group, object, touch, "later", share.later);
    figure(group, object, touch, "last", share.last);
    figure(group, object, touch, "before_last", share.before_last);
    figure(group, object, touch, "last_minus_before", share.last_minus_before);
    figure(group, object, touch, "still_said", share.still_predicted);
    count(group, object, touch, "intervals", share.intervals);
    count(group, object, touch, "short_ones", share.short_ones);
  }

  static constexpr int digits = 10;

  CsvTable table_{"group,object,class,metric,value,low,high,n"};
};

void add_over_time(Table& table, std::string_view group, const results::OverTime& over_time) {
  table.over_time(group, "press", over_time.press);
  table.over_time(group, "slip", over_time.slip);
  table.over_time(group, "", over_time.both);
}

void add_classes(Table& table, const results::ClassScores& scores) {
  const auto add = [&](std::string_view object, const std::array<results::ClassScore, touch_count>& of_object) {
    for (const Touch touch : all_touches) {
      const results::ClassScore& score = of_object[static_cast<std::size_t>(touch)];
      table.figure("per_class", object, name_of(touch), "precision", score.precision);
      table.figure("per_class", object, name_of(touch), "recall", score.recall);
      table.figure("per_class", object, name_of(touch), "f1", score.f1);
    }
  };
  add("all", scores.all);
  for (const auto& [name, of_object] : scores.objects) add(name, of_object);
}

void add_calibration(Table& table, const results::Calibration& calibration, const std::string& suffix) {
  table.figure("calibration" + suffix, "all", "", "ece", calibration.error);
  for (const auto& [name, error] : calibration.objects) table.figure("calibration" + suffix, name, "", "ece", error);
  for (const results::ReliabilityBin& bin : calibration.bins) {
    const std::string group = fmt::format("reliability{}:{:.4f}-{:.4f}", suffix, bin.from, bin.to);
    table.count(group, "all", "", "samples", bin.samples);
    table.number(group, "all", "", "confidence", bin.confidence);
    table.figure(group, "all", "", "accuracy", bin.accuracy);
  }
}

void add_labels(Table& table, const results::Evaluation& evaluation) {
  const results::LabelUncertainty& uncertainty = evaluation.label_uncertainty;
  table.count("label_uncertainty", "all", "", "draws", uncertainty.draws);
  table.spread("", "accuracy", uncertainty.accuracy);
  table.spread("press", "mean", uncertainty.press_mean_ms);
  table.spread("press", "median_of_all", uncertainty.press_median_ms);
  table.spread("slip", "mean", uncertainty.slip_mean_ms);
  table.spread("slip", "median_of_all", uncertainty.slip_median_ms);
  if (!evaluation.with_flagged) return;
  const results::WithFlagged& with = *evaluation.with_flagged;
  table.count("with_flagged", "all", "", "runs", with.runs.size());
  table.count("with_flagged", "all", "", "flagged_intervals", with.intervals);
  table.figure("with_flagged", "all", "", "accuracy", with.accuracy);
  table.delay("with_flagged", "all", "press", with.press);
  table.delay("with_flagged", "all", "slip", with.slip);
}

void add_detector(Table& table, const std::string& suffix, const results::DetectorScore& score) {
  table.delays("delay_ms" + suffix, "press", score.press);
  table.delays("delay_ms" + suffix, "slip", score.slip);
  table.false_alarms("false_alarms" + suffix, score.false_alarms);
}

}  // namespace

std::string table_of(const results::Evaluation& evaluation) {
  Table table;
  table.accuracy("accuracy", evaluation.accuracy);
  table.confusion("confusion", evaluation.confusion);
  add_classes(table, evaluation.classes);
  add_calibration(table, evaluation.calibration, "");
  add_calibration(table, evaluation.whole_run_calibration, "_whole_runs");
  for (const results::GuardScore& score : evaluation.guards) {
    const std::string group = fmt::format("guard:{}", static_cast<double>(score.guard.count()) / 1000);
    table.accuracy(group, score.accuracy);
    table.accuracy(group, score.difference, "difference");
    table.confusion(group, score.confusion);
  }
  for (const results::BaselineScore& baseline : evaluation.baselines)
    table.accuracy("baseline:" + baseline.name, baseline.accuracy);
  add_detector(table, "", evaluation.network);
  for (const auto& [name, score] : evaluation.trivial) add_detector(table, ":" + name, score);
  if (evaluation.gate_off) {
    const results::GateOff& off = *evaluation.gate_off;
    if (off.ratio) table.number("gate", "all", "", "limit_ratio", *off.ratio);
    if (!off.ratio) table.count("gate", "all", "", "limit_events", off.limit);
    table.count("gate", "all", "", "ticks", off.ticks);
    table.count("gate", "all", "", "gated", off.gated);
    table.accuracy("accuracy:gate_off", off.accuracy);
    table.confusion("confusion:gate_off", off.confusion);
    add_detector(table, ":gate_off", off.network);
  }
  add_labels(table, evaluation);
  add_over_time(table, "over_time", evaluation.over_time);
  for (const results::OperatingPoint& point : evaluation.operating_curve) {
    const std::string group = fmt::format("threshold:{}", point.threshold);
    table.delay(group, "all", "press", point.press);
    table.delay(group, "all", "slip", point.slip);
    table.figure(group, "all", "", "false_alarms_per_min", point.false_alarms_per_min);
    table.count(group, "all", "", "false_alarms", point.false_alarms);
    table.figure(group, "all", "", "outside_labels_per_min", point.outside_labels_per_min);
    table.figure(group, "all", "", "wrong_class_per_min", point.wrong_class_per_min);
  }
  if (!evaluation.truth) return table.text();
  const results::TruthScore& truth = *evaluation.truth;
  table.accuracy("accuracy_true", truth.accuracy);
  table.confusion("confusion_true", truth.confusion);
  table.delays("delay_true_ms", "press", truth.press);
  table.delays("delay_true_ms", "slip", truth.slip);
  table.delays("delay_gross_ms", "slip", truth.gross_slip);
  table.false_alarms("false_alarms_true", truth.false_alarms);
  add_over_time(table, "over_time_true", truth.over_time);
  return table.text();
}

}  // namespace tactile::evaluation
