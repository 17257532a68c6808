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

  return text;
}

std::string classes_text(const results::Evaluation& evaluation) {
  std::vector<Row> rows;
  for (const Touch truth : all_touches) {
    const auto index = static_cast<std::size_t>(truth);
    Row row{std::string(name_of(truth))};
    for (const std::uint64_t count : evaluation.confusion.counts[index]) row.push_back(std::to_string(count));
    rows.push_back(row);
  }
  return text_table({"true \\ predicted", "none", "press", "slip"}, rows) + "\n" +
         wrapped(fmt::format("Expected calibration error of the model's probabilities: {} % {} on balanced samples, {} % {} at "
                             "every tick of whole runs, with their shares of the classes.",
                             percent(evaluation.calibration.error), bounds(evaluation.calibration.error, 100),
                             percent(evaluation.whole_run_calibration.error),
                             bounds(evaluation.whole_run_calibration.error, 100))) +
         "\n\n";
}

std::string engine_text(const results::Evaluation& evaluation) {
  return "\n" +
         wrapped(fmt::format("Engine {}: at {} of {} ticks the two largest logits differ by less than 0.0001. At these ticks "
                             "another engine can predict another class.",
                             evaluation.engine.name, evaluation.engine.close_ticks, evaluation.engine.ticks)) +
         "\n";
}

}  // namespace

std::string text_of(const results::Evaluation& evaluation) {
  return wrapped(heading_of(evaluation)) + "\n\n" + whole_runs_text(evaluation) + accuracy_text(evaluation) +
         classes_text(evaluation) + delays_text(evaluation) + engine_text(evaluation);
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
