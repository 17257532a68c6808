#pragma once

#include "abort_unless.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::test {

/// Aborts if intervals overlap, or if a flag names an interval that does not exist.
inline void check(const labels::Labels& labels) {
  for (std::size_t i = 1; i < labels.intervals.size(); ++i)
    abort_unless(labels.intervals[i].start.at >= labels.intervals[i - 1].end.at);
  for (const labels::LabelFlag& flag : labels.flags)
    abort_unless(!flag.interval_index || *flag.interval_index < labels.intervals.size());
}

}  // namespace tactile::test
