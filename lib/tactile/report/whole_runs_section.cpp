#include <fmt/core.h>

#include <algorithm>

#include "tactile/report/detection_plots.hpp"
#include "tactile/report/report_page.hpp"
#include "tactile/results/whole_runs_tables.hpp"

namespace tactile::report {
namespace {

HtmlTable html_of(const results::TextTable& table, const std::string& folded = {}) {
  HtmlTable html{.caption = table.caption, .head = table.head, .rows = {}, .folded = folded};
  for (const std::vector<std::string>& row : table.rows) {
    html.rows.push_back({{.text = row.front()}});
    for (std::size_t i = 1; i < row.size(); ++i) html.rows.back().push_back(number_cell(row[i]));
  }
  return html;
}

std::string suffix_of(const std::string& setting) { return setting.empty() ? "" : "-" + name_part(setting); }

}  // namespace

void add_alarm_curve(ReportPage& page, const std::string& name, const std::string& setting, const results::WholeRuns& whole) {
  if (whole.curve.empty()) return;
  page.figure("operating-curve" + suffix_of(setting),
              operating_curve_plot(page.titled("Delay against false alarms, " + name), whole.curve, whole.decided),
              "Detection delay, and the share of touches that are missed or early, against false alarms per minute.",
              "Delay over all touches, and the share of them that is missed or early, against false alarms per minute. Two "
              "thresholds on the log-odds are moved along the curve. Diamonds: the verdicts as they were decided.");
  page.html.table(html_of(results::calm_table(whole)));
}

void add_whole_runs(ReportPage& page, const std::string& name, const std::string& setting, const results::WholeRuns& whole,
                    const std::map<std::string, results::Baseline>& baselines) {
  const bool is_shown = std::find(page.figures().begin(), page.figures().end(), "operating-curve" + suffix_of(setting)) !=
                        page.figures().end();  // the page begins with the most important one
  if (!is_shown) add_alarm_curve(page, name, setting, whole);
  page.html.paragraph(fmt::format("{} {}", results::runs_in_words(whole), results::whole_runs_legend()));
  page.html.table(html_of(results::confirmed_table(whole)));
  page.html.table(html_of(results::baseline_table(whole, baselines)));
  page.html.table(html_of(results::cause_table(whole)));
  page.html.table(html_of(results::object_table(whole), "Delay and false alarms of each object"));
}

void add_settings(ReportPage& page, const ReportInput& input) {
  if (input.settings_on_whole_runs.empty()) return;
  page.html.section("settings-compared", "Delay against false alarms");
  std::vector<SettingCurve> curves;
  for (const results::StudiedSetting& setting : input.settings_on_whole_runs)
    curves.push_back({.name = setting.text,
                      .is_stream = setting.setting.starts_with("stream"),
                      .is_unseen = setting.is_unseen,
                      .points = setting.whole_runs.curve});
  page.figure("settings-curve", settings_curve_plot(page.titled("Delay against false alarms"), curves),
              "Detection delay against false alarms per minute, for each setting.",
              "Delay over all touches against false alarms per minute, as the thresholds on the log-odds move. Delays of more "
              "than 100 ms are drawn there. Dashed and hollow: objects that the model has never seen.");
  for (const results::StudiedSetting& setting : input.settings_on_whole_runs) {
    page.html.heading(setting.text);
    add_whole_runs(page, setting.text, setting.setting, setting.whole_runs, setting.baselines);
  }
}

}  // namespace tactile::report
