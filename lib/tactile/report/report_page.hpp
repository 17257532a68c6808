#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/report/html_page.hpp"
#include "tactile/report/report.hpp"

namespace tactile::report {

/// A report in the making: its page, and the figures next to it.
class ReportPage {
 public:
  /// @param out   folder of the report
  /// @param report_figure  called with each figure's name before it is drawn; may be empty
  ReportPage(const ReportInput& input, std::filesystem::path out, FigureCallback report_figure);

  HtmlPage html;
  std::vector<std::string> missing, errors;  ///< as in ReportSummary

  /// `words`, marked where the runs are simulated.
  std::string titled(const std::string& words) const { return is_simulated_ ? words + " (simulated runs)" : words; }

  /// Draws a figure as SVG and PNG, and puts it onto the page.
  /// @param name      a number is added where an earlier figure has it
  /// @param in_words  for readers who cannot see it
  void figure(const std::string& name, const pictures::Plot& plot, const std::string& in_words, const std::string& caption);

  void table(const ReportedTable& table);  ///< folded: a click on its caption shows it

  const std::vector<std::string>& figures() const { return drawn_; }

 private:
  bool is_simulated_;
  std::filesystem::path out_;
  FigureCallback report_figure_;
  std::vector<std::string> drawn_;
};

/// The part of a figure's name for an id from a file: lower-case letters and digits, joined by '-', at most 40 characters.
std::string name_part(std::string_view id);

HtmlCell number_cell(const std::string& text, const std::string& second_line = {});
HtmlCell number_cell(double value, int digits = 2);  ///< "-" where it is not finite

/// "95.12", and below it "93.10 to 97.00", both times `factor`; "-" where there is no value.
HtmlCell figure_cell(const results::Figure& measured, double factor = 1);
HtmlCell figure_cell(const results::CensoredQuantile& quantile);  ///< "at least 500.00" where only a bound is known
inline HtmlCell percent_cell(const results::Figure& measured) { return figure_cell(measured, 100); }

// The sections of the page. One without input writes nothing, and may add to `missing`.

void add_claims(ReportPage& page, const ReportInput& input);
void add_frames(ReportPage& page, const ReportInput& input);
void add_histories(ReportPage& page, const ReportInput& input);
/// Delay against false alarms over whole runs; nothing without them.
/// @param setting  names the figure; may be empty
void add_alarm_curve(ReportPage& page, const std::string& name, const std::string& setting, const results::WholeRuns& whole);
/// The same, if the page has no such figure yet, and all other tables of whole runs.
void add_whole_runs(ReportPage& page, const std::string& name, const std::string& setting, const results::WholeRuns& whole,
                    const std::map<std::string, results::Baseline>& baselines = {});
void add_settings(ReportPage& page, const ReportInput& input);
void add_evaluation(ReportPage& page, const ReportedEvaluation& evaluation);
void add_runs(ReportPage& page, const ReportInput& input);
void add_unseen(ReportPage& page, const ReportInput& input);
void add_trade(ReportPage& page, const ReportInput& input);
void add_stress(ReportPage& page, const ReportInput& input);
void add_trainings(ReportPage& page, const ReportInput& input);

}  // namespace tactile::report
