#include "tactile/labels/touches.hpp"

#include <algorithm>

namespace tactile::labels {
namespace {

/// How long the burst and the move overlap, with the uncertainty of the clock.
microseconds common_time(const alignment::EventRate& rate, const alignment::Burst& burst, const ArmMove& move) {
  const CameraTime begin = std::max(rate.begin_of(burst.begin), before(move.start, move.uncertainty));
  const CameraTime end = std::min(rate.begin_of(burst.end), after(move.end, move.uncertainty));
  return begin < end ? between(begin, end) : 0us;
}

/// The burst that has the most events in the lift; nothing if none reaches into it.
/// @param slow  of the slow bursts; else of the others
std::optional<std::size_t> slip_of(const alignment::EventRate& rate, std::span<const alignment::Burst> bursts,
                                   const ArmMove& lift, bool slow) {
  std::optional<std::size_t> best;
  double most = 0;
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    if (bursts[i].slow != slow) continue;
    const auto length = static_cast<double>((rate.bin * static_cast<std::int64_t>(bursts[i].end - bursts[i].begin)).count());
    const double events = bursts[i].events * static_cast<double>(common_time(rate, bursts[i], lift).count()) / length;
    if (events > most) {
      most = events;
      best = i;
    }
  }
  return best;
}

}  // namespace

std::vector<BurstKind> kinds_of(const alignment::EventRate& rate, std::span<const alignment::Burst> bursts,
                                const std::optional<std::vector<ArmMove>>& lifts, std::span<const ArmMove> taps,
                                std::span<const double> undoes, const TouchesOptions& options) {
  std::vector<BurstKind> kinds(bursts.size(), BurstKind::press);
  std::optional<std::size_t> last_slip;
  const auto is_slip = [&](std::size_t i) {
    kinds[i] = BurstKind::slip;
    last_slip = std::max(last_slip.value_or(0), i);
  };
  if (lifts) {
    for (const ArmMove& lift : *lifts) {
      if (const auto slip = slip_of(rate, bursts, lift, false)) is_slip(*slip);
    }
  } else {
    // By order alone: the last burst that is no after-effect and no release, if there is another before it.
    std::vector<std::size_t> large;
    for (std::size_t i = 0; i < bursts.size(); ++i) {
      const bool reverses = i > 0 && undoes[i] > options.releases;
      if (!bursts[i].slow && !reverses && !alignment::is_after_effect(bursts[i], rate, bursts)) large.push_back(i);
    }
    if (large.size() > 1) is_slip(large.back());
  }

  const auto is_shorter = [&](std::size_t i, microseconds than) {
    return rate.bin * static_cast<std::int64_t>(bursts[i].end - bursts[i].begin) < than;
  };
  const auto is_short = [&](std::size_t i) { return is_shorter(i, options.shortest_press); };
  std::optional<std::size_t> standing_press;
  // A fast stage needs less time than `shortest_press`, but moves as many markers as before.
  const auto is_like_a_press = [&](std::size_t i, std::size_t times_shorter) {
    const alignment::Burst &burst = bursts[i], &press = bursts[*standing_press];
    return burst.events >= options.like_a_press * press.events &&
           times_shorter * (burst.end - burst.begin) > press.end - press.begin;
  };
  const auto releases = [&](std::size_t i) {
    return standing_press && undoes[i] > options.releases && (!is_short(i) || is_like_a_press(i, 2)) &&
           !alignment::is_after_effect(bursts[i], rate, bursts);
  };
  // Tips that spring back or creep while they are pressed, or move so faintly that no stage moves them; no deeper press.
  const auto is_brief = [&](std::size_t i) {
    const alignment::Burst& burst = bursts[i];
    if (alignment::is_after_effect(burst, rate, bursts)) return true;
    if (standing_press && undoes[i] < -options.deepens && !burst.slow && is_like_a_press(i, 3)) return false;
    if (burst.slow && is_shorter(i, options.shortest_slow_press)) return true;
    return standing_press && (is_short(i) || burst.slow) && burst.events < bursts[*standing_press].events;
  };
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    if (kinds[i] == BurstKind::slip) continue;
    if (std::any_of(taps.begin(), taps.end(), [&](const ArmMove& tap) { return common_time(rate, bursts[i], tap) > 0us; })) {
      kinds[i] = BurstKind::tap;
    } else if (last_slip && i > *last_slip) {
      const bool reverses = undoes[i] > options.releases && !alignment::is_after_effect(bursts[i], rate, bursts);
      kinds[i] = reverses ? BurstKind::release : BurstKind::after;
    } else if (releases(i)) {
      kinds[i] = BurstKind::release;
      standing_press.reset();
    } else if (is_brief(i)) {
      kinds[i] = BurstKind::brief;
    } else {
      standing_press = i;
    }
  }
  for (const ArmMove& lift : lifts.value_or(std::vector<ArmMove>())) {
    // A held object may slip so smoothly that only a few places show it.
    const auto slow = slip_of(rate, bursts, lift, true);
    if (slip_of(rate, bursts, lift, false) || !slow) continue;
    const auto is_hold = [](BurstKind kind) { return kind == BurstKind::press || kind == BurstKind::release; };
    std::size_t i = *slow;
    while (i > 0 && !is_hold(kinds[i - 1])) --i;
    if (i > 0 && kinds[i - 1] == BurstKind::press) kinds[*slow] = BurstKind::slip;
  }
  return kinds;
}

}  // namespace tactile::labels
