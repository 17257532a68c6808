#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tactile/core/duration_units.hpp"
#include "tactile/report/report_page.hpp"

namespace tactile::report {
namespace {

std::string count_text(std::uint64_t count) { return fmt::format("{}", count); }

using NamedAccuracy = std::pair<std::string, const results::Accuracy*>;

/// By each way to measure it, the model's own first.
std::vector<NamedAccuracy> accuracies_of(const results::Evaluation& scores) {
  std::vector<NamedAccuracy> all{{"model", &scores.accuracy}};
  if (scores.truth) all.emplace_back("by true class", &scores.truth->accuracy);
  std::erase_if(all,
                [](const NamedAccuracy& one) { return !std::isfinite(one.second->mean.value) && one.second->objects.empty(); });
  return all;
}

/// Objects, those that the model knows least first.
std::vector<std::pair<std::string, results::Figure>> by_accuracy(const results::Accuracy& accuracy) {
  std::vector<std::pair<std::string, results::Figure>> order;
  for (const auto& [object, figure] : accuracy.objects) {
    if (std::isfinite(figure.value)) order.emplace_back(object, figure);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second.value < b.second.value; });
  return order;
}

void add_accuracy(ReportPage& page, const results::Evaluation& scores) {
  const std::vector<NamedAccuracy> all = accuracies_of(scores);
  if (all.empty()) return;
  page.html.heading("Accuracy");
  HtmlTable means{.caption = "Accuracy [%] on balanced samples; below each its 95 % interval, if there is one.",
                  .head = {"by", "mean over objects", "lowest object", ""},
                  .rows = {}};
  HtmlTable objects{.caption = "Accuracy [%] of each object, the lowest first; below each its 95 % interval, if there is one",
                    .head = {"object"},
                    .rows = {},
                    .folded = "Accuracy of each object"};
  for (const auto& [name, accuracy] : all) {
    const auto order = by_accuracy(*accuracy);
    means.rows.push_back({{.text = name}, percent_cell(accuracy->mean)});
    means.rows.back().push_back(order.empty() ? number_cell("-") : percent_cell(order.front().second));
    means.rows.back().push_back({.text = order.empty() ? "" : order.front().first});
    objects.head.push_back(name);
  }
  for (const auto& [object, figure] : by_accuracy(*all.front().second)) {
    objects.rows.push_back({{.text = object}});
    for (const auto& [name, accuracy] : all) {
      const auto found = accuracy->objects.find(object);
      objects.rows.back().push_back(percent_cell(found == accuracy->objects.end() ? results::Figure{} : found->second));
    }
  }
  page.html.table(means);
  page.html.table(objects);
}

HtmlTable delay_table(const std::string& caption, const std::string& folded) {
  return {.caption = caption,
          .head = {"object", "class", "median of all [ms]", "90 % of all [ms]", "intervals", "missed", "early", "mean [ms]",
                   "standard error"},
          .rows = {},
          .folded = folded};
}

void add_delay(HtmlTable& table, const std::string& object, const std::string& touch, const results::DelaySummary& delay) {
  if (delay.intervals == 0) return;
  table.rows.push_back({{.text = object},
                        {.text = touch},
                        figure_cell(delay.median_of_all_ms),
                        figure_cell(delay.quantile_of_all_ms),
                        number_cell(count_text(delay.intervals)),
                        number_cell(count_text(delay.misses)),
                        number_cell(count_text(delay.early)),
                        number_cell(delay.mean_ms.value),
                        number_cell(delay.sem_ms)});
}

void add_delays(HtmlTable& table, const std::string& touch, const results::DelayTable& delays) {
  if (delays.all.intervals == 0) return;
  add_delay(table, "all objects", touch, delays.all);
  // The slowest objects come first.
  std::vector<std::pair<std::string, results::DelaySummary>> order(delays.objects.begin(), delays.objects.end());
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    const double one = a.second.median_of_all_ms.ms.value, two = b.second.median_of_all_ms.ms.value;
    return std::isfinite(one) && (!std::isfinite(two) || one > two);
  });
  for (const auto& [object, delay] : order) add_delay(table, object, touch, delay);
}

bool has_standard_errors(const results::DelayTable& delays) {
  return std::any_of(delays.objects.begin(), delays.objects.end(),
                     [](const auto& object) { return std::isfinite(object.second.sem_ms); });
}

/// The delays in a sentence or two.
std::string detected_in_words(const results::DelaySummary& press, const results::DelaySummary& slip) {
  const auto median = [](const results::DelaySummary& delay) {
    return (delay.median_of_all_ms.is_lower_bound ? "at least " : "") + results::text_of(delay.median_of_all_ms.ms, " ms");
  };
  return fmt::format("Median delay of all presses: {}; of all slips: {}. Missed: {} of {} presses, {} of {} slips.",
                     median(press), median(slip), press.misses, press.intervals, slip.misses, slip.intervals);
}

