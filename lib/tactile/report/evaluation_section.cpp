#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tactile/core/duration_units.hpp"
#include "tactile/report/detection_plots.hpp"
#include "tactile/report/report_page.hpp"
#include "tactile/results/whole_runs_tables.hpp"

namespace tactile::report {
namespace {

std::string count_text(std::uint64_t count) { return fmt::format("{}", count); }

using NamedAccuracy = std::pair<std::string, const results::Accuracy*>;

/// By each way to measure it, the model's own first.
std::vector<NamedAccuracy> accuracies_of(const results::Evaluation& scores) {
  std::vector<NamedAccuracy> all{{"model", &scores.accuracy}};
  // The first guard is the dataset's own, which the model has.
  for (std::size_t i = 1; i < scores.guards.size(); ++i)
    all.emplace_back(fmt::format("guard {:g} ms", in_ms(scores.guards[i].guard)), &scores.guards[i].accuracy);
  if (scores.truth) all.emplace_back("by true class", &scores.truth->accuracy);
  for (const results::BaselineScore& baseline : scores.baselines)
    all.emplace_back("baseline " + baseline.name, &baseline.accuracy);
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
  HtmlTable means{.caption =
                      "Accuracy [%] on balanced samples; below each its 95 % interval, if there is one. Guard: minimum distance "
                      "of none samples "
                      "from every interval; the paper uses 0 ms. Baselines are simpler methods on the same samples.",
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
    if (!name.starts_with("baseline ")) objects.head.push_back(name);
  }
  for (const auto& [object, figure] : by_accuracy(*all.front().second)) {
    objects.rows.push_back({{.text = object}});
    for (const auto& [name, accuracy] : all) {
      if (name.starts_with("baseline ")) continue;
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

HtmlCell quantile_cell(const results::CensoredQuantile& quantile) {
  HtmlCell cell = figure_cell(quantile.ms);
  if (quantile.is_lower_bound) cell.text = "at least " + cell.text;
  return cell;
}

void add_delay(HtmlTable& table, const std::string& object, const std::string& touch, const results::DelaySummary& delay) {
  if (delay.intervals == 0) return;
  table.rows.push_back({{.text = object},
                        {.text = touch},
                        quantile_cell(delay.median_of_all_ms),
                        quantile_cell(delay.quantile_of_all_ms),
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

/// What the uncertainty of the labels changes.
void add_labels(ReportPage& page, const results::Evaluation& scores) {
  const results::LabelUncertainty& drawn = scores.label_uncertainty;
  const results::DelaySummary &press = scores.network.press.all, &slip = scores.network.slip.all;
  if (drawn.draws > 0) {
    HtmlTable table{
        .caption = fmt::format("Labels drawn {} times from the 95 % intervals of their onsets and ends. Labels alone: "
                               "the middle 95 % of these draws, of the same runs. Both: draws of runs and of labels",
                               drawn.draws),
        .head = {"figure", "as labelled", "labels alone", "both"},
        .rows = {},
        .folded = "What the uncertainty of the labels changes"};
    const auto add = [&](const std::string& name, const results::Figure& labelled, const results::SpreadByLabels& spread,
                         double scale) {
      if (!std::isfinite(spread.mean)) return;
      const results::Figure alone{scale * spread.mean, scale * spread.low, scale * spread.high};
      table.rows.push_back({{.text = name},
                            figure_cell(scaled(labelled, scale)),
                            figure_cell(alone),
                            figure_cell(scaled(spread.with_runs, scale))});
    };
    add("accuracy [%]", scores.accuracy.mean, drawn.accuracy, 100);
    add("mean delay of press [ms]", press.mean_ms, drawn.press_mean_ms, 1);
    add("median of all presses [ms]", press.median_of_all_ms.ms, drawn.press_median_ms, 1);
    add("mean delay of slip [ms]", slip.mean_ms, drawn.slip_mean_ms, 1);
    add("median of all slips [ms]", slip.median_of_all_ms.ms, drawn.slip_median_ms, 1);
    page.html.table(table);
  }
}

std::string suffix_of(const ReportedEvaluation& evaluation) {
  return evaluation.id.empty() || evaluation.id == "reported" ? std::string() : "-" + name_part(evaluation.id);
}

/// The delays in a sentence or two.
std::string detected_in_words(const results::DelaySummary& press, const results::DelaySummary& slip) {
  const auto median = [](const results::DelaySummary& delay) {
    return (delay.median_of_all_ms.is_lower_bound ? "at least " : "") + results::text_of(delay.median_of_all_ms.ms, " ms");
  };
  return fmt::format("Median delay of all presses: {}; of all slips: {}. Missed: {} of {} presses, {} of {} slips.",
                     median(press), median(slip), press.misses, press.intervals, slip.misses, slip.intervals);
}

void add_detected_within(ReportPage& page, const ReportedEvaluation& evaluation) {
  const results::DelayTable &press = evaluation.scores.network.press, &slip = evaluation.scores.network.slip;
  if (press.curve.empty() && slip.curve.empty()) return;
  page.figure("detection-curve" + suffix_of(evaluation),
              detection_curve_plot(page.titled("Detected within a time, " + evaluation.model), press.curve, slip.curve),
              "Share of presses and slips detected by a time after their onset.",
              "The share of intervals detected within a time after the labelled onset, by Kaplan and Meier: a missed interval "
              "counts as not detected until its end, at most 500 ms. Those predicted ahead of the onset are at 0.");
}

void add_delays(ReportPage& page, const ReportedEvaluation& evaluation, const std::string& suffix) {
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
    add_detected_within(page, evaluation);
    page.figure(
        "delays" + suffix,
        delay_plot(page.titled("Detection delay, " + model), {names.begin(), names.end()}, press.objects, slip.objects),
        fmt::format("Mean detection delay of each object: press {:.1f} ms and slip {:.1f} ms over all.", press.all.mean_ms.value,
                    slip.all.mean_ms.value),
        fmt::format("Detection delay of press and slip{}, as in the paper's figure 9. The best possible delay is one tick, "
                    "{:g} ms. Means do not include missed and early intervals, which are counted beside the bars.",
                    has_standard_errors(press) || has_standard_errors(slip)
                        ? " with standard errors, where an object has two detected intervals"
                        : "; no object has two detected intervals, which a standard error needs",
                    in_ms(scores.tick)));
    HtmlTable table = delay_table(
        "Detection delay from the labelled onset. Median and 90 % are of all intervals: a miss counts with the time until which "
        "it could be detected. If misses are below the quantile, it is a lower bound. The mean is over detected intervals, as in "
        "the paper. Trivial detectors ignore the events; they are scored on the same intervals",
        "Detection delay of each object");
    add_delays(table, "press", press);
    add_delays(table, "slip", slip);
    for (const auto& [name, trivial] : scores.trivial) {
      add_delay(table, "all objects, by " + name, "press", trivial.press.all);
      add_delay(table, "all objects, by " + name, "slip", trivial.slip.all);
    }
    page.html.table(table);
  }
  add_labels(page, scores);
  if (!scores.truth) return;
  HtmlTable table = delay_table(
      "Detection delay from the true onset of the simulation; gross: from the first motion between object and tip, negative "
      "where "
      "slip is predicted before it",
      "Detection delay from the true onset");
  add_delays(table, "press", scores.truth->press);
  add_delays(table, "slip", scores.truth->slip);
  add_delays(table, "slip, gross", scores.truth->gross_slip);
  page.html.table(table);
}

HtmlTable html_of(const results::TextTable& table, const std::string& folded = {}) {
  HtmlTable html{.caption = table.caption, .head = table.head, .rows = {}, .folded = folded};
  for (const std::vector<std::string>& row : table.rows) {
    html.rows.push_back({{.text = row.front()}});
    for (std::size_t i = 1; i < row.size(); ++i) html.rows.back().push_back(number_cell(row[i]));
  }
  return html;
}

/// Every run, whole: what a robot meets.
void add_whole_runs(ReportPage& page, const ReportedEvaluation& evaluation, bool curve_is_shown) {
  const results::WholeRuns& whole = evaluation.scores.whole_runs;
  if (whole.runs.empty()) {
    page.missing.push_back("Delay against false alarms of " + evaluation.model + ".");
    return;
  }
  page.html.heading("Delay against false alarms");
  if (!curve_is_shown) add_alarm_curve(page, evaluation);
  page.html.paragraph(
      results::runs_in_words(whole) +
      " Every run counts, also firm lifts, those without a press or a slip, and flagged ones. A false alarm is an episode that "
      "begins outside of touches, whatever moves; it counts again for each further 500 ms. A touch that is missed, or in alarm "
      "since before its onset (early), is later than all others.");
  page.html.table(html_of(results::confirmed_table(whole)));
  page.html.table(html_of(results::cause_table(whole)));
  page.html.table(html_of(results::object_table(whole), "Delay and false alarms of each object"));
}

void add_classes(ReportPage& page, const results::Evaluation& scores, const std::string& model, const std::string& suffix) {
  if (scores.confusion.samples() > 0) {
    page.html.heading("Confusion");
    page.figure("confusion" + suffix, confusion_plot(page.titled("Confusion, " + model), scores.confusion),
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
  HtmlTable table{.caption = "Scores of each class [%], on balanced samples",
                  .head = {"class", "precision", "recall", "F1"},
                  .rows = {},
                  .folded = "Scores of each class"};
  for (const Touch touch : all_touches) {
    const results::ClassScore& score = scores.classes.all[static_cast<std::size_t>(touch)];
    const auto measured = {score.precision.value, score.recall.value, score.f1.value};
    if (std::none_of(measured.begin(), measured.end(), [](double value) { return std::isfinite(value); })) continue;
    table.rows.push_back({{.text = std::string(name_of(touch))},
                          percent_cell(score.precision),
                          percent_cell(score.recall),
                          percent_cell(score.f1)});
  }
  page.html.table(table);
}

void add_calibration(ReportPage& page, const results::Calibration& calibration, const results::Calibration& whole_runs,
                     const std::string& model, const std::string& suffix) {
  const bool has_samples = std::any_of(calibration.bins.begin(), calibration.bins.end(),
                                       [](const results::ReliabilityBin& bin) { return bin.samples > 0; });
  if (!has_samples) {
    page.missing.push_back("The reliability of " + model + ".");
    return;
  }
  page.html.heading("Calibration");
  page.figure("reliability" + suffix, reliability_plot(page.titled("Reliability, " + model), calibration.bins),
              "Accuracy against the largest probability, with the number of samples below.",
              fmt::format("Reliability: accuracy by the model's largest probability. Bins of fewer than {} samples are hollow. "
                          "Expected calibration error: {:.2f} %.",
                          few_samples, 100 * calibration.error.value) +
                  (std::isfinite(whole_runs.error.value)
                       ? fmt::format(" At every tick of whole runs, with their shares of the classes: {:.2f} %.",
                                     100 * whole_runs.error.value)
                       : std::string()));
}

void add_over_time(ReportPage& page, const results::OverTime& over_time, const std::string& model, const std::string& suffix) {
  const auto has_bins = [](const results::AccuracyOverTime& touch) {
    return !touch.since_onset.empty() || !touch.before_end.empty();
  };
  if (has_bins(over_time.press) || has_bins(over_time.slip)) {
    page.html.heading("Within intervals");
    page.figure("over-time" + suffix,
                over_time_plot(page.titled("Correct ticks within intervals, " + model), over_time.press, over_time.slip),
                "Share of ticks predicted correctly since the onset and before the end of presses and slips.",
                "Predictions over each whole interval: since its onset, and before its end, where they get worse in the paper. "
                "Training uses only the first 500 ms. Times with intervals of fewer than three objects are left out, if others "
                "have more.");
  }
  HtmlTable table{
      .caption =
          "Share of ticks predicted correctly [%]: in the first 500 ms of intervals; later; in their last 200 ms; before the "
          "last 200 ms of longer intervals; the difference of these two. Last column: ticks just after an interval that "
          "still predict press or slip; part of them is due to the history itself",
      .head = {"class", "first", "later", "last", "before the last", "last less before", "still predicted after"},
      .rows = {},
      .folded = "Correct ticks in figures"};
  for (const auto& [name, accuracy] :
       {std::pair("press", &over_time.press), std::pair("slip", &over_time.slip), std::pair("both", &over_time.both)}) {
    const results::ShareOverTime& share = accuracy->all;
    const auto columns = {share.first,          share.later, share.last, share.before_last, share.last_minus_before,
                          share.still_predicted};
    if (std::none_of(columns.begin(), columns.end(), [](const results::Figure& figure) { return std::isfinite(figure.value); }))
      continue;
    table.rows.push_back({{.text = name}});
    for (const results::Figure& figure : columns) table.rows.back().push_back(percent_cell(figure));
  }
  page.html.table(table);
}

}  // namespace

void add_alarm_curve(ReportPage& page, const ReportedEvaluation& evaluation) {
  const results::WholeRuns& whole = evaluation.scores.whole_runs;
  if (whole.curve.empty()) return;
  page.figure("operating-curve" + suffix_of(evaluation),
              operating_curve_plot(page.titled("Delay against false alarms, " + evaluation.model), whole.curve, whole.decided),
              "Detection delay, and the share of touches that are missed or early, against false alarms per minute.",
              "Delay over all touches, and the share of them that is missed or early, against false alarms per minute. Two "
              "thresholds on the log-odds are moved along the curve. Diamonds: the verdicts as they were decided.");
  page.html.table(html_of(results::calm_table(whole)));
}

void add_evaluation(ReportPage& page, const ReportedEvaluation& evaluation, bool curve_is_shown) {
  const results::Evaluation& scores = evaluation.scores;
  const std::string& model = evaluation.model;
  const bool has_history = std::isfinite(evaluation.history_ms);
  const std::string suffix = suffix_of(evaluation);
  const std::string where = evaluation.runs.size() > 60 ? std::string("its test runs") : evaluation.runs;
  page.html.section("evaluation" + suffix,
                    fmt::format("Detection: {}{}{}{}", model, has_history ? fmt::format(" ({:g} ms)", evaluation.history_ms) : "",
                                where.empty() ? "" : ", ", where));
  if (evaluation.is_folded) page.html.begin_folded("The same figures by the paper's method");
  page.html.paragraph(fmt::format(
      "{}, a tick every {:g} ms, {}. Runs: {}.",
      has_history ? fmt::format("Model {}, history {:g} ms", model, evaluation.history_ms) : model, in_ms(scores.tick),
      !scores.thresholds.empty() ? "thresholds " + scores.thresholds : "confirmation " + scores.confirm,
      evaluation.runs.empty() ? "those of its evaluation" : evaluation.runs));
  add_whole_runs(page, evaluation, curve_is_shown);
  add_accuracy(page, scores);
  add_delays(page, evaluation, suffix);
  add_classes(page, scores, model, suffix);
  add_calibration(page, scores.calibration, scores.whole_run_calibration, model, suffix);
  add_over_time(page, scores.over_time, model, suffix);
  if (evaluation.is_folded) page.html.end_folded();
}

}  // namespace tactile::report
