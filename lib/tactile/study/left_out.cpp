#include "tactile/study/left_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>

#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile {
namespace {

std::string flags_of(const Labels& labels, std::optional<std::size_t> interval) {
  std::vector<std::string> reasons;
  for (const LabelFlag& flag : labels.flags) {
    if (!flag.confirmed && flag.interval_index == interval) reasons.push_back(flag.reason);
  }
  return fmt::format("flagged: {}", fmt::join(reasons, "; "));
}

/// Why a run with labels is in no dataset.
std::string reason_against(const Labels& labels) {
  return labels.run_is_flagged() ? flags_of(labels, std::nullopt) : std::string("'tactile windows' did not take it; it says why");
}

/// The classes that no interval in use has; of a run that has both, none.
std::string what_it_lacks(const Dataset& dataset, std::size_t run) {
  for (const Touch touch : {Touch::press, Touch::slip}) {
    const auto intervals = dataset.intervals();
    const bool has_one = std::any_of(intervals.begin(), intervals.end(), [&](const DatasetInterval& one) {
      return one.run_index == run && one.interval.touch == touch;
    });
    if (!has_one) return std::string(name_of(touch));
  }
  return "ticks of a class";
}

}  // namespace

void to_json(nlohmann::json& json, const LeftOut& left_out) {
  json = {{"run", left_out.run}, {"what", left_out.what}, {"reason", left_out.reason}};
}

std::vector<LeftOut> left_out_of(const Dataset& dataset, std::span<const RunFolder> runs) {
  const bool takes_flagged = member<bool>(dataset.settings(), "include_flagged", dataset.file().string());
  std::vector<LeftOut> left_out;
  for (const RunFolder& folder : runs) {
    const std::string name = folder.name();
    if (!is_there(folder.labels())) {
      left_out.push_back({name, "run", "it has no labels"});
      continue;
    }
    Labels labels;
    try {
      labels = read_labels(folder.labels());
    } catch (const std::exception& e) {
      left_out.push_back({name, "run", sentence_of(e)});
      continue;
    }
    const auto found = std::find_if(dataset.runs().begin(), dataset.runs().end(),
                                    [&](const DatasetRun& run) { return run.object == folder.object && run.run == folder.run; });
    if (found == dataset.runs().end()) {
      left_out.push_back({name, "run", reason_against(labels)});
      continue;
    }
    const auto index = static_cast<std::size_t>(std::distance(dataset.runs().begin(), found));
    const auto samples = dataset.samples();
    if (std::none_of(samples.begin(), samples.end(), [&](const Sample& sample) { return sample.run_index == index; }))
      left_out.push_back({name, "run", fmt::format("no samples: it lacks {}", what_it_lacks(dataset, index))});
    for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
      if (!takes_flagged && labels.interval_is_flagged(i))
        left_out.push_back({name, labels.intervals[i].id, flags_of(labels, i)});
    }
  }
  return left_out;
}

}  // namespace tactile
