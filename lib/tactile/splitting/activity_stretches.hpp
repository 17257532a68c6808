#pragma once

#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/event_rate.hpp"

namespace tactile::splitting {

/// The bursts of a long recording, and what is quiet in it.
struct LongActivity {
  std::vector<alignment::Burst> bursts;  ///< by time, apart from each other
  std::vector<alignment::Burst> pauses;  ///< in which nothing was recorded, by time
  alignment::QuietRate quiet;            ///< the median over the parts
  bool has_quiet = false;                ///< else the recording is too short for a quiet rate
};

struct LongActivityOptions {
  alignment::ActivityOptions bursts{};
  microseconds part{60'000'000};    ///< the quiet rate is found for parts of this length: the light drifts over minutes
  microseconds margin{10'000'000};  ///< a part is looked at with so much of its neighbours
  microseconds silence{1'000'000};  ///< this long without any event, nothing was recorded: parts end there
};

/// As `bursts_in`, for hours: the quiet rate may drift, and the recording may pause. A stretch between two pauses that is too
/// short for a quiet rate of its own, or shows no burst against it, is a burst as a whole if it has 100 events or more: then the
/// sensor is silent unless something moves, and the stretch has no quiet rate.
LongActivity activity_in(const alignment::EventRate& rate, const LongActivityOptions& options = {});

}  // namespace tactile::splitting
