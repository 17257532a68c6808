#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <system_error>

#include "tactile/core/error_text.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/pictures/frames_picture.hpp"
#include "tactile/report/report_page.hpp"

namespace tactile::report {
namespace {

namespace fs = std::filesystem;

std::string best_in_words(const HistoryCurve& curve) {
  const auto best = best_of(curve);
  if (best == curve.points.end()) return "no accuracy";
  return fmt::format("{:.1f} % at {:g} ms", 100 * best->accuracy.value, best->history_ms);
}

HtmlTable history_table(const ReportedHistories& histories) {
  HtmlTable table{
      .caption = fmt::format("Accuracy [%] by history t_h, on {}; below each its 95 % interval, if there is one", histories.runs),
      .head = {"object"},
      .rows = {},
      .folded = "Accuracy of each object by history"};
  std::set<double> columns;
  for (const HistoryCurve& curve : histories.curves) {
    for (const HistoryCurve::Point& point : curve.points) columns.insert(point.history_ms);
  }
  for (const double history : columns) table.head.push_back(fmt::format("{:g} ms", history));
  table.head.emplace_back("best");
  for (const HistoryCurve& curve : histories.curves) {
    std::vector<HtmlCell> row{{.text = curve.name}};
    for (const double history : columns) {
      const auto point = std::find_if(curve.points.begin(), curve.points.end(),
                                      [history](const HistoryCurve::Point& p) { return p.history_ms == history; });
      row.push_back(point == curve.points.end() ? number_cell("-") : percent_cell(point->accuracy));
    }
    const auto best = best_of(curve);
    row.push_back(number_cell(best == curve.points.end() ? std::string("-") : fmt::format("{:g} ms", best->history_ms)));
    table.rows.push_back(std::move(row));
  }
  return table;
}

HtmlTable unseen_table(const results::UnseenComparison& comparison) {
  HtmlTable table{.caption =
                      "Accuracy [%] on objects seen in training and held out, and its change [points]; below each its 95 % "
                      "interval, if there is one",
                  .head = {"object", "seen", "held out", "difference"},
                  .rows = {},
                  .folded = "Accuracy of each object, seen and held out"};
  const auto add = [&](const std::string& name, const results::SeenAndHeldOut& of) {
    table.rows.push_back({{.text = name}, percent_cell(of.seen), percent_cell(of.held_out), percent_cell(of.difference)});
  };
  add("mean over objects", comparison.mean);
  // What suffers most from being held out comes first.
  std::vector<std::pair<std::string, results::SeenAndHeldOut>> order(comparison.objects.begin(), comparison.objects.end());
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    const double one = a.second.difference.value, two = b.second.difference.value;
    return std::isfinite(one) && (!std::isfinite(two) || one < two);
  });
  for (const auto& [object, of_object] : order) add(object, of_object);
  return table;
}

}  // namespace

void add_frames(ReportPage& page, const ReportInput& input) {
  std::vector<RunFolder> runs;
  std::error_code ignored;
  if (!input.data.empty() && fs::is_directory(input.data, ignored)) runs = find_runs(input.data);
  std::erase_if(runs, [](const RunFolder& one) { return !is_there(one.labels()); });
  // The paper's own example, else the first labelled run with a press and a slip.
  std::stable_partition(runs.begin(), runs.end(), [](const RunFolder& one) { return one.object == "water-bottle"; });
  const heatmaps::HeatmapOptions options{.history = microseconds{std::llround(1000 * input.history_ms)}};
  std::vector<pictures::TouchFrame> frames;
  auto run = runs.begin();
  for (; run != runs.end(); ++run) {
    try {
      frames = pictures::frames_of(*run, options);
    } catch (const std::exception& e) {
      page.errors.push_back(sentence_of(e, run->name()));
      page.missing.push_back(fmt::format("Frames of {} cannot be drawn: {}.", run->name(), page.errors.back()));
    }
    if (!frames.empty()) break;
  }
  if (frames.empty()) {
    page.missing.push_back("Frames of a press and a slip need a folder of labelled runs; none was found.");
    return;
  }
  page.html.section("frames", "What the sensor sees");
  page.figure(
      "frames", pictures::frames_plot(page.titled(fmt::format("{}: {:g} ms of events", run->name(), input.history_ms)), frames),
      "Six moments around a press and a slip: event counts above, noise-reduced heatmaps below.",
      fmt::format("Raw and noise-reduced frames of {}: before the press, during it, before the slip, during it. Above: "
                  "events of the last {:g} ms per pixel. Below: the heatmap, which is the input of the network. Brightness "
                  "= square root of the count.",
                  run->name(), input.history_ms));
}

void add_histories(ReportPage& page, const ReportInput& input) {
  if (input.histories.empty()) return;
  page.html.section("history", "Effect of longer histories");
  for (const ReportedHistories& histories : input.histories) {
    const std::string best = best_in_words(histories.curves.front());
    page.html.paragraph(fmt::format("The mean over objects is best with {}, on {}.", best, histories.runs));
    page.figure("accuracy-by-history",
                accuracy_by_history_plot(page.titled("Accuracy by history, " + histories.runs), histories.curves),
                fmt::format("Accuracy against history for each object; the mean is highest with {}.", best),
                fmt::format("Accuracy by event history t_h, as in the paper's figure 8, on {}.", histories.runs));
    page.html.table(history_table(histories));
  }
}

void add_unseen(ReportPage& page, const ReportInput& input) {
  if (input.unseen.empty()) return;
  page.html.section("unseen", "Unseen objects");
  for (const UnseenSection& unseen : input.unseen) {
    const results::UnseenComparison& comparison = unseen.comparison;
    const std::string name =
        comparison.models ? fmt::format("{} and {}", comparison.models->seen, comparison.models->held_out) : unseen.name;
    const std::string where = unseen.runs.empty() || unseen.runs.size() > 60 ? std::string("their test runs") : unseen.runs;
    page.html.paragraph(fmt::format("{}: on objects that it has never seen the accuracy changes by {}, mean over {} object{}.",
                                    name, results::text_of(results::scaled(comparison.mean.difference, 100), " points", "+.1f"),
                                    comparison.objects.size(), comparison.objects.size() == 1 ? "" : "s"));
    page.figure(unseen.setting.empty() ? "unseen" : "unseen-" + name_part(unseen.setting),
                unseen_plot(page.titled("Seen and unseen objects, " + name), comparison.objects),
                fmt::format("Accuracy on {} objects with them in training and without: {:.1f} % and {:.1f} % on average.",
                            comparison.objects.size(), 100 * comparison.mean.seen.value, 100 * comparison.mean.held_out.value),
                fmt::format("Accuracy on each object with it in training and without, as in the paper's figure 11. Runs: {}; "
                            "neither model was trained on them.",
                            where));
    page.html.table(unseen_table(comparison));
  }
}

}  // namespace tactile::report
