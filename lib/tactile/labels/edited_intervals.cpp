#include "tactile/labels/edited_intervals.hpp"

#include <algorithm>

namespace tactile::labels {
namespace {

/// Whether the label that was found is missing under the person's.
bool is_left(const TouchInterval& found, const TouchInterval& now) {
  return found.touch != now.touch || overlap(found, now) <= 0us;
}

std::vector<LabelFlag> moved_flags(std::vector<LabelFlag> old, std::span<const std::size_t> new_index,
                                   std::span<const LabelledInterval> intervals) {
  std::vector<LabelFlag> flags;
  for (LabelFlag& flag : old) {
    if (flag.interval_index) {
      const std::size_t index = new_index[*flag.interval_index];
      if (index == no_interval) continue;
      flag.interval_index = index;
      flag.confirmed = flag.confirmed || intervals[index].confirmed;
    }
    flags.push_back(std::move(flag));
  }
  return flags;
}

}  // namespace

Labels with_intervals(Labels labels, std::vector<LabelledInterval> intervals, std::span<const std::size_t> new_index) {
  name_intervals(intervals);
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    const TouchInterval found = labels.intervals[i].interval();
    if (new_index[i] == no_interval || is_left(found, intervals[new_index[i]].interval())) labels.rejected.push_back(found);
  }
  std::erase_if(labels.rejected, [&](const TouchInterval& one) {
    return std::any_of(intervals.begin(), intervals.end(), [&](const LabelledInterval& interval) {
      return interval.touch == one.touch && overlap(interval.interval(), one) > 0us;
    });
  });
  labels.flags = moved_flags(std::move(labels.flags), new_index, intervals);
  labels.intervals = std::move(intervals);
  return labels;
}

}  // namespace tactile::labels
