#include "eval_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "eval_detection_tables.hpp"
#include "eval_summary.hpp"
#include "figure_text.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

using Row = std::vector<std::string>;

std::string accuracy_text(const results::Evaluation& evaluation) {
  std::vector<Row> rows;
  for (const auto& [name, figure] : evaluation.accuracy.objects)
    rows.push_back({name, percent(figure), bounds(figure, 100), std::to_string(figure.n) + (figure.n == 1 ? " run" : " runs")});
  const results::Figure& mean = evaluation.accuracy.mean;
  rows.push_back({"mean over objects", percent(mean), bounds(mean, 100), std::to_string(mean.n) + " objects"});
  if (evaluation.truth) {
    const results::Figure& by_truth = evaluation.truth->accuracy.mean;
    rows.push_back({"mean, by the truth", percent(by_truth), bounds(by_truth, 100), std::to_string(by_truth.n) + " objects"});
  }
  std::string text = text_table({"accuracy on balanced samples [%]", "", "95 %", ""}, rows) + "\n";

  rows.clear();
  rows.push_back({"model", percent(mean), bounds(mean, 100)});
  for (const results::BaselineScore& baseline : evaluation.baselines)
    rows.push_back({baseline.name, percent(baseline.accuracy.mean), bounds(baseline.accuracy.mean, 100)});
  text += text_table({"compared with baselines, mean over objects [%]", "", "95 %"}, rows);
  text += wrapped(comparison_with_baselines(evaluation)) + "\n\n";
  return text;
}

std::string classes_text(const results::Evaluation& evaluation) {
  std::vector<Row> rows, score_rows;
  for (const Touch truth : all_touches) {
    const auto index = static_cast<std::size_t>(truth);
    Row row{std::string(name_of(truth))};
    for (const std::uint64_t count : evaluation.confusion.counts[index]) row.push_back(std::to_string(count));
    rows.push_back(row);
    const results::ClassScore& score = evaluation.classes.all[index];
    score_rows.push_back({std::string(name_of(truth)), percent(score.precision), bounds(score.precision, 100),
                          percent(score.recall), bounds(score.recall, 100), percent(score.f1), bounds(score.f1, 100)});
  }
  return text_table({"true \\ predicted", "none", "press", "slip"}, rows) + "\n" +
         text_table({"[%]", "precision", "95 %", "recall", "95 %", "F1", "95 %"}, score_rows) + "\n" +
         wrapped(fmt::format("Expected calibration error of the model's probabilities: {} % {} on balanced samples, {} % {} at "
                             "every tick of whole runs, with their shares of the classes.",
                             percent(evaluation.calibration.error), bounds(evaluation.calibration.error, 100),
                             percent(evaluation.whole_run_calibration.error),
                             bounds(evaluation.whole_run_calibration.error, 100))) +
         "\n\n";
}

std::string guards_text(const results::Evaluation& evaluation) {
  std::vector<Row> rows;
  for (const results::GuardScore& score : evaluation.guards) {
    const bool own = score.guard == evaluation.sampling_guard;
    rows.push_back({fmt::format("{} ms{}", static_cast<double>(score.guard.count()) / 1000, own ? ", the dataset's" : ""),
                    percent(score.accuracy.mean), bounds(score.accuracy.mean, 100), own ? "" : percent(score.difference.mean),
                    own ? "" : bounds(score.difference.mean, 100)});
  }
  return text_table({"guard around intervals", "accuracy [%]", "95 %", "difference", "95 %"}, rows) + "\n";
}

std::string over_time_text(const results::Evaluation& evaluation) {
  std::vector<Row> rows;
  const results::OverTime* truth = evaluation.truth ? &evaluation.truth->over_time : nullptr;
  const auto row = [&](const std::string& name, const results::Figure& by_labels, const results::Figure* by_truth) {
    rows.push_back({name, percent(by_labels), bounds(by_labels, 100), by_truth != nullptr ? percent(*by_truth) : "",
                    by_truth != nullptr ? bounds(*by_truth, 100) : ""});
  };
  const auto add = [&](const std::string& name, const results::ShareOverTime& labels, const results::ShareOverTime* by_truth) {
    const auto ms = [](microseconds us) { return us.count() / 1000; };
    const results::OverTimeOptions& options = evaluation.over_time.options;
    row(fmt::format("{}, first {} ms", name, ms(options.first)), labels.first, by_truth ? &by_truth->first : nullptr);
    row(fmt::format("{}, later", name), labels.later, by_truth ? &by_truth->later : nullptr);
    row(fmt::format("{}, last {} ms", name, ms(options.last)), labels.last, by_truth ? &by_truth->last : nullptr);
    row(fmt::format("{}, last minus before it", name), labels.last_minus_before,
        by_truth ? &by_truth->last_minus_before : nullptr);
    row(fmt::format("{}, still predicted {} ms after", name, ms(options.after)), labels.still_predicted,
        by_truth ? &by_truth->still_predicted : nullptr);
  };
  add("press", evaluation.over_time.press.all, truth ? &truth->press.all : nullptr);
  add("slip", evaluation.over_time.slip.all, truth ? &truth->slip.all : nullptr);
  std::vector<std::string> header{"correct ticks of intervals [%]", "labels", "95 %"};
  if (truth) header.insert(header.end(), {"truth", "95 %"});
  return text_table(header, rows) + "\n";
}

std::string engine_text(const results::Evaluation& evaluation) {
  return "\n" +
         wrapped(fmt::format("Engine {}: at {} of {} ticks the two largest logits differ by less than 0.0001. At these ticks "
                             "another engine can predict another class.",
                             evaluation.engine, evaluation.close_ticks, evaluation.ticks)) +
         "\n";
}

}  // namespace

std::string text_of(const results::Evaluation& evaluation) {
  return wrapped(heading_of(evaluation)) + "\n\n" + whole_runs_text(evaluation) + accuracy_text(evaluation) +
         classes_text(evaluation) + guards_text(evaluation) + delays_text(evaluation) + labels_text(evaluation) +
         over_time_text(evaluation) + engine_text(evaluation);
}

std::string text_of(const results::UnseenComparison& comparison, bool simulated) {
  std::vector<Row> rows;
  const auto add_row = [&](const std::string& name, const results::SeenAndHeldOut& of) {
    rows.push_back({name, percent(of.seen), bounds(of.seen, 100), percent(of.held_out), bounds(of.held_out, 100),
                    percent(of.difference), bounds(of.difference, 100)});
  };
  for (const auto& [name, of_object] : comparison.objects) add_row(name, of_object);
  add_row("mean over objects", comparison.mean);
  return wrapped(fmt::format("Objects seen in training ({}) and held out ({}), on {} {} runs", comparison.models->seen,
                             comparison.models->held_out, comparison.runs.size(), simulated ? "simulated" : "real")) +
         "\n" + text_table({"accuracy [%]", "seen", "95 %", "held out", "95 %", "change", "95 %"}, rows);
}

}  // namespace tactile::cli
