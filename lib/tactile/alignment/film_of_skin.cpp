#include "tactile/alignment/film_of_skin.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "tactile/alignment/film_motions.hpp"

namespace tactile::alignment {
namespace {

/// Standard deviation of a motion's start or end in the film against that of a burst [us].
double sigma_of(const VideoSpan& span) {
  constexpr double of_burst = 15'000;
  return std::hypot(of_burst, 0.5 / normal_95 * static_cast<double>((span.high - span.low).count()));
}

double saturating_distance(std::int64_t a, std::int64_t b) {
  return std::abs(static_cast<double>(a > b ? saturating_subtract(a, b) : saturating_subtract(b, a)));
}

/// The burst that ends with a motion of the film, or starts with it.
struct BurstFit {
  const SeenBurst* burst = nullptr;
  bool starts = false, ends = false;
  double score = 0;  ///< 0 to 1 for its end, and 0 to 1 for its start
};

/// How much a motion changes the film [grey levels].
double change_of(const FilmedMotion& motion) {
  return motion.energy * 1e-6 * static_cast<double>(saturating_subtract(us_of(motion.end.at), us_of(motion.start.at)));
}

/// Without what is far fainter than the largest motion: a coder's corrections, or light.
std::vector<FilmedMotion> without_faint(std::vector<FilmedMotion> filmed) {
  constexpr double least = 0.005;
  double largest = 0;
  for (const FilmedMotion& motion : filmed) largest = std::max(largest, change_of(motion));
  std::erase_if(filmed, [&](const FilmedMotion& motion) { return change_of(motion) < least * largest; });
  return filmed;
}

/// Motions of a film and bursts of the events; an offset is camera time minus the film's.
class BurstMatch {
 public:
  BurstMatch(const MotionEnergy& energy, std::vector<FilmedMotion> filmed, std::vector<SeenBurst> bursts)
      : energy_(energy), filmed_(std::move(filmed)), bursts_(std::move(bursts)) {
    std::sort(bursts_.begin(), bursts_.end(), [](const SeenBurst& one, const SeenBurst& other) { return one.end < other.end; });
  }

  struct Candidate {
    std::int64_t offset_us = 0;
    double score = 0;
  };

  /// Of every pair of a burst's end and a motion's end, or of their starts.
  std::vector<Candidate> candidates(const VideoClockOptions& options) const {
    std::vector<Candidate> found;
    const auto add = [&](std::int64_t rough_us) {
      if (options.coarse_offset_us &&
          saturating_distance(rough_us, *options.coarse_offset_us) > static_cast<double>(options.search.count()))
        return;
      Candidate candidate{settled(rough_us), 0};
      for (const FilmedMotion& other : filmed_) candidate.score += fit_of(other, candidate.offset_us).score;
      candidate.score *= share_in_both(candidate.offset_us);
      found.push_back(candidate);
    };
    for (const FilmedMotion& motion : filmed_) {
      for (const SeenBurst& burst : bursts_) {
        add(saturating_subtract(us_of(burst.end), us_of(motion.end.at)));
        if (!motion.start_cut) add(saturating_subtract(us_of(burst.start), us_of(motion.start.at)));
      }
    }
    return found;
  }

  std::vector<ClockAnchor> anchors(std::int64_t offset_us) const {
    constexpr double common_sigma_us = 10'000;
    std::vector<ClockAnchor> anchors;
    for_ends(offset_us, [&](CameraTime camera, const VideoSpan& video) {
      anchors.push_back({.clock_us = us_of(video.at),
                         .camera = camera,
                         .sigma_us = sigma_of(video),
                         .kind = AnchorKind::film_of_skin,
                         .bias_us = common_sigma_us});
    });
    return anchors;
  }

  /// Bursts that start or end with a motion at the offset, whether one of them starts so, and whether one does both.
  struct Matched {
    std::set<const SeenBurst*> bursts;
    bool starts = false, starts_and_ends = false;
  };
  Matched matched(std::int64_t offset_us) const {
    Matched matched;
    for (const FilmedMotion& motion : filmed_) {
      const BurstFit found = fit_of(motion, offset_us);
      if (found.burst == nullptr) continue;
      matched.bursts.insert(found.burst);
      matched.starts |= found.starts;
      matched.starts_and_ends |= found.starts && found.ends;
    }
    return matched;
  }

 private:
  /// The burst whose end comes nearest to the motion's; if none is near, the one whose start does. Whatever fires, moves: the
  /// motion starts no later than the burst, and ends no earlier.
  BurstFit fit_of(const FilmedMotion& motion, std::int64_t offset_us) const {
    BurstFit best;
    for (const SeenBurst& burst : bursts_) {
      const BurstFit fit = fit_of(motion, burst, offset_us);
      if (std::pair(fit.ends, fit.score) > std::pair(best.ends, best.score)) best = fit;
    }
    return best;
  }

  static BurstFit fit_of(const FilmedMotion& motion, const SeenBurst& burst, std::int64_t offset_us) {
    constexpr double farthest = 3;  // standard deviations
    const auto later = [offset_us](CameraTime seen, const VideoSpan& span) {
      return static_cast<double>(between(CameraTime{microseconds{saturating_add(us_of(span.at), offset_us)}}, seen).count()) /
             sigma_of(span);
    };
    const double start_late = later(burst.start, motion.start), end_late = later(burst.end, motion.end);
    if ((start_late < -farthest && !motion.start_cut) || (end_late > farthest && !motion.end_cut)) return {};
    const bool starts = std::abs(start_late) <= farthest && !motion.start_cut;
    const bool ends = std::abs(end_late) <= farthest && !motion.end_cut;
    if (!starts && !ends) return {};
    const auto likely = [](double x) { return std::exp(-0.5 * x * x); };
    return {&burst, starts, ends, (ends ? likely(end_late) : 0.0) + (starts ? likely(start_late) : 0.0)};
  }

