#include <fmt/core.h>

#include "tactile/report/report_page.hpp"

namespace tactile::report {
namespace {

HtmlCell outcome_cell(const results::Claim& claim) {
  const HtmlTone tone = claim.outcome == results::Outcome::holds      ? HtmlTone::good
                        : claim.outcome == results::Outcome::does_not ? HtmlTone::bad
                                                                      : HtmlTone::open;
  return {.text = fmt::format("{} of {}", claim.written, claim.replicates),
          .tone = tone,
          .second_line = std::string(name_of(claim.outcome))};
}

/// "below 5 ms"
std::string limit_of(const results::Claim& claim) {
  return fmt::format("{} {:g} {}", claim.is_below ? "below" : "above", claim.limit, claim.unit);
}

}  // namespace

void add_claims(ReportPage& page, const ReportInput& input) {
  if (!input.claims.empty()) {
    page.html.section("claims", "The paper's sentences");
    HtmlTable table{.caption = "The paper's sentences, and in how many replicates of its study they would be written",
                    .head = {"paper", "written in", "because of", "measured"},
                    .rows = {},
                    .stacks = true};
    for (const results::Claim& claim : input.claims) {
      if (claim.replicates == 0) page.missing.push_back("The sentence was not tested: " + claim.paper);
      table.rows.push_back(
          {{.text = claim.paper, .second_line = "figure " + claim.figure},
           outcome_cell(claim),
           {.text = claim.measure, .second_line = (claim.is_by_margin ? "a margin: " : "written where it is ") + limit_of(claim)},
           {.text = text_of(claim.measured, " " + claim.unit, ".2f")}});
    }
    page.html.table(table);
    page.html.begin_folded("How a sentence is decided");
    page.html.paragraph(
        "The paper realised one study. A replicate is such a study: one training of each setting in one world. A sentence holds "
        "where more than half of all replicates would write it, with 95 % confidence, and does not where fewer would: by the "
        "one-sided bounds of Clopper and Pearson. That takes five replicates at least. \"Marginal\" and \"comparable\" are "
        "margins: "
        "the 95 % interval of the measure must lie within it. The measure is the mean over replicates.");
    page.html.end_folded();
  }
  for (const ReportedTable& left_out : input.left_out) page.table(left_out);
}

}  // namespace tactile::report
