#pragma once

#include <string>
#include <vector>

#include "tactile/results/accuracy.hpp"
#include "tactile/results/claim.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::study {

/// Accuracies on one set of runs.
struct AccuracyRow {
  double history_ms = 0;
  std::string runs;  ///< "choice", "reported", "all_test"
  const results::Accuracy* accuracy = nullptr;
};

/// th_ms,runs,object,value,low,high,n; the mean over objects as object "all".
std::string accuracy_csv(const std::vector<AccuracyRow>& rows);

struct UnseenRow {
  std::string split, runs;
  results::UnseenComparison comparison;
};

/// split,runs,object,of,value,low,high,n
std::string unseen_csv(const std::vector<UnseenRow>& rows);

/// id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict
std::string claims_csv(const std::vector<results::Claim>& claims);

}  // namespace tactile::study
