#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/report/report_input.hpp"

namespace tactile::report {

/// The contents of a report, and what is missing.
struct ReportSummary {
  std::string title;
  bool simulated = false;
  std::filesystem::path page;                    ///< one HTML file, which needs no other
  std::vector<std::string> figures;              ///< by name: `figures/NAME.svg` and `.png` next to the page
  std::vector<std::string> missing;              ///< sentences: what was not measured or could not be drawn
  std::vector<std::string> errors;               ///< sentences: why runs could not be drawn
  std::size_t claims = 0, hold = 0, do_not = 0;  ///< of the paper's claims; the others cannot be decided
};

/// Called with the name of each figure before it is drawn; may throw to stop.
using FigureCallback = std::function<void(std::string_view name)>;

/// Draws every figure that has results, and writes them with tables, settings and the paper's claims as one self-contained page:
/// `out/report.html`, `out/figures/NAME.svg` and `.png`. Each file appears whole or not at all, the page last; figures of an
/// earlier report that are not drawn again are removed.
/// @throws Error  if gnuplot is not installed, a run over time is not of its format, or a file cannot be written
ReportSummary write_report(const ReportInput& input, const std::filesystem::path& out, const FigureCallback& report_figure = {});

/// The same for a folder of `tactile reproduce`.
/// @throws Error  also as `read_study` does
ReportSummary write_report(const std::filesystem::path& study, const std::filesystem::path& out,
                           const FigureCallback& report_figure = {});

}  // namespace tactile::report
