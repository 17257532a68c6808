#pragma once

#include <optional>

#include "tactile/alignment/event_rate.hpp"
#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/alignment/quiet_rate.hpp"

namespace tactile::labels {

/// The first time at which a person who looks at the events sees a touch, as the paper labelled: from its onset on, the first
/// read-out from which 2 ms have more than twice the events of the quiet rate, and at least five. Nothing if there is none until
/// its end. The onset itself is earlier: the first motion makes few events.
/// @param onset  with its 95 % interval, from whose low end the search begins
/// Source: Faris et al., arXiv:2403.10120, section IV, labels by the number of events.
std::optional<CameraTime> visible_onset(const alignment::EventRate& rate, const alignment::QuietRate& quiet,
                                        const alignment::UncertainTime& onset, CameraTime end);

}  // namespace tactile::labels
