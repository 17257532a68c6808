#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/report/report_page.hpp"
#include "tactile/report/stress_plots.hpp"

namespace tactile::report {
namespace {

void add_holds(ReportPage& page, const results::Stress& stress) {
  HtmlTable table{
      .caption = fmt::format("Holds up to: the severity up to which the accuracy is at most {:g} points below that of "
                             "the unchanged runs, linear between severities, with its 95 % interval",
                             100 * stress.most_lost),
      .head = {"recipe", "what it does"},
      .rows = {},
      .stacks = true};
  for (const results::StressedModel& model : stress.models) {
    table.head.push_back(model.name + " holds");
    table.head.push_back("accuracy at the last severity [%]");
  }
  const auto& curves = stress.models.front().curves;
  // What harms the first model most comes first.
  std::vector<std::size_t> order(curves.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto last_accuracy = [&](std::size_t i) {
    return curves[i].points.empty() || !std::isfinite(curves[i].points.back().accuracy.value)
               ? INFINITY
               : curves[i].points.back().accuracy.value;
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return last_accuracy(a) < last_accuracy(b); });
  for (const std::size_t i : order) {
    std::vector<HtmlCell> row{{.text = curves[i].name}, {.text = curves[i].meaning}};
    for (const results::StressedModel& model : stress.models) {
      const bool has = i < model.curves.size() && !model.curves[i].points.empty();
      row.push_back({.text = has ? results::words_of(model.curves[i]) : "-"});
      row.push_back(has ? percent_cell(model.curves[i].points.back().accuracy) : number_cell("-"));
    }
    table.rows.push_back(std::move(row));
  }
  page.html.table(table);
}

void add_unchanged(ReportPage& page, const results::Stress& stress) {
  HtmlTable table{
      .caption = "The unchanged runs, as 'tactile eval' has them",
      .head = {"model", "trainings", "runs", "accuracy [%]", "detected within 50 ms [%]", "missed [%]", "false alarms/min"},
      .rows = {}};
  for (const results::StressedModel& model : stress.models) {
    const auto curve = std::find_if(model.curves.begin(), model.curves.end(), [](const auto& one) { return !one.is_world; });
    if (curve == model.curves.end() || curve->points.empty()) continue;
    const results::StressPoint& point = curve->points.front();
    table.rows.push_back({{.text = model.name},
                          number_cell(static_cast<double>(model.trainings.size()), 0),
                          number_cell(static_cast<double>(model.runs.size()), 0),
                          percent_cell(point.accuracy),
                          percent_cell(point.whole.within_50_ms),
                          percent_cell(point.whole.missed),
                          figure_cell(point.whole.alarms_per_min)});
  }
  page.html.table(table);
}

}  // namespace

void add_stress(ReportPage& page, const ReportInput& input) {
  if (!input.stress || input.stress->models.empty()) return;
  const results::Stress& stress = *input.stress;
  page.html.section("stress", "When the scene gets worse");
  if (stress.simulated && !input.simulated)
    page.html.warning("This part was measured on simulated runs. It says nothing about a real sensor.");
  page.html.paragraph(stress.judged_by);
  if (!stress.models.front().curves.empty()) {
    add_unchanged(page, stress);
    add_holds(page, stress);
    const std::size_t curves = stress.models.front().curves.size();
    page.figure("stress-accuracy", stress_plot(stress, StressMeasure::accuracy),
                fmt::format("Accuracy against severity of {} recipes.", curves),
                "Accuracy on the balanced samples against severity, one panel a recipe.");
    page.figure("stress-detected", stress_plot(stress, StressMeasure::within_50_ms),
                fmt::format("Share detected within 50 ms against severity of {} recipes.", curves),
                "Share of touches detected within 50 ms after their onset.");
    page.figure("stress-false-alarms", stress_plot(stress, StressMeasure::false_alarms),
                fmt::format("False alarms per minute against severity of {} recipes.", curves),
                "False alarms per minute outside of touches. An alarm counts again for each further 500 ms.");
  }
  if (!stress.models.front().quiet.empty()) {
    page.figure("stress-quiet", stress_plot(stress, StressMeasure::false_alarms, true),
                "False alarms per minute in recordings without a touch.",
                fmt::format("False alarms per minute in {} recordings without a touch.", stress.quiet_files.size()));
  }
}

}  // namespace tactile::report
