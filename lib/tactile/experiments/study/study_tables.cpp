#include "tactile/experiments/study/study_tables.hpp"

#include <fmt/core.h>

#include <cmath>

namespace tactile::study {
namespace {

std::string cell(double number) { return std::isfinite(number) ? nlohmann::json(number).dump() : ""; }

std::string cells(const results::Figure& figure) {
  return fmt::format("{},{},{},{}", cell(figure.value), cell(figure.low.value_or(NAN)), cell(figure.high.value_or(NAN)),
                     figure.n);
}

}  // namespace

std::string accuracy_csv(const std::vector<AccuracyRow>& rows) {
  std::string text = "th_ms,runs,object,value,low,high,n\n";
  for (const AccuracyRow& row : rows) {
    text += fmt::format("{},{},all,{}\n", row.history_ms, row.runs, cells(row.accuracy->mean));
    for (const auto& [object, figure] : row.accuracy->objects)
      text += fmt::format("{},{},{},{}\n", row.history_ms, row.runs, object, cells(figure));
  }
  return text;
}

std::string unseen_csv(const std::vector<UnseenRow>& rows) {
  std::string text = "split,runs,object,of,value,low,high,n\n";
  for (const UnseenRow& row : rows) {
    for (const auto& [of, figure] :
         {std::pair("seen", &results::SeenAndHeldOut::seen), std::pair("held_out", &results::SeenAndHeldOut::held_out),
          std::pair("difference", &results::SeenAndHeldOut::difference)}) {
      text += fmt::format("{},{},all,{},{}\n", row.split, row.runs, of, cells(row.comparison.mean.*figure));
      for (const auto& [object, of_object] : row.comparison.objects)
        text += fmt::format("{},{},{},{},{}\n", row.split, row.runs, object, of, cells(of_object.*figure));
    }
  }
  return text;
}

std::string claims_csv(const std::vector<results::Claim>& claims) {
  std::string text = "id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict\n";
  const auto add = [&](const results::Claim& claim, const char* runs, const results::ClaimOutcome& outcome) {
    const auto count = [](const std::optional<std::size_t>& objects) {
      return objects ? std::to_string(*objects) : std::string();
    };
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", claim.id, runs, cells(outcome.measured), claim.unit, name_of(claim.asked),
                        claim.limit, count(outcome.kept), count(outcome.of), name_of(outcome.verdict));
  };
  for (const results::Claim& claim : claims) {
    add(claim, "reported", claim);
    if (claim.all_test) add(claim, "all_test", *claim.all_test);
  }
  return text;
}

}  // namespace tactile::study
