#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/split.hpp"

namespace tactile::model {

/// The deviations of a split from the requested one, a sentence each, by object.
struct SplitRemarks {
  std::vector<std::string> substitutes;  ///< "mug: trained on run 02 in place of 01, whose slip-1 is flagged"
  std::vector<std::string> left_out;     ///< "jar: left out, none of its runs has samples: slip-1 is flagged in jar/01, jar/02"
  std::vector<std::string> untested;     ///< "mug: not tested, none of its runs but 02 has samples"
  std::optional<RunFolder> flagged;      ///< a run whose flags are a reason
};

/// The reasons come from the labels of the runs, if they exist.
SplitRemarks remarks_on(const windows::Dataset& dataset, const windows::SplitOptions& options, const windows::Split& split);

/// Objects with samples in `runs` but not in `others`, by name.
std::vector<std::string> objects_only_in(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                                         std::span<const std::uint32_t> others);

}  // namespace tactile::model
