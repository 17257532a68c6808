#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/splitting/activity_stretches.hpp"
#include "tactile/splitting/device_clock.hpp"
#include "tactile/splitting/split_source.hpp"
#include "tactile/splitting/touches.hpp"

namespace tactile::splitting {

/// A stretch in which the skin moves, and what it seems to be by its events alone.
struct SeenTouch {
  CameraTime begin{}, end{};
  BurstKind kind = BurstKind::press;
};

/// Where a long recording could be cut into runs. A plain value: `with_cuts` adjusts it, `split_recording` carries it out.
struct SplitProposal {
  std::int32_t event_stream = 0;
  CameraTime first{}, last{};         ///< of the events
  microseconds quiet_needed{};        ///< between two runs
  std::optional<double> quiet_per_s;  ///< [events/s] while nothing moves; nothing if it was not looked for, or is not known
  std::vector<SeenTouch> touches;     ///< by time; empty if they were not looked for
  bool looked_for_touches = false;    ///< else the cuts were given
  std::vector<CameraTime> cuts;       ///< ascending; a piece begins at each
  std::vector<std::uint64_t> events;  ///< of each piece: one more than there are cuts
  DeviceClockSearch robot, film;      ///< how robot log and film can be cut; both empty if there is none
};

/// A run that a proposal has, [begin, end).
struct ProposedRun {
  CameraTime begin{}, end{};                   ///< of the first run the first event, of the last one just after the last event
  std::uint64_t events = 0;                    ///< as the list of packets has it
  std::optional<microseconds> quiet_before{};  ///< without a touch around its start; nothing for the first run, or if not known
  std::vector<SeenTouch> touches;              ///< that begin in it
};

struct ProposeOptions {
  std::string stream{};           ///< of several event streams, by id or source
  microseconds quiet{2'000'000};  ///< a run ends after this long without a touch, unless an object is held, > 0
  LongActivityOptions activity{};
  std::size_t most_bins = 4'000'000;  ///< of the event rate: a long recording has longer bins, so that memory stays bounded
};

/// Proposes a cut in the middle of each quiet stretch of at least `options.quiet` in which no object is held (`grouped_runs`).
/// The quiet rate follows from the recording itself (`activity_in`). Slow bursts, which only a few places show, count too;
/// a burst that is too brief and small for a touch neither ends a quiet stretch nor makes a run, and no cut lies in one. Within
/// each run the bursts are classified, by the arm's lifts if the clock of the robot log is known, else by the motions that the
/// IMU felt (`felt_moves`).
///
/// Reads the recording up to seven times. Memory: 20 bytes per bin, and 50 KB per burst.
/// @throws Error  if the recording has no event or no sane sensor, or its events lie more than two days apart; if robot log or
///                labels cannot be read
SplitProposal propose_runs(const SplitSource& source, events::RecordingReader& recording, const ProposeOptions& options = {},
                           const ProgressCallback& progress = {});

/// A proposal with cuts that a person gives; no touch is looked for. Without a robot log, only packets with a cut inside are
/// read.
/// @param after_first  from the first event, ascending, > 0
/// @throws Error  as `with_cuts` and `propose_runs`
SplitProposal proposal_with(const SplitSource& source, events::RecordingReader& recording,
                            const std::vector<microseconds>& after_first, const ProposeOptions& options = {});

/// The same proposal with other cuts. @param recording  that of the proposal
/// @throws Error  if the cuts do not ascend, or a piece would have no event
SplitProposal with_cuts(SplitProposal proposal, events::RecordingReader& recording, std::vector<CameraTime> cuts);

std::vector<ProposedRun> runs_of(const SplitProposal& proposal);

/// The longest time without a touch inside a run, if touches were looked for: a `quiet` below it would cut there.
std::optional<microseconds> longest_quiet_within(const SplitProposal& proposal);

/// How many touches of a kind a run has.
std::size_t count_of(const ProposedRun& run, BurstKind kind);

/// "press", "slip", "release", "tap", "brief", "after".
std::string_view name_of(BurstKind kind);

nlohmann::json json_of(const SplitProposal& proposal);

}  // namespace tactile::splitting
