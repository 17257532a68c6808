#pragma once

#include <vector>

#include "tactile/alignment/anchor_search.hpp"

namespace tactile::alignment {

/// A change of an output that is taken for a command to the stage.
struct StageCommand {
  double at_s = 0;  ///< robot seconds, the middle of the two rows between which it changed
  bool closes = false;
};

std::vector<StageCommand> stage_commands(const AnchorSearch& search);

/// A start of activity in the skin.
struct ActivityStart {
  double at_s = 0;    ///< camera seconds
  double events = 0;  ///< of the burst
};

/// Of bursts, by time.
std::vector<ActivityStart> activity_starts(const AnchorInputs& inputs);

/// The first that lies in [from_s, to_s]; null if there is none.
const ActivityStart* start_within(const std::vector<ActivityStart>& starts, double from_s, double to_s);

constexpr double longest_travel_s = 1.0;  ///< of a stage, from its command to its contact

/// What the stage's commands did, where the clocks' shift is known to some hundredths of a second. The travel before a contact is
/// known to some tenths of a second only; after an opening the tips are free at once.
void add_stage_anchors(AnchorSearch& search, const std::vector<StageCommand>& commands, const std::vector<ActivityStart>& starts,
                       double shift_s);

/// The stage's commands alone against what the skin began to do: for runs whose arm rests, or whose motion leaves a choice. An
/// ambiguous match is refused.
/// @param possible_s  shifts that the arm's motion allows, within half of the longest travel; empty: any
void match_stage(AnchorSearch& search, const std::vector<StageCommand>& commands, const std::vector<ActivityStart>& starts,
                 const std::vector<double>& possible_s = {});

}  // namespace tactile::alignment
