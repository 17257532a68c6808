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

std::string accuracy_csv(const std::vector<results::StudyHistory>& histories) {
  CsvTable table("th_ms,runs,object,value,low,high,n");
  for (const char* runs : {"choice", "reported", "all_test"}) {
    for (const results::StudyHistory& history : histories) {
      const std::optional<results::Accuracy>& accuracy = history.accuracy[runs];
      if (!accuracy) continue;
      const std::string th_ms = fmt::format("{}", history.history_ms);
      table.add_row(th_ms, runs, "all", cells(accuracy->mean));
      for (const auto& [object, figure] : accuracy->objects) table.add_row(th_ms, runs, object, cells(figure));
    }
  }
  return table.text();
}

std::string unseen_csv(const results::Study& study) {
  CsvTable table("split,runs,object,of,value,low,high,n");
  const auto add = [&](const std::string& split, const char* runs, const results::UnseenComparison& comparison) {
    for (const auto& [of, figure] :
         {std::pair("seen", &results::SeenAndHeldOut::seen), std::pair("held_out", &results::SeenAndHeldOut::held_out),
          std::pair("difference", &results::SeenAndHeldOut::difference)}) {
      table.add_row(split, runs, "all", of, cells(comparison.mean.*figure));
      for (const auto& [object, of_object] : comparison.objects) table.add_row(split, runs, object, of, cells(of_object.*figure));
    }
  };
  const auto add_all = [&](const std::string& split, const results::OnRunSets<results::UnseenComparison>& on) {
    if (on.reported) add(split, "reported", *on.reported);
    if (on.all_test) add(split, "all_test", *on.all_test);
  };
  if (study.unseen) add_all("paper", study.unseen->on);
  for (const results::StudySplit& split : study.splits) add_all(split.name, split.on);
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
