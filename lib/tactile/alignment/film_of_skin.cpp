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

/// The burst that ends with a motion of the film.
struct BurstFit {
  const SeenBurst* burst = nullptr;
  bool starts_too = false;
  double score = 0;  ///< 0 to 1 for its end, and 0 to 1 for its start
};

/// Motions of a film and bursts of the events; an offset is camera time less the film's.
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

  /// Of every pair of a burst's end and a motion's end.
  std::vector<Candidate> candidates(const VideoClockOptions& options) const {
    std::vector<Candidate> found;
    for (const FilmedMotion& motion : filmed_) {
      for (const SeenBurst& burst : bursts_) {
        const std::int64_t rough_us = saturating_subtract(us_of(burst.end), us_of(motion.end.at));
        if (options.coarse_offset_us &&
            saturating_distance(rough_us, *options.coarse_offset_us) > static_cast<double>(options.search.count()))
          continue;
        Candidate candidate{settled(rough_us), 0};
        for (const FilmedMotion& other : filmed_) candidate.score += fit_of(other, candidate.offset_us).score;
        candidate.score *= share_in_both(candidate.offset_us);
        found.push_back(candidate);
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

  /// Bursts that end with a motion at the offset, and whether one of them starts with it too.
  struct Matched {
    std::set<const SeenBurst*> bursts;
    bool starts_too = false;
  };
  Matched matched(std::int64_t offset_us) const {
    Matched matched;
    for (const FilmedMotion& motion : filmed_) {
      const BurstFit found = fit_of(motion, offset_us);
      if (found.burst == nullptr) continue;
      matched.bursts.insert(found.burst);
      matched.starts_too |= found.starts_too;
    }
    return matched;
  }

 private:
  BurstFit fit_of(const FilmedMotion& motion, std::int64_t offset_us) const {
    constexpr double farthest = 3;  // standard deviations
    if (motion.end_cut) return {};
    const auto camera_of = [&](const VideoSpan& span) {
      return CameraTime{microseconds{saturating_add(us_of(span.at), offset_us)}};
    };
    const auto apart = [](CameraTime one, CameraTime other, double sigma) {
      return static_cast<double>(between(one, other).count()) / sigma;
    };
    const CameraTime end = camera_of(motion.end);
    auto burst =
        std::lower_bound(bursts_.begin(), bursts_.end(), end, [](const SeenBurst& b, CameraTime t) { return b.end < t; });
    if (burst != bursts_.begin() && (burst == bursts_.end() || between(end, burst->end) > between((burst - 1)->end, end)))
      --burst;
    const double end_apart = apart(end, burst->end, sigma_of(motion.end));
    if (std::abs(end_apart) > farthest) return {};
    // Whatever fires, moves.
    const double start_late = apart(burst->start, camera_of(motion.start), sigma_of(motion.start));
    if (start_late > farthest && !motion.start_cut) return {};
    const bool starts_too = std::abs(start_late) <= farthest && !motion.start_cut;
    const auto likely = [](double x) { return std::exp(-0.5 * x * x); };
    return {&*burst, starts_too, likely(end_apart) * (1 + (starts_too ? likely(start_late) : 0.0))};
  }

  /// Calls `use` with each end, and each start that counts, of a burst and its motion at the offset.
  template <class Use>
  void for_ends(std::int64_t offset_us, const Use& use) const {
    for (const FilmedMotion& motion : filmed_) {
      const BurstFit found = fit_of(motion, offset_us);
      if (found.burst == nullptr) continue;
      if (found.starts_too) use(found.burst->start, motion.start);
      use(found.burst->end, motion.end);
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

/// Any motion in view may end with one burst by chance. A second burst confirms it, or the start of the same one if the film
/// matches clearly nowhere else.
bool is_confirmed(const BurstMatch::Matched& matched, double score, double ambiguity) {
  constexpr double least_score = 0.5, least_ambiguity = 2;
  return matched.bursts.size() > 1 || (matched.starts_too && score >= least_score && ambiguity >= least_ambiguity);
}

}  // namespace

VideoClockFit fit_video_clock(const MotionEnergy& energy, std::span<const SeenBurst> bursts, const VideoClockOptions& options) {
  constexpr std::size_t most = 200;  // enough of a film with hundreds of motions
  constexpr double same_us = 120'000;
  VideoClockFit fit;
  std::vector<FilmedMotion> filmed = filmed_motions(energy, most);
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
    fit.refused = "only one burst of events ends with a motion of the film, and nothing confirms it";
    return fit;
  }
  fit.anchors = match.anchors(best->offset_us);
  return with_clock(std::move(fit), energy);
}

}  // namespace tactile::alignment
