#include "tactile/labels/arm_moves.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tactile::labels {
namespace {

/// Splits bursts that continue into a lift where the lift begins: an object that is lifted as soon as it is pressed, or tips that
/// spring back just before, leave no quiet between the two.
std::vector<alignment::Burst> split_at_lifts(const alignment::EventRate& rate, const alignment::QuietRate& quiet,
                                             std::vector<alignment::Burst> bursts, const std::vector<ArmMove>& lifts,
                                             const alignment::ActivityOptions& options) {
  constexpr microseconds well_before = 60ms;
  for (const ArmMove& lift : lifts) {
    if (lift.uncertainty > well_placed) continue;
    const CameraTime split_at = before(lift.start, lift.uncertainty);
    const auto split = std::find_if(bursts.begin(), bursts.end(), [&](const alignment::Burst& burst) {
      return rate.begin_of(burst.begin) < before(split_at, well_before) && rate.begin_of(burst.end) > lift.start;
    });
    if (split == bursts.end()) continue;
    const auto place = static_cast<std::size_t>(between(rate.begin, split_at) / rate.bin);
    alignment::EventRate before_split = rate;
    before_split.counts.resize(place);
    std::vector<alignment::Burst> pieces = alignment::bursts_in(before_split, quiet, options);
    std::erase_if(pieces, [&](const alignment::Burst& piece) { return piece.end <= split->begin; });
    alignment::Burst rest = *split;
    rest.begin = place;
    rest.events = alignment::events_above(rate, quiet, rest.begin, rest.end);
    pieces.push_back(rest);
    bursts.insert(bursts.erase(split), pieces.begin(), pieces.end());
  }
  return bursts;
}

/// Joins bursts that begin within a lift: an object may stick for longer than the pause between two bursts.
std::vector<alignment::Burst> join_in_lifts(const alignment::EventRate& rate, const alignment::QuietRate& quiet,
                                            std::vector<alignment::Burst> bursts, const std::vector<ArmMove>& lifts) {
  for (const ArmMove& lift : lifts) {
    // Where the clock is not known well, only the middle of the lift is sure: there, a pause ends no slip.
    const bool is_placed = lift.uncertainty <= well_placed;
    const CameraTime from = is_placed ? before(lift.start, lift.uncertainty) : after(lift.start, lift.uncertainty);
    const CameraTime until = is_placed ? lift.end : before(lift.end, lift.uncertainty);
    const auto begins_within = [&](const alignment::Burst& burst) {
      const CameraTime begin = rate.begin_of(burst.begin);
      return begin >= from && begin < until;
    };
    auto first = std::find_if(bursts.begin(), bursts.end(), begins_within);
    if (first == bursts.end()) continue;
    const auto after_last = std::find_if_not(first, bursts.end(), begins_within);
    if (!is_placed && first != bursts.begin() && rate.begin_of(std::prev(first)->end) >= from) --first;
    first->end = std::prev(after_last)->end;
    first->events = alignment::events_above(rate, quiet, first->begin, first->end);
    bursts.erase(std::next(first), after_last);
  }
  return bursts;
}

}  // namespace

ArmMoves arm_moves(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks) {
  ArmMoves moves;
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    moves.logged += signals.robot[i].log.states.back().t - signals.robot[i].log.states.front().t;
    for (const alignment::MotionPhase& phase : signals.robot[i].phases) {
      if (phase.kind != alignment::MotionKind::lift && phase.kind != alignment::MotionKind::tap) continue;
      const bool is_lift = phase.kind == alignment::MotionKind::lift;
      moves.rises = moves.rises || is_lift;
      if (is_lift && phase.profile) moves.rings = moves.rings.value_or(false) || phase.profile->rings();
      if (!clocks.pieces[i]) {
        moves.all_placed = moves.all_placed && !is_lift;
        continue;
      }
      const alignment::FittedClock& clock = *clocks.pieces[i];
      (is_lift ? moves.lifts : moves.taps)
          .push_back({clock.relation.camera_from(phase.start), clock.relation.camera_from(phase.end), clock.uncertainty()});
    }
  }
  return moves;
}

std::vector<alignment::Burst> bursts_by_lift(const alignment::RunSignals& signals, const std::vector<ArmMove>& lifts,
                                             const alignment::ActivityOptions& options) {
  std::vector<alignment::Burst> bursts = split_at_lifts(signals.rate, signals.quiet, signals.bursts, lifts, options);
  return join_in_lifts(signals.rate, signals.quiet, std::move(bursts), lifts);
}

}  // namespace tactile::labels