void add_delays(ReportPage& page, const ReportedEvaluation& evaluation) {
  const results::Evaluation& scores = evaluation.scores;
  const std::string& model = evaluation.model;
  page.html.heading("Detection delay");
  const results::DelayTable &press = scores.network.press, &slip = scores.network.slip;
  std::set<std::string> names;
  for (const results::DelayTable* delays : {&press, &slip}) {
    for (const auto& object : delays->objects) names.insert(object.first);
  }
  if (names.empty()) {
    page.missing.push_back("Detection delays (the paper's figure 9) of " + model + ".");
  } else {
    if (std::isfinite(press.all.median_of_all_ms.ms.value) && std::isfinite(slip.all.median_of_all_ms.ms.value))
      page.html.paragraph(detected_in_words(press.all, slip.all));
    page.figure(
        "delays", delay_plot(page.titled("Detection delay, " + model), {names.begin(), names.end()}, press.objects, slip.objects),
        fmt::format("Mean detection delay of each object: press {:.1f} ms and slip {:.1f} ms over all.", press.all.mean_ms.value,
                    slip.all.mean_ms.value),
        fmt::format("Detection delay of press and slip{}, as in the paper's figure 9. The best possible delay is one tick, "
                    "{:g} ms. Means do not include missed and early intervals, which are counted beside the bars.",
                    has_standard_errors(press) || has_standard_errors(slip)
                        ? " with standard errors, where an object has two detected intervals"
                        : "; no object has two detected intervals, which a standard error needs",
                    in_ms(scores.tick)));
    HtmlTable table = delay_table(
        "Detection delay from the labelled onset. Median and 90 % are of all intervals: one that is missed or early is later "
        "than "
        "all others, and a quantile that falls on one is a lower bound. The mean is over detected intervals, as in the paper. "
        "Trivial detectors ignore the events; they are scored on the same intervals",
        "Detection delay of each object");
    add_delays(table, "press", press);
    add_delays(table, "slip", slip);
    for (const auto& [name, trivial] : scores.trivial) {
      add_delay(table, "all objects, by " + name, "press", trivial.press.all);
      add_delay(table, "all objects, by " + name, "slip", trivial.slip.all);
    }
    page.html.table(table);
  }
  if (!scores.truth) return;
  HtmlTable table = delay_table("Detection delay from the true onset of the simulation", "Detection delay from the true onset");
  add_delays(table, "press", scores.truth->delay_ms.press);
  add_delays(table, "slip", scores.truth->delay_ms.slip);
  page.html.table(table);
}

void add_classes(ReportPage& page, const results::Evaluation& scores, const std::string& model) {
  if (scores.confusion.samples() > 0) {
    page.html.heading("Confusion");
    page.figure("confusion", confusion_plot(page.titled("Confusion, " + model), scores.confusion),
                "Table of three true classes by three predicted classes.",
                "Predictions on balanced samples of each class: share of the class, and number of samples.");
    HtmlTable table{.caption = "Samples by true class (rows) and predicted class",
                    .head = {"true \\ predicted", "none", "press", "slip"},
                    .rows = {},
                    .folded = "Samples of each class"};
    for (const Touch touch : all_touches) {
      table.rows.push_back({{.text = std::string(name_of(touch))}});
      for (const std::uint64_t count : scores.confusion.counts[static_cast<std::size_t>(touch)])
        table.rows.back().push_back(number_cell(count_text(count)));
    }
    page.html.table(table);
  } else {
    page.missing.push_back("The confusion of " + model + ".");
  }
}

void add_calibration(ReportPage& page, const results::Calibration& calibration, const results::Calibration& whole_runs,
                     const std::string& model) {
  const bool has_samples = std::any_of(calibration.bins.begin(), calibration.bins.end(),
                                       [](const results::ReliabilityBin& bin) { return bin.samples > 0; });
  if (!has_samples) {
    page.missing.push_back("The reliability of " + model + ".");
    return;
  }
  page.html.heading("Calibration");
  page.figure("reliability", reliability_plot(page.titled("Reliability, " + model), calibration.bins),
              "Accuracy against the largest probability, with the number of samples below.",
              fmt::format("Reliability: accuracy by the model's largest probability. Bins of fewer than {} samples are hollow. "
                          "Expected calibration error: {:.2f} %.",
                          few_samples, 100 * calibration.error.value) +
                  (std::isfinite(whole_runs.error.value)
                       ? fmt::format(" At every tick of whole runs, with their shares of the classes: {:.2f} %.",
                                     100 * whole_runs.error.value)
                       : std::string()));
}

}  // namespace

void add_evaluation(ReportPage& page, const ReportedEvaluation& evaluation) {
  const results::Evaluation& scores = evaluation.scores;
  const std::string& model = evaluation.model;
  const bool has_history = std::isfinite(evaluation.history_ms);
  const std::string where = evaluation.runs.size() > 60 ? std::string("its test runs") : evaluation.runs;
  page.html.section("evaluation",
                    fmt::format("Detection: {}{}{}{}", model, has_history ? fmt::format(" ({:g} ms)", evaluation.history_ms) : "",
                                where.empty() ? "" : ", ", where));
  page.html.paragraph(fmt::format(
      "{}, a tick every {:g} ms, {}. Runs: {}.",
      has_history ? fmt::format("Model {}, history {:g} ms", model, evaluation.history_ms) : model, in_ms(scores.tick),
      !scores.thresholds.empty() ? "thresholds " + scores.thresholds : "confirmation " + scores.confirm,
      evaluation.runs.empty() ? "those of its evaluation" : evaluation.runs));
  if (scores.whole_runs.runs.empty()) {
    page.missing.push_back("Delay against false alarms of " + model + ".");
  } else {
    page.html.heading("Delay against false alarms");
    add_whole_runs(page, model, {}, scores.whole_runs, scores.baselines);
  }
  add_accuracy(page, scores);
  add_delays(page, evaluation);
  add_classes(page, scores, model);
  add_calibration(page, scores.calibration, scores.whole_run_calibration, model);
}

}  // namespace tactile::report
