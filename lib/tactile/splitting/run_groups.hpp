#pragma once

#include <cstdint>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/splitting/activity_stretches.hpp"
#include "tactile/splitting/device_clock.hpp"
#include "tactile/splitting/touches.hpp"

namespace tactile::splitting {

/// The bursts of one run, by time, and what each comes from.
struct RunGroup {
  std::vector<alignment::Burst> bursts;
  std::vector<BurstKind> kinds;  ///< of each burst
};

/// The bursts of a long recording, run by run.
struct RunGroups {
  std::vector<RunGroup> runs;
  std::vector<alignment::Burst> brief;  ///< in no run: too brief and small for a touch
};

/// Divides the bursts of a recording into runs, and classifies them.
///
/// - A run has ended where nothing moves for `quiet_bins`. A group of slow rises alone is no run: it joins the nearer one.
/// - While an object is held, a quiet stretch is the hold, however long: if the last touch before it is a press that neither
///   slipped nor was released, what follows belongs to the same run. Two cases end a run nevertheless. Nothing was recorded
///   meanwhile (`activity.pauses`, unless the sensor is silent when nothing moves): the press may have been released unseen. Or
///   what follows begins with a press: its first burst changes the picture as the standing press did, or as the start of a
///   neighbouring run that has its slip or release (a correlation of `Brightening` above `TouchesOptions::deepens`). Presses of
///   one sensor have correlations above 0.9, a press and a slip have some below 0.1.
///
/// Kinds follow from the arm's lifts if they are known, else from the motions that the IMU felt (`felt_moves`), else from the
/// order of the bursts.
///
/// @param all    of `rate`, by time, slow ones too
/// @param robot  the arm's motions, if they are known
/// @throws Error  as reading events does
RunGroups grouped_runs(events::RecordingReader& recording, std::int32_t stream, const alignment::EventRate& rate,
                       const std::vector<alignment::Burst>& all, const LongActivity& activity, std::size_t quiet_bins,
                       const DeviceClockSearch& robot);

}  // namespace tactile::splitting
