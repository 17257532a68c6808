#pragma once

#include <string>
#include <vector>

#include "tactile/results/study.hpp"

namespace tactile::study {

/// th_ms,runs,object,value,low,high,n; the mean over objects as object "all".
std::string accuracy_csv(const std::vector<results::StudyHistory>& histories);

/// split,runs,object,of,value,low,high,n; the plan's own held-out objects as split "paper".
std::string unseen_csv(const results::Study& study);

/// id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict
std::string claims_csv(const std::vector<results::Claim>& claims);

}  // namespace tactile::study
