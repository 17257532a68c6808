#include "tactile/splitting/touches.hpp"

#include <algorithm>

namespace tactile::splitting {
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

/// The kinds of a run's bursts, found step by step.
class Classifier {
 public:
  Classifier(const alignment::EventRate& rate, std::span<const alignment::Burst> bursts, std::span<const double> undoes,
             const TouchesOptions& options)
      : rate_(rate), bursts_(bursts), undoes_(undoes), options_(options), kinds_(bursts.size(), BurstKind::press) {}

  void find_slips(std::span<const ArmMove> lifts) {
    for (const ArmMove& lift : lifts) {
      if (const auto slip = slip_of(rate_, bursts_, lift, false)) set_slip(*slip);
    }
  }

  /// By order alone: the last burst that is no after-effect and no release, if there is another before it.
  void find_last_slip() {
    std::vector<std::size_t> large;
    for (std::size_t i = 0; i < bursts_.size(); ++i) {
      if (!bursts_[i].slow && !is_after_effect(i) && (i == 0 || !reverses(i))) large.push_back(i);
    }
    if (large.size() > 1) set_slip(large.back());
  }

  void find_others(std::span<const ArmMove> taps) {
    for (std::size_t i = 0; i < bursts_.size(); ++i) {
      if (kinds_[i] != BurstKind::slip) kinds_[i] = kind_of(i, taps);
    }
  }

  /// A held object may slip so smoothly that only a few places show it.
  void find_slow_slips(std::span<const ArmMove> lifts) {
    const auto is_hold = [](BurstKind kind) { return kind == BurstKind::press || kind == BurstKind::release; };
    for (const ArmMove& lift : lifts) {
      const auto slow = slip_of(rate_, bursts_, lift, true);
      if (slip_of(rate_, bursts_, lift, false) || !slow) continue;
      std::size_t i = *slow;
      while (i > 0 && !is_hold(kinds_[i - 1])) --i;
      if (i > 0 && kinds_[i - 1] == BurstKind::press) kinds_[*slow] = BurstKind::slip;
    }
  }

  const std::vector<BurstKind>& kinds() const { return kinds_; }

 private:
  void set_slip(std::size_t i) {
    kinds_[i] = BurstKind::slip;
    last_slip_ = std::max(last_slip_.value_or(0), i);
  }

  BurstKind kind_of(std::size_t i, std::span<const ArmMove> taps) {
    if (std::any_of(taps.begin(), taps.end(), [&](const ArmMove& tap) { return common_time(rate_, bursts_[i], tap) > 0us; }))
      return BurstKind::tap;
    if (last_slip_ && i > *last_slip_) return reverses(i) && !is_after_effect(i) ? BurstKind::release : BurstKind::after;
    if (releases(i)) {
      standing_press_.reset();
      return BurstKind::release;
    }
    if (is_brief(i)) return BurstKind::brief;
    standing_press_ = i;
    return BurstKind::press;
  }

  bool is_after_effect(std::size_t i) const { return alignment::is_after_effect(bursts_[i], rate_, bursts_); }
  bool reverses(std::size_t i) const { return undoes_[i] > options_.releases; }
  bool is_shorter(std::size_t i, microseconds than) const {
    return rate_.bin * static_cast<std::int64_t>(bursts_[i].end - bursts_[i].begin) < than;
  }
  bool is_short(std::size_t i) const { return is_shorter(i, options_.shortest_press); }

  /// A fast stage needs less time than `shortest_press`, but moves as many markers as before.
  bool is_like_a_press(std::size_t i, std::size_t times_shorter) const {
    const alignment::Burst &burst = bursts_[i], &press = bursts_[*standing_press_];
    return burst.events >= options_.like_a_press * press.events &&
           times_shorter * (burst.end - burst.begin) > press.end - press.begin;
  }

  bool releases(std::size_t i) const {
    return standing_press_ && reverses(i) && (!is_short(i) || is_like_a_press(i, 2)) && !is_after_effect(i);
  }

  /// Tips that spring back or creep while they are pressed, or move so faintly that no stage moves them; no deeper press.
  bool is_brief(std::size_t i) const {
    const alignment::Burst& burst = bursts_[i];
    if (is_after_effect(i)) return true;
    if (standing_press_ && undoes_[i] < -options_.deepens && !burst.slow && is_like_a_press(i, 3)) return false;
    if (burst.slow && is_shorter(i, options_.shortest_slow_press)) return true;
    return standing_press_ && (is_short(i) || burst.slow) && burst.events < bursts_[*standing_press_].events;
  }

  const alignment::EventRate& rate_;
  std::span<const alignment::Burst> bursts_;
  std::span<const double> undoes_;
  const TouchesOptions& options_;
  std::vector<BurstKind> kinds_;
  std::optional<std::size_t> last_slip_, standing_press_;
};

}  // namespace

const ArmMove* move_around(const std::vector<ArmMove>& moves, const alignment::EventRate& rate, const alignment::Burst& burst) {
  const auto overlaps = [&](const ArmMove& move) {
    return rate.begin_of(burst.begin) < after(move.end, move.uncertainty) &&
           rate.begin_of(burst.end) > before(move.start, move.uncertainty);
  };
  const auto move = std::find_if(moves.begin(), moves.end(), overlaps);
  return move == moves.end() ? nullptr : &*move;
}

std::vector<BurstKind> kinds_of(const alignment::EventRate& rate, std::span<const alignment::Burst> bursts,
                                const std::optional<std::vector<ArmMove>>& lifts, std::span<const ArmMove> taps,
                                std::span<const double> undoes, const TouchesOptions& options) {
  Classifier classifier(rate, bursts, undoes, options);
  if (lifts)
    classifier.find_slips(*lifts);
  else
    classifier.find_last_slip();
  classifier.find_others(taps);
  if (lifts) classifier.find_slow_slips(*lifts);
  return classifier.kinds();
}

}  // namespace tactile::splitting
