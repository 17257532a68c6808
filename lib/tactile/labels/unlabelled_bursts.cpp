#include "tactile/labels/unlabelled_bursts.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tactile/core/duration_units.hpp"

namespace tactile::labels {
namespace {

using alignment::Burst;

constexpr std::size_t most_named = 5;

/// Why a burst of this kind gets no label; null if it gets one.
const char* why_unlabelled(BurstKind kind) {
  switch (kind) {
    case BurstKind::tap:
      return "a sync tap";
    case BurstKind::brief:
      return "too short or small for a touch";
    case BurstKind::after:
      return "after the slip";
    case BurstKind::press:
    case BurstKind::slip:
    case BurstKind::release:
      break;
  }
  return nullptr;
}

/// The largest press of a run.
struct LargestPress {
  double events = 0;
  std::size_t bins = 0;
};

LargestPress largest_press(std::span<const Burst> bursts, std::span<const BurstKind> kinds) {
  LargestPress largest;
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    if (kinds[i] != BurstKind::press) continue;
    largest.events = std::max(largest.events, bursts[i].events);
    largest.bins = std::max(largest.bins, bursts[i].end - bursts[i].begin);
  }
  return largest;
}

/// The last time of the robot log; nothing if the clock of a piece is not known.
std::optional<CameraTime> logged_until(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks) {
  std::optional<CameraTime> until;
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    if (!clocks.pieces[i]) return std::nullopt;
    const CameraTime end = clocks.pieces[i]->relation.camera_from(signals.robot[i].log.states.back().t);
    until = std::max(until.value_or(CameraTime::min()), after(end, clocks.pieces[i]->uncertainty()));
  }
  return until;
}

}  // namespace

UnlabelledBursts unlabelled_bursts(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                   const ArmMoves& moves, std::span<const Burst> bursts, std::span<const BurstKind> kinds,
                                   const TouchesOptions& options) {
  const alignment::EventRate& rate = signals.rate;
  const auto seconds_of = [&](CameraTime t) { return 1e-3 * in_ms(between(rate.begin, t)); };
  const LargestPress press = largest_press(bursts, kinds);
  const std::optional<CameraTime> log_end = logged_until(signals, clocks);

  // A tip that springs back or touches once more is shorter, or smaller, than a press.
  const auto is_unexplained = [&](const Burst& burst, BurstKind kind) {
    const bool is_short = kind == BurstKind::after
                              ? between(rate.begin_of(burst.begin), rate.begin_of(burst.end)) < options.longest_recontact
                              : 2 * (burst.end - burst.begin) < press.bins;
    const bool is_faint = burst.slow || burst.events < 0.5 * press.events;
    return kind != BurstKind::tap && !is_faint && !is_short && lift_around(moves.lifts, rate, burst) == nullptr;
  };

  UnlabelledBursts found;
  std::vector<std::string> others;
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    const Burst& burst = bursts[i];
    const CameraTime begin = rate.begin_of(burst.begin), end = rate.begin_of(burst.end);
    if (kinds[i] != BurstKind::slip && log_end && begin > *log_end && !alignment::is_after_effect(burst, rate, bursts)) {
      found.doubts.push_back(
          doubt("burst-unlogged",
                "the robot log ends {:.2f} s before the burst of events at {:.2f} s: whether the arm rose then is not known",
                1e-3 * in_ms(between(*log_end, begin)), seconds_of(begin)));
    }
    const char* why = why_unlabelled(kinds[i]);
    if (why == nullptr) continue;
    if (is_unexplained(burst, kinds[i])) {
      found.doubts.push_back(doubt("burst-unexplained", "no label explains the burst of events from {:.2f} s to {:.2f} s",
                                   seconds_of(begin), seconds_of(end)));
    } else if (!burst.slow) {
      others.push_back(fmt::format("{:.2f} s to {:.2f} s ({})", seconds_of(begin), seconds_of(end), why));
    }
  }
  if (others.empty()) return found;
  // A person who sees a burst in the picture must know why it has no label.
  const std::size_t more = others.size() - std::min(most_named, others.size());
  others.resize(others.size() - more);
  found.remark = fmt::format("bursts of events without a label: {}{}", fmt::join(others, ", "),
                             more > 0 ? fmt::format(", and {} more", more) : "");
  return found;
}

}  // namespace tactile::labels
