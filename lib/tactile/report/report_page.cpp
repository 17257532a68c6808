#include "tactile/report/report_page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/whole_file.hpp"

namespace tactile::report {

ReportPage::ReportPage(const ReportInput& input, std::filesystem::path out, FigureCallback report_figure)
    : html(input.title.empty() ? "Report of results" : input.title),
      missing(input.missing),
      is_simulated_(input.simulated),
      out_(std::move(out)),
      report_figure_(std::move(report_figure)) {}

void ReportPage::figure(const std::string& name, const pictures::Plot& plot, const std::string& in_words,
                        const std::string& caption) {
  std::string free_name = name;
  for (int i = 2; std::find(drawn_.begin(), drawn_.end(), free_name) != drawn_.end(); ++i)
    free_name = fmt::format("{}-{}", name, i);
  if (report_figure_) report_figure_(free_name);
  const std::filesystem::path svg = out_ / "figures" / (free_name + ".svg");
  pictures::draw(plot, svg);
  pictures::draw(plot, out_ / "figures" / (free_name + ".png"));
  html.figure({.id = "figure-" + free_name,
               .svg = read_text(svg),
               .width_px = plot.width_px,
               .height_px = plot.height_px,
               .in_words = in_words,
               .caption = caption});
  drawn_.push_back(free_name);
}

void ReportPage::table(const ReportedTable& table) {
  HtmlTable cells{.caption = table.caption, .head = table.head, .rows = {}, .folded = table.caption};
  for (const std::vector<std::string>& row : table.rows) {
    cells.rows.emplace_back();
    for (const std::string& text : row) cells.rows.back().push_back({.text = text});
  }
  html.table(cells);
}

std::string name_part(std::string_view id) {
  std::string name;
  for (const char c : id) {
    const bool fits = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (fits)
      name += c;
    else if (!name.empty() && name.back() != '-')
      name += '-';
  }
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name.substr(0, 40);
}

HtmlCell number_cell(const std::string& text, const std::string& second_line) {
  return {.text = text, .tone = HtmlTone::number, .second_line = second_line};
}

HtmlCell number_cell(double value, int digits) {
  return number_cell(std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : std::string("-"));
}

HtmlCell figure_cell(const results::Figure& measured, double factor) {
  if (!std::isfinite(measured.value)) return number_cell("-");
  const std::string interval =
      measured.has_interval() ? fmt::format("{:.2f} to {:.2f}", factor * *measured.low, factor * *measured.high) : std::string();
  return number_cell(fmt::format("{:.2f}", factor * measured.value), interval);
}

HtmlCell figure_cell(const results::CensoredQuantile& quantile) {
  HtmlCell cell = figure_cell(quantile.ms);
  if (quantile.is_lower_bound) cell.text = "at least " + cell.text;
  return cell;
}

}  // namespace tactile::report
