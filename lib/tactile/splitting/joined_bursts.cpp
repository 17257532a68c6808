#include "tactile/splitting/joined_bursts.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "tactile/alignment/slow_bursts.hpp"

namespace tactile::splitting {
namespace {

constexpr microseconds well_placed = 30ms;  // a lift whose clock is known so well joins all bursts that begin in it

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

/// The burst that a slow rise is the start of: it follows at once, and a lift that it lies in began before the rise.
alignment::Burst* goes_on_in(const alignment::Burst& slow, std::vector<alignment::Burst>& bursts,
                             const alignment::EventRate& rate, const std::vector<ArmMove>& lifts) {
  const auto soon = static_cast<std::size_t>(alignment::SlowBurstOptions{}.slot / rate.bin);
  const auto next = std::find_if(bursts.begin(), bursts.end(), [&](const alignment::Burst& burst) {
    return !burst.slow && burst.begin >= slow.end && burst.begin <= slow.end + soon;
  });
  if (next == bursts.end()) return nullptr;
  const ArmMove* lift = move_around(lifts, rate, *next);
  return lift == nullptr || rate.begin_of(slow.begin) >= before(lift->start, lift->uncertainty) ? &*next : nullptr;
}

/// Adds a slow burst. What stands out in its midst belongs to it.
void add_slow(alignment::Burst slow, std::vector<alignment::Burst>& bursts, const alignment::EventRate& rate,
              const alignment::QuietRate& quiet, const std::vector<ArmMove>& lifts) {
  std::erase_if(bursts, [&](const alignment::Burst& burst) {
    const bool overlap = burst.begin < slow.end && slow.begin < burst.end;
    if (overlap) slow.begin = std::min(slow.begin, burst.begin);
    if (overlap) slow.end = std::max(slow.end, burst.end);
    return overlap;
  });
  slow.events = alignment::events_above(rate, quiet, slow.begin, slow.end);
  if (alignment::Burst* next = goes_on_in(slow, bursts, rate, lifts)) {
    next->begin = slow.begin;
    next->events += slow.events;
  } else {
    bursts.push_back(slow);
  }
}

}  // namespace

std::vector<alignment::Burst> joined_and_slow_bursts(events::RecordingReader& recording, std::int32_t stream_id,
                                                     const alignment::EventRate& rate, const alignment::QuietRate& quiet,
                                                     std::vector<alignment::Burst> bursts, const std::vector<ArmMove>& lifts,
                                                     std::span<const alignment::Burst> pauses) {
  bursts = join_in_lifts(rate, quiet, std::move(bursts), lifts);
  std::vector<alignment::Burst> known = alignment::without_after_effects(bursts, rate);
  known.insert(known.begin(), pauses.begin(), pauses.end());
  for (const alignment::Burst& slow : alignment::slow_bursts(recording, stream_id, rate, known))
    add_slow(slow, bursts, rate, quiet, lifts);
  std::sort(bursts.begin(), bursts.end(), [](const alignment::Burst& a, const alignment::Burst& b) { return a.begin < b.begin; });
  return bursts;
}

}  // namespace tactile::splitting
