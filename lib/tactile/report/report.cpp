#include "tactile/report/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/report/figure_parts.hpp"
#include "tactile/report/prediction_file.hpp"
#include "tactile/report/report_page.hpp"

namespace tactile::report {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_runs_over_time = 6;

void begin(ReportPage& page, const ReportInput& input) {
  if (input.simulated) {
    page.html.warning(
        "The data is simulated. Every figure on this page was measured on simulated runs, and says nothing about a real sensor. "
        "Differences from the paper may come from the simulation as well as from the method.");
  }
  if (!input.found.empty()) page.html.list(input.found);
}

/// How to read the rest of the page, and what is special about these results.
void explain(ReportPage& page, const ReportInput& input) {
  page.html.begin_folded("How to read this page");
  page.html.paragraph(
      "Results are compared with Faris et al., arXiv:2403.10120, called \"paper\" here. Brackets and whiskers are 95 % intervals "
      "over worlds, where there are three or more; else over trainings, objects and runs. With one training they hold for that "
      "training only. There is no interval for fewer than three runs or objects, and none for two trainings. Intervals of false "
      "alarms per minute also allow for few alarms in a "
      "short time.");
  if (!input.remarks.empty()) page.html.list(input.remarks);
  page.html.end_folded();
}

/// Figures that an earlier report drew, and this one did not, are removed. Other files stay.
void remove_old_figures(const fs::path& folder, const std::vector<std::string>& drawn) {
  static constexpr std::array<std::string_view, 16> ours{"detection-curve",
                                                         "over-time",
                                                         "variance",
                                                         "frames",
                                                         "accuracy-by-history",
                                                         "delays",
                                                         "operating-curve",
                                                         "settings-curve",
                                                         "confusion",
                                                         "reliability",
                                                         "run-",
                                                         "unseen",
                                                         "training",
                                                         "figure-",
                                                         "trade-",
                                                         "stress-"};
  std::error_code ignored;
  std::vector<fs::path> old;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const fs::path& file = entry.path();
    const std::string stem = file.stem().string();
    const bool is_picture = file.extension() == ".svg" || file.extension() == ".png";
    const bool is_ours = std::any_of(ours.begin(), ours.end(), [&](std::string_view name) { return stem.starts_with(name); });
    if (is_picture && is_ours && std::find(drawn.begin(), drawn.end(), stem) == drawn.end()) old.push_back(file);
  }
  for (const fs::path& file : old) fs::remove(file, ignored);
}

void end(ReportPage& page, const ReportInput& input) {
  page.html.section("settings", "Settings, seeds, software, machine and times");
  for (const ReportedTable& table : input.settings) page.table(table);
  page.html.paragraph(fmt::format("This page was written by tactile {} ({}). Its figures are in figures/, as SVG and PNG.",
                                  version(), revision()));
}

}  // namespace

void add_runs(ReportPage& page, const ReportInput& input) {
  if (input.runs.empty()) return;
  page.html.section("runs", "Whole runs over time");
  for (std::size_t i = 0; i < std::min(input.runs.size(), most_runs_over_time); ++i) {
    const results::ReportedRun& run = input.runs[i];
    pictures::PredictionPicture picture = read_prediction(run.csv, run.history_ms);
    picture.title = page.titled(fmt::format("{}, predicted by {}", run.run, run.model));
    picture.remarks.push_back(fmt::format("Events of {:g} ms.", run.history_ms));
    const fs::path outcome = fs::path(run.csv).replace_extension(".json");
    std::error_code ignored;
    if (fs::is_regular_file(outcome, ignored))
      add_outcome(picture, outcome);
    else
      page.missing.push_back(fmt::format("How the intervals of {} were detected: {} does not exist.", run.run, outcome.string()));
    page.figure(
        "run-" + name_part(run.run) + "-" + name_part(run.model), pictures::prediction_plot(picture, page_width),
        fmt::format("Predictions of {} over the whole of {}.", run.model, run.run),
        fmt::format("A whole run, as in the paper's figure 10: {} by {}. Event rate, probabilities of press and slip, and "
                    "predictions above {}.",
                    run.run, run.model,
                    picture.has_truth ? "the truth, by which they are judged, and the labels" : "the labels"));
  }
  if (input.runs.size() > most_runs_over_time)
    page.html.paragraph(
        fmt::format("{} more runs over time are in the study's folder.", input.runs.size() - most_runs_over_time));
}

void add_trainings(ReportPage& page, const ReportInput& input) {
  if (input.trainings.empty()) return;
  page.html.section("training", "Training");
  page.figure("training", training_plot(page.titled("Training"), input.trainings),
              "Loss and accuracy of each training, epoch by epoch.",
              "Loss and accuracy on the training samples, epoch by epoch.");
  HtmlTable table{.caption = "The last epoch of each training",
                  .head = {"model", "epoch", "loss", "accuracy in training [%]"},
                  .rows = {},
                  .folded = "The last epoch of each training"};
  for (const TrainingCurve& curve : input.trainings) {
    if (curve.epochs.empty()) continue;
    const TrainingCurve::Epoch& last = curve.epochs.back();
    table.rows.push_back(
        {{.text = curve.name}, number_cell(last.epoch, 0), number_cell(last.loss, 4), number_cell(100 * last.accuracy)});
  }
  page.html.table(table);
}

ReportSummary write_report(const ReportInput& input, const fs::path& out, const FigureCallback& report_figure) {
  ReportPage page(input, out, report_figure);
  begin(page, input);
  if (!input.evaluations.empty())
    add_alarm_curve(page, input.evaluations.front().model, {}, input.evaluations.front().scores.whole_runs);
  explain(page, input);
  add_settings(page, input);
  add_claims(page, input);
  add_frames(page, input);
  add_histories(page, input);
  for (const ReportedEvaluation& evaluation : input.evaluations) add_evaluation(page, evaluation);
  add_runs(page, input);
  add_unseen(page, input);
  add_trade(page, input);
  add_stress(page, input);
  add_trainings(page, input);
  end(page, input);

  const auto count = [&](results::Outcome outcome) {
    return static_cast<std::size_t>(std::count_if(input.claims.begin(), input.claims.end(),
                                                  [outcome](const results::Claim& claim) { return claim.outcome == outcome; }));
  };
  ReportSummary summary{.title = page.html.title(),
                        .simulated = input.simulated,
                        .page = out / "report.html",
                        .figures = page.figures(),
                        .missing = page.missing,
                        .errors = page.errors,
                        .claims = input.claims.size(),
                        .hold = count(results::Outcome::holds),
                        .do_not = count(results::Outcome::does_not)};
  write_whole(summary.page, page.html.text());
  remove_old_figures(out / "figures", summary.figures);
  return summary;
}

ReportSummary write_report(const fs::path& study, const fs::path& out, const FigureCallback& report_figure) {
  return write_report(read_study(study), out, report_figure);
}

}  // namespace tactile::report
