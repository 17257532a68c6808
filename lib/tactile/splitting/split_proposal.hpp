#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/splitting/device_clock.hpp"
#include "tactile/splitting/long_course.hpp"
#include "tactile/splitting/split_source.hpp"

namespace tactile::splitting {

enum class SeenKind : std::uint8_t { press, slip, release };
std::string_view name_of(SeenKind kind);  ///< "press" ...

/// A stretch in which something moves along the skin, and what it is more likely than anything else.
struct SeenTouch {
  CameraTime begin{}, end{};
  SeenKind kind = SeenKind::press;
};

/// Where a long recording could be cut into runs. A plain value: `with_cuts` adjusts it, `split_recording` carries it out.
struct SplitProposal {
  std::int32_t event_stream = 0;
  CameraTime first{}, last{};         ///< of the events
  microseconds quiet_needed{};        ///< between two runs
  std::optional<double> quiet_per_s;  ///< [events/s] while nothing moves; nothing if it was not looked for
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
  std::string stream{};  ///< of several event streams, by id or source
  LongCourseOptions course{};
};

/// Proposes a cut in each rest between two touches that ends a run (`ends_run`): half-way through the part of it in which nothing
/// moves the skin. So a run does not end in its hold, however long that is. What happens is inferred by the model of a run, in
/// bins of 8 ms (`long_course`).
/// @throws Error  if the recording has no event or no sane sensor, or its events lie more than two days apart; if robot log or
///                labels cannot be read
SplitProposal propose_runs(const SplitSource& source, events::RecordingReader& recording, const ProposeOptions& options = {},
                           const ProgressCallback& progress = {});

/// A proposal with cuts that a person gives; no touch is looked for. Only packets with a cut inside are read, unless the clock of
/// a robot log must be found.
/// @param after_first  from the first event, ascending, > 0
/// @throws Error  as `with_cuts` and `propose_runs`
SplitProposal proposal_with(const SplitSource& source, events::RecordingReader& recording,
                            const std::vector<microseconds>& after_first, const ProposeOptions& options = {},
                            const ProgressCallback& progress = {});

/// The same proposal with other cuts. @param recording  that of the proposal
/// @throws Error  if the cuts do not ascend, or a piece would have no event
SplitProposal with_cuts(SplitProposal proposal, events::RecordingReader& recording, std::vector<CameraTime> cuts);

std::vector<ProposedRun> runs_of(const SplitProposal& proposal);

/// The longest time without a touch inside a run, if touches were looked for: a `quiet` below it may cut there.
std::optional<microseconds> longest_quiet_within(const SplitProposal& proposal);

/// How many touches of a kind a run has.
std::size_t count_of(const ProposedRun& run, SeenKind kind);

nlohmann::json json_of(const SplitProposal& proposal);

}  // namespace tactile::splitting
