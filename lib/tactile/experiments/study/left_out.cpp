#include "tactile/experiments/study/left_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/windows/without_samples.hpp"

namespace tactile::study {
namespace {

std::string flags_on(const labels::Labels& labels, std::size_t interval) {
  std::vector<std::string> reasons;
  for (const labels::LabelFlag& flag : labels.flags) {
    if (!flag.confirmed && flag.interval_index == interval) reasons.push_back(flag.reason);
  }
  return fmt::format("flagged: {}", fmt::join(reasons, "; "));
}

}  // namespace

std::vector<results::LeftOut> left_out_of(const windows::Dataset& dataset, std::span<const RunFolder> runs) {
  const bool takes_flagged = member<bool>(dataset.settings(), "include_flagged", dataset.file().string());
  std::vector<results::LeftOut> left_out;
  for (const RunFolder& run : runs) {
    labels::Labels labels;
    try {
      if (is_there(run.labels())) labels = labels::read_labels(run.labels());
    } catch (const std::exception& e) {
      left_out.push_back({run.name(), "run", sentence_of(e)});
      continue;
    }
    const std::optional<windows::NoSamples> reason = windows::why_no_samples(dataset, run);
    const bool is_in_dataset = std::any_of(dataset.runs().begin(), dataset.runs().end(), [&](const windows::DatasetRun& one) {
      return one.object == run.object && one.run == run.run;
    });
    if (reason && (is_in_dataset || !reason->flagged)) {
      left_out.push_back({run.name(), "run", "no samples: " + reason->words});
    } else if (reason) {
      left_out.push_back({run.name(), "run", "flagged: " + reason->flags});
    }
    if (!is_in_dataset || takes_flagged) continue;
    for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
      if (labels.interval_is_flagged(i)) left_out.push_back({run.name(), labels.intervals[i].id, flags_on(labels, i)});
    }
  }
  return left_out;
}

}  // namespace tactile::study
