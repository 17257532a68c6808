#include "tactile/experiments/study/study_tables.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>

#include "tactile/core/csv_table.hpp"

namespace tactile::study {
namespace {

std::string cell(double number) { return std::isfinite(number) ? nlohmann::json(number).dump() : ""; }

std::array<std::string, 4> cells(const results::Figure& figure) {
  return {cell(figure.value), cell(figure.low.value_or(NAN)), cell(figure.high.value_or(NAN)), std::to_string(figure.n)};
}

}  // namespace

std::string accuracy_csv(const std::vector<AccuracyRow>& rows) {
  CsvTable table("th_ms,runs,object,value,low,high,n");
  for (const AccuracyRow& row : rows) {
    const std::string history = fmt::format("{}", row.history_ms);
    table.add_row(history, row.runs, "all", cells(row.accuracy->mean));
    for (const auto& [object, figure] : row.accuracy->objects) table.add_row(history, row.runs, object, cells(figure));
  }
  return table.text();
}

std::string unseen_csv(const std::vector<UnseenRow>& rows) {
  CsvTable table("split,runs,object,of,value,low,high,n");
  for (const UnseenRow& row : rows) {
    for (const auto& [of, figure] :
         {std::pair("seen", &results::SeenAndHeldOut::seen), std::pair("held_out", &results::SeenAndHeldOut::held_out),
          std::pair("difference", &results::SeenAndHeldOut::difference)}) {
      table.add_row(row.split, row.runs, "all", of, cells(row.comparison.mean.*figure));
      for (const auto& [object, of_object] : row.comparison.objects)
        table.add_row(row.split, row.runs, object, of, cells(of_object.*figure));
    }
  }
  return table.text();
}

std::string claims_csv(const std::vector<results::Claim>& claims) {
  CsvTable table("id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict");
  const auto add = [&](const results::Claim& claim, const char* runs, const results::ClaimOutcome& result) {
    table.add_row(claim.id, runs, cells(result.measured), claim.unit, name_of(claim.asked), fmt::format("{}", claim.limit),
                  result.kept, result.of, name_of(result.outcome));
  };
  for (const results::Claim& claim : claims) {
    add(claim, "reported", claim);
    if (claim.all_test) add(claim, "all_test", *claim.all_test);
  }
  return table.text();
}

}  // namespace tactile::study
