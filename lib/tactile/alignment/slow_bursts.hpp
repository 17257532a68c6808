#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::alignment {

struct SlowBurstOptions {
  int cell_px = 8;                     ///< side of a cell; a rise is looked for in 3 x 3 cells
  microseconds slot{50'000};           ///< rises are compared over 2, 6 and 20 slots: 100, 300 and 1000 ms
  unsigned most_per_pixel = 3;         ///< events of a pixel that count in a slot: one that is stuck for a while is no rise
  double stands_out = 6.0;             ///< [standard deviations] above the noise of the cells, and 10 events
  double dispersion = 1.5;             ///< variance per mean of the noise in a few cells
  microseconds fades_within{150'000};  ///< this long after a burst its own decline is ignored
};

/// Rises that the rate of the whole image hides: a slow press moves few markers, for a long time, at a few events per
/// millisecond each. Looks at 3 x 3 cells over 100 ms, 300 ms and 1 s outside the known bursts. Noise is the mean of the same
/// cells in quiet time; if the event rate of the whole image is higher, as when the light drifts, that mean is raised with it.
///
/// Reads the recording twice. Memory is that of 20 slots of cells.
/// @param rate   of the same stream of this recording
/// @param known  bursts, by time
/// @return  by time, apart from each other and from the known ones
/// @throws Error  as reading events does
std::vector<Burst> slow_bursts(events::RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                               std::span<const Burst> known, const SlowBurstOptions& options = {});

}  // namespace tactile::alignment
