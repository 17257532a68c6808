#include <fmt/core.h>

#include <cmath>
#include <initializer_list>
#include <set>

#include "tactile/report/report_page.hpp"

namespace tactile::report {
namespace {

std::string with_unit(const results::Figure& measured, const std::string& unit) {
  if (!std::isfinite(measured.value)) return "not measured";
  const auto digits = [](double value) { return value == std::round(value) ? 0 : 2; };  // counts, and delays of whole ticks
  const bool is_one = measured.value == 1 && unit.ends_with('s') && unit != "ms";
  std::string text =
      fmt::format("{:.{}f} {}", measured.value, digits(measured.value), is_one ? unit.substr(0, unit.size() - 1) : unit);
  const auto bound = [&](std::optional<double> value) {
    return value ? fmt::format("{:.{}f}", *value, digits(*value)) : std::string("unknown");
  };
  if (measured.low || measured.high) text += fmt::format(" ({} to {})", bound(measured.low), bound(measured.high));
  return text;
}

HtmlCell outcome_cell(const results::ClaimOutcome& result, const std::string& second_line) {
  const results::Outcome outcome = result.outcome;
  const HtmlTone tone = outcome == results::Outcome::holds      ? HtmlTone::good
                        : outcome == results::Outcome::does_not ? HtmlTone::bad
                                                                : HtmlTone::open;
  return {.text = std::string(name_of(outcome)), .tone = tone, .second_line = second_line};
}

std::string joined(std::initializer_list<std::string> sentences) {
  std::string text;
  for (const std::string& sentence : sentences) {
    if (!sentence.empty()) text += (text.empty() ? "" : text.ends_with('.') ? " " : ". ") + sentence;
  }
  return text;
}

/// "above 95 %"
std::string limit_of(const results::Claim& claim) {
  return fmt::format("{} {:g} {}", name_of(claim.asked), claim.limit, claim.unit);
}

std::vector<HtmlCell> row_of(const results::Claim& claim) {
  std::string measured = with_unit(claim.measured, claim.unit);
  if (std::isfinite(claim.limit)) measured += "; claimed: " + limit_of(claim);
  const bool has_words = !claim.in_words.empty();
  std::vector<HtmlCell> row{
      {.text = claim.claim},
      outcome_cell(claim, claim.why),
      {.text = claim.paper},
      {.text = has_words ? claim.in_words : measured, .second_line = joined({has_words ? measured : std::string(), claim.note})}};
  if (claim.all_test) {
    const results::ClaimOutcome& all = *claim.all_test;
    row.push_back(outcome_cell(all, joined({all.why, all.in_words, with_unit(all.measured, claim.unit), all.note})));
  } else {
    row.push_back({.text = "-"});
  }
  return row;
}

/// Objects by the claims that are about each of them.
HtmlTable objects_table(const std::vector<results::Claim>& claims) {
  HtmlTable table{.caption =
                      "By object, on the reported runs: ✓ where the object's value meets the claim; below each value its "
                      "95 % interval, if there is one, and its number of runs",
                  .head = {"object"},
                  .rows = {},
                  .folded = "The claims about every object, by object"};
  std::vector<const results::Claim*> about_objects;
  std::set<std::string> names;
  for (const results::Claim& claim : claims) {
    if (claim.objects.empty()) continue;
    about_objects.push_back(&claim);
    table.head.push_back(claim.id + ": " + limit_of(claim));
    for (const auto& [object, value] : claim.objects) names.insert(object);
  }
  for (const std::string& name : names) {
    std::vector<HtmlCell> row{{.text = name}};
    for (const results::Claim* claim : about_objects) {
      const auto found = claim->objects.find(name);
      if (found == claim->objects.end()) {
        row.push_back(number_cell(""));
        continue;
      }
      const results::Figure& value = found->second;
      const bool is_met = claim->asked == results::Asked::below ? value.value < claim->limit : value.value > claim->limit;
      HtmlCell cell = figure_cell(value);
      if (is_met) cell.text = "✓ " + cell.text;
      const std::string runs = fmt::format("{} run{}", value.n, value.n == 1 ? "" : "s");
      cell.second_line = cell.second_line.empty() ? runs : cell.second_line + ", " + runs;
      row.push_back(std::move(cell));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

void add_claims(ReportPage& page, const ReportInput& input) {
  if (input.claims.empty()) return;
  page.html.section("claims", "The paper's claims");
  HtmlTable table{.caption = "The paper's claims, one by one",
                  .head = {"claim", "outcome", "paper", "measured", "by the paper's method"},
                  .rows = {},
                  .stacks = true};
  for (const results::Claim& claim : input.claims) {
    if (!std::isfinite(claim.measured.value)) page.missing.push_back("The claim was not measured: " + claim.claim + ".");
    table.rows.push_back(row_of(claim));
  }
  page.html.table(table);
  page.html.begin_folded("How a claim is decided");
  page.html.paragraph(
      "A claim holds where its whole interval lies on the claimed side of the limit. It does not hold where the whole interval "
      "lies on the other side. Otherwise the claim cannot be decided, and the table gives the reason. A claim about every object "
      "needs three runs of each object. It does not hold once one object lies beyond the limit, by an interval that is widened "
      "for the number of objects, or once the mean over these objects does. A claim over objects needs five objects. Claims are "
      "measured on the reported runs, which no setting was chosen on. The last column has the paper's method: all test runs.");
  page.html.end_folded();
  page.html.table(objects_table(input.claims));
  for (const ReportedTable& left_out : input.left_out) page.table(left_out);
}

}  // namespace tactile::report