  /// Calls `use` with each end, and each start that counts, of a burst and its motion at the offset.
  template <class Use>
  void for_ends(std::int64_t offset_us, const Use& use) const {
    for (const FilmedMotion& motion : filmed_) {
      const BurstFit found = fit_of(motion, offset_us);
      if (found.burst == nullptr) continue;
      if (found.starts) use(found.burst->start, motion.start);
      if (found.ends) use(found.burst->end, motion.end);
    }
  }

  /// The mean offset of the bursts that fit at `offset_us`.
  std::int64_t settled(std::int64_t offset_us) const {
    double weights = 0, sum = 0;
    for_ends(offset_us, [&](CameraTime camera, const VideoSpan& video) {
      const double weight = std::pow(sigma_of(video), -2);
      weights += weight;
      sum += weight * static_cast<double>(saturating_subtract(saturating_subtract(us_of(camera), us_of(video.at)), offset_us));
    });
    return weights > 0 ? saturating_add(offset_us, std::llround(sum / weights)) : offset_us;
  }

  /// The share of the bursts' time with motion in the film, times the share of the film's energy during bursts.
  double share_in_both(std::int64_t offset_us) const {
    const auto overlap = [](std::int64_t a_begin, std::int64_t a_end, std::int64_t b_begin, std::int64_t b_end) {
      return static_cast<double>(
          std::max<std::int64_t>(0, saturating_subtract(std::min(a_end, b_end), std::max(a_begin, b_begin))));
    };
    double firing = 0, firing_both = 0, moving = 0, moving_both = 0;
    for (const FilmedMotion& motion : filmed_)
      moving += motion.energy * static_cast<double>(saturating_subtract(us_of(motion.end.at), us_of(motion.start.at)));
    for (const SeenBurst& burst : bursts_) {
      const std::int64_t begin = saturating_subtract(us_of(burst.start), offset_us);
      const std::int64_t end = saturating_subtract(us_of(burst.end), offset_us);
      firing += overlap(begin, end, us_of(energy_.begin()), us_of(energy_.end()));
      for (const FilmedMotion& motion : filmed_) {
        const double both = overlap(begin, end, us_of(motion.start.at), us_of(motion.end.at));
        firing_both += both;
        moving_both += motion.energy * both;
      }
    }
    return firing > 0 && moving > 0 ? firing_both / firing * moving_both / moving : 0.0;
  }

  const MotionEnergy& energy_;
  std::vector<FilmedMotion> filmed_;
  std::vector<SeenBurst> bursts_;  ///< by their ends
};

/// Any motion in view may end with one burst by chance, and two ends may lie as far apart as two others. A start confirms them:
/// that of a lift. One burst alone must start and end with a motion, if the film matches clearly nowhere else.
bool is_confirmed(const BurstMatch::Matched& matched, double score, double ambiguity) {
  constexpr double least_score = 0.5, least_ambiguity = 2;
  if (matched.bursts.size() > 1) return matched.starts;
  return matched.starts_and_ends && score >= least_score && ambiguity >= least_ambiguity;
}

}  // namespace

VideoClockFit fit_video_clock(const MotionEnergy& energy, std::span<const SeenBurst> bursts, const VideoClockOptions& options) {
  constexpr std::size_t most = 200;  // enough of a film with hundreds of motions
  constexpr double same_us = 120'000;
  VideoClockFit fit;
  std::vector<FilmedMotion> filmed = without_faint(filmed_motions(energy, most));
  if (filmed.empty()) {
    fit.refused = "nothing moves in the film";
    return fit;
  }
  if (bursts.empty()) {
    fit.refused = "the events show nothing that moves";
    return fit;
  }
  const auto motions = static_cast<double>(filmed.size());
  bursts = bursts.first(std::min(bursts.size(), most));
  const BurstMatch match(energy, std::move(filmed), {bursts.begin(), bursts.end()});
  const std::vector<BurstMatch::Candidate> candidates = match.candidates(options);
  const auto best = std::max_element(candidates.begin(), candidates.end(),
                                     [](const auto& one, const auto& other) { return one.score < other.score; });
  if (best == candidates.end()) {
    fit.refused = "by the host times no motion of the film is near a burst of events";
    return fit;
  }
  double second = 0;
  for (const BurstMatch::Candidate& other : candidates) {
    if (saturating_distance(other.offset_us, best->offset_us) > same_us) second = std::max(second, other.score);
  }
  fit.likeness = 0.5 * best->score / motions;
  fit.refused = set_ambiguity(fit, best->score, second, options);
  if (!fit.refused.empty()) return fit;
  if (!is_confirmed(match.matched(best->offset_us), best->score, fit.ambiguity)) {
    fit.refused = match.matched(best->offset_us).bursts.size() > 1
                      ? "two bursts of events end with motions of the film, but none starts with one"
                      : "only one burst of events ends with a motion of the film, and nothing confirms it";
    return fit;
  }
  fit.anchors = match.anchors(best->offset_us);
  return with_clock(std::move(fit), energy);
}

}  // namespace tactile::alignment
