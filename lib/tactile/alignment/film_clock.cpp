#include "tactile/alignment/film_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

constexpr double independent_us = 300'000;  // between steps whose energies are independent
constexpr double usual_longer_us = 20'000;  // standard deviation of what a motion is longer by in the film
constexpr double most_longer_us = 400'000, most_drift = 0.3;
constexpr double usual = 3;             // standard deviations
constexpr double contradicted = 12;     // [nats] by which another length or rate fits better than any usual one
constexpr double well_explained = 0.9;  // of the variance of the energies, by a usual line: then there is no contradiction
constexpr double least_probability = 0.95;

double rate_of(const MotionEnergy& energy) {
  return 1e6 / static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1));
}

/// Whether its times are those of a rate, such as index / 30: half of the steps or more are equal. Times that were measured vary
/// by more than rounding does.
bool counts_frames(const MotionEnergy& energy) {
  constexpr double rounding_us = 2;
  std::vector<double> lengths;
  for (const MotionStep& step : energy.steps) lengths.push_back(static_cast<double>((step.end - step.begin).count()));
  return median(distances_from(median(lengths), lengths)) <= rounding_us;
}

/// Of films, standard deviation.
double usual_drift_of(bool counts_frames) {
  constexpr double of_rates = 0.005, of_lost_frames = 0.014;
  return std::hypot(of_rates, counts_frames ? of_lost_frames : 0.0);
}

std::string remark_on_counted(const MotionEnergy& energy, const FittedClock& clock, bool is_rate_seen) {
  const auto within = [&](VideoTime t) { return clock.uncertainty_at(clock.relation.camera_from(t)); };
  std::string remark = fmt::format(
      "the times of the film are even: they count its frames, and do not say when one was taken; they may be off by {:.0f} ms",
      1e-3 * static_cast<double>(std::max(within(energy.begin()), within(energy.end())).count()));
  if (is_rate_seen) return remark;
  return fmt::format("{}, or by more if the film was not taken at {:.4g} frames/s: its motions do not show its rate", remark,
                     rate_of(energy));
}

/// A step of the film, in microseconds from the film's begin.
struct Step {
  double begin, end, energy;
};

/// A stretch of the seen motion, in microseconds from its first value.
struct Move {
  double begin, end;

  double middle() const { return 0.5 * (begin + end); }
  double length() const { return end - begin; }
};

/// The relation of both times: film + offset + drift * (film + offset - middle).
struct Line {
  double offset = 0, drift = 0;
  double longer = 0;  ///< a motion in the film [us]
};

/// A film and the motion that it should have seen.
class Match {
 public:
  Match(const MotionEnergy& energy, const SeenMotion& seen, double usual_drift)
      : step_us_(static_cast<double>(seen.step.count())), usual_drift_(usual_drift) {
    for (const MotionStep& step : energy.steps)
      steps_.push_back({in_film(energy, step.begin), in_film(energy, step.end), step.energy});
    sums_.push_back({});
    for (const Step& step : steps_) sums_.push_back(sums_.back().with(step));
    integrals_.push_back(0);
    for (std::size_t i = 0; i + 1 < seen.speed.size(); ++i) {
      integrals_.push_back(integrals_[i] + 0.5 * (seen.speed[i] + seen.speed[i + 1]));
      if (integrals_[i + 1] > integrals_[i]) add_to_moves(i);
    }
    frame_us_ = static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1));
    middle_ = 0.5 * (moves_.front().middle() + moves_.back().middle());
  }

  /// Leaves out motions that the film does not reach. @return  the same line, from the middle of the others
  Line without_unseen_moves(const Line& line) {
    std::erase_if(moves_, [&](const Move& move) {
      const double film = on_film(line, move.middle());
      return moves_.size() > 1 && (film < 0 || film > film_us());
    });
    const double before = std::exchange(middle_, 0.5 * (moves_.front().middle() + moves_.back().middle()));
    return {line.offset + line.drift / (1 + line.drift) * (middle_ - before), moves_.size() > 1 ? line.drift : 0};
  }

  const std::vector<Move>& moves() const { return moves_; }
  double middle() const { return middle_; }
  double frame_us() const { return frame_us_; }
  /// From the first motion's middle to the last one's.
  double span_us() const { return moves_.back().middle() - moves_.front().middle(); }
  double length_us() const { return step_us_ * static_cast<double>(integrals_.size() - 1); }
  double film_us() const { return steps_.back().end; }

  /// The film's time of a time of the speed.
  double on_film(const Line& line, double seen) const { return middle_ + (seen - middle_) / (1 + line.drift) - line.offset; }

  /// How much of the film the motion explains.
  struct Explained {
    double us = 0;     ///< for which the speed is known
    double share = 0;  ///< of the variance of the energies then, r^2
  };

  Explained explained(const Line& line) const {
    const auto on_seen = [&](double film) { return film + line.offset + line.drift * (film + line.offset - middle_); };
    const auto first_after = [&](double seen) {
      const double film = on_film(line, seen);
      return static_cast<std::size_t>(
          std::partition_point(steps_.begin(), steps_.end(), [film](const Step& step) { return step.begin < film; }) -
          steps_.begin());
    };
    const std::size_t first = first_after(0), last = std::max(first, std::min(first_after(length_us()), steps_.size()));
    Sums sums = sums_[last].without(sums_[first]);
    double v = 0, vv = 0, ev = 0;
    for (std::size_t m = 0; m < moves_.size(); ++m) {
      const double before = m == 0 ? 0 : 0.5 * (moves_[m - 1].end + moves_[m].begin);
      const double after = m + 1 == moves_.size() ? length_us() : 0.5 * (moves_[m].end + moves_[m + 1].begin);
      const Move& move = moves_[m];
      const double shorter = move.length() / std::max(move.length() + line.longer, 0.1 * move.length());
      const auto travelled = [&](double film) {
        const double seen = std::clamp(on_seen(film), before, after);
        return integral(std::clamp(move.middle() + (seen - move.middle()) * shorter, before, after));
      };
      const double reach = 0.5 * move.length() / shorter + 2 * frame_us_;
      const std::size_t from = std::clamp(first_after(std::max(move.middle() - reach, before)), first + 1, last + 1) - 1;
      for (std::size_t i = from; i < last && on_seen(steps_[i].begin) < std::min(move.middle() + reach, after); ++i) {
        const Step& step = steps_[i];
        const double length = step.end - step.begin, speed = (travelled(step.end) - travelled(step.begin)) / length;
        v += length * speed;
        vv += length * speed * speed;
        ev += length * step.energy * speed;
      }
    }
    const double spread_e = sums.w * sums.ee - sums.e * sums.e, spread_v = sums.w * vv - v * v, both = sums.w * ev - sums.e * v;
    constexpr std::size_t fewest = 6;
    if (last - first < fewest || !(spread_e > 0) || !(spread_v > 0) || both <= 0) return {};
    return {sums.w, std::min(both * both / (spread_e * spread_v), 0.9999)};
  }

  /// ln p(film | line), 0 for a film that has nothing to do with the motion.
  double log_likelihood(const Line& line) const {
    const Explained by_motion = explained(line);
    return -0.5 * by_motion.us / independent_us * std::log1p(-by_motion.share);
  }

  /// The same of a film with usual times.
  double log_posterior(const Line& line) const {
    const double z_longer = line.longer / usual_longer_us, z_drift = line.drift / usual_drift_;
    return log_likelihood(line) - 0.5 * (z_longer * z_longer + z_drift * z_drift);
  }
  double usual_drift() const { return usual_drift_; }

 private:
  struct Sums {  // weighted by the length of a step
    double w = 0, e = 0, ee = 0;

    Sums with(const Step& step) const {
      const double length = step.end - step.begin;
      return {w + length, e + length * step.energy, ee + length * step.energy * step.energy};
    }
    Sums without(const Sums& other) const { return {w - other.w, e - other.e, ee - other.ee}; }
  };

  static double in_film(const MotionEnergy& energy, VideoTime t) { return static_cast<double>((t - energy.begin()).count()); }

  void add_to_moves(std::size_t i) {
    constexpr double one_motion_us = 100'000;
    const double begin = step_us_ * static_cast<double>(i);
    if (moves_.empty() || begin > moves_.back().end + one_motion_us) moves_.push_back({begin, begin});
    moves_.back().end = begin + step_us_;
  }

  double integral(double t) const {
    const double place = std::clamp(t / step_us_, 0.0, static_cast<double>(integrals_.size() - 1));
    const std::size_t i = std::min(static_cast<std::size_t>(place), integrals_.size() - 2);
    return integrals_[i] + (place - static_cast<double>(i)) * (integrals_[i + 1] - integrals_[i]);
  }

  std::vector<Step> steps_;
  std::vector<Sums> sums_;         // of the steps before each
  std::vector<double> integrals_;  // of the speed, in steps
  std::vector<Move> moves_;
  double step_us_, frame_us_ = 1, middle_ = 0, usual_drift_;
};

/// The lines that fit best, for motions of the arm's length.
struct Coarse {
  Line usual, any;            ///< of usual drifts, and of all
  double probability = 0;     ///< that the film shows this motion, at this place
  bool is_by_chance = false;  ///< else it shows it at another place as well
};

/// By a grid of half a frame, and of drifts by which the outer motions move by a tenth of a second.
Coarse coarse_match(const Match& match) {
  constexpr double most_offsets = 8'192, widest_drift_step = 0.02, apart_us = 100'000, most_drifts = 40;
  const double from = -match.film_us(), to = match.length_us();
  const double step = std::max(0.5 * match.frame_us(), (to - from) / most_offsets);
  const double drift_step = std::min(widest_drift_step, apart_us / std::max(match.span_us(), 1.0));
  const int drifts = match.span_us() > 0 ? static_cast<int>(std::min(most_drift / drift_step, most_drifts)) : 0;
  std::vector<Line> lines;
  std::vector<double> log_p;
  Coarse found;
  double most = 0, most_usual = 0;
  for (int d = -drifts; d <= drifts; ++d) {
    for (int i = 0; from + step * i <= to; ++i) {
      const Line& line = lines.emplace_back(Line{.offset = from + step * i, .drift = drift_step * d});
      log_p.push_back(match.log_likelihood(line));
      if (log_p.back() > most) most = log_p.back(), found.any = line;
      if (log_p.back() > most_usual && std::abs(line.drift) <= usual * match.usual_drift())
        most_usual = log_p.back(), found.usual = line;
    }
  }
  // A motion of another length fits at all offsets at which one lies within the other.
  const double near_us = std::max(apart_us, 0.5 * std::ranges::max_element(match.moves(), {}, &Move::length)->length());
  double near = 0, elsewhere = 0;
  for (std::size_t i = 0; i < lines.size(); ++i)
    (std::abs(lines[i].offset - found.any.offset) <= near_us ? near : elsewhere) += std::exp(log_p[i] - most);
  const double by_chance = std::exp(-most) * static_cast<double>(lines.size());
  found.probability = near / (near + elsewhere + by_chance);
  found.is_by_chance = by_chance > elsewhere;
  return found;
}

/// The line that fits best, near another one. @param log_p  of a line
template <class LogP>
Line fine_match(const Match& match, Line line, const Line& most, LogP log_p) {
  constexpr int each_way = 16, rounds = 6;
  double best = log_p(line);
  double part = 1;
  const auto improve = [&](double Line::*value, double reach, double most_value) {
    const double middle = line.*value;
    for (int i = -each_way; i <= each_way; ++i) {
      Line other = line;
      other.*value = std::clamp(middle + part * reach * i / each_way, -most_value, most_value);
      if (const double p = log_p(other); p > best) best = p, line = other;
    }
  };
  for (int round = 0; round < rounds; ++round, part /= 4) {
    improve(&Line::offset, 3 * match.frame_us(), most.offset);
    improve(&Line::longer, most.longer, most.longer);
    if (match.span_us() > 0) improve(&Line::drift, 2 * match.frame_us() / match.span_us(), most.drift);
  }
  return line;
}

/// The moments of the posterior around the likeliest line.
struct Moments {
  double offset = 0, drift = 0;                                 ///< means
  double offset_offset = 0, offset_drift = 0, drift_drift = 0;  ///< variances
  double longer_longer = 0;                                     ///< mean square

  explicit Moments(const Match& match, const Line& best) {
    constexpr int each_way = 12;
    const double most_p = match.log_posterior(best);
    const double offset_step = 1.5 * match.frame_us() / each_way, longer_step = usual * usual_longer_us / each_way;
    const double drift_step = match.span_us() > 0 ? 2 * match.frame_us() / match.span_us() / each_way : 0;
    const int drifts = drift_step > 0 ? each_way : 0;
    double all = 0;
    for (int d = -drifts; d <= drifts; ++d) {
      for (int w = -each_way; w <= each_way; ++w) {
        for (int i = -each_way; i <= each_way; ++i) {
          const double off = offset_step * i, drifted = drift_step * d, longer = longer_step * w;
          const double p = std::exp(match.log_posterior({best.offset + off, best.drift + drifted, longer}) - most_p);
          all += p;
          offset += p * off;
          drift += p * drifted;
          offset_offset += p * off * off;
          offset_drift += p * off * drifted;
          drift_drift += p * drifted * drifted;
          longer_longer += p * longer * longer;
        }
      }
    }
    offset /= all, drift /= all;
    offset_offset = offset_offset / all - offset * offset;
    offset_drift = offset_drift / all - offset * drift;
    drift_drift = drift_drift / all - drift * drift;
    longer_longer /= all;
    offset += best.offset, drift += best.drift;
  }
};

/// @param fits  better than any usual line
void set_contradiction(FilmClock& found, const MotionEnergy& energy, const Line& fits, double usual_drift) {
  if (std::abs(fits.drift) > usual * usual_drift) {
    found.refused = fmt::format(
        "the times of the film give {:.4g} frames/s, but by the distance of its motions it has about {:.3g} frames/s; expected "
        "times of the film's own rate",
        rate_of(energy), rate_of(energy) / (1 + fits.drift));
    return;
  }
  found.contradiction = doubt("film-unlike-arm",
                              "a motion in the film and the arm's in the robot log differ by {:.0f} ms in length: one of the two "
                              "may be of another recording, or the film lacks frames",
                              1e-3 * std::abs(fits.longer));
  found.refused = found.contradiction.words;
}

/// Why film and speed cannot be compared; empty if they can.
std::string refusal_of(const MotionEnergy& energy, const SeenMotion& seen) {
  constexpr std::size_t fewest_steps = 8;
  if (energy.steps.size() < fewest_steps)
    return fmt::format("the film has {} steps from frame to frame; expected at least {}", energy.steps.size(), fewest_steps);
  if (seen.speed.size() < 2) return "nothing is known of the motion that the film should show";
  if (std::none_of(seen.speed.begin(), seen.speed.end(), [](float v) { return v > 0; }))
    return "nothing moves that the film should show";
  if (std::none_of(energy.steps.begin(), energy.steps.end(), [](const MotionStep& step) { return step.energy > 0; }))
    return "nothing moves in the film";
  return {};
}

}  // namespace

std::string allow_for_drift(FittedClock& clock, const MotionEnergy& energy) {
  const bool counted = counts_frames(energy);
  clock.found_at_us = us_of(energy.begin() + (energy.end() - energy.begin()) / 2);
  clock.drift_within_ppm = 1e6 * normal_95 * usual_drift_of(counted);
  return counted ? remark_on_counted(energy, clock, false) : std::string();
}

FilmClock film_clock(const MotionEnergy& energy, const SeenMotion& seen) {
  FilmClock found{.clock = {}, .refused = refusal_of(energy, seen)};
  if (!found.refused.empty()) return found;
  const bool counted = counts_frames(energy);
  const double usual_drift = usual_drift_of(counted);
  Match match(energy, seen, usual_drift);
  Coarse coarse = coarse_match(match);
  if (coarse.probability < least_probability) {
    found.refused =
        coarse.is_by_chance ? "the motion in the film does not match the arm's" : "the film matches at several offsets";
    return found;
  }
  constexpr double any_offset = 1e18;
  const Line unusual = fine_match(match, coarse.any, {any_offset, most_drift, most_longer_us},
                                  [&](const Line& l) { return match.log_likelihood(l); });
  const double unusual_log_p = match.log_likelihood(unusual);
  coarse.usual = match.without_unseen_moves(coarse.usual);
  const Line line = fine_match(match, coarse.usual, {any_offset, usual * usual_drift, usual * usual_longer_us},
                               [&](const Line& l) { return match.log_posterior(l); });
  if (match.explained(line).share < well_explained && unusual_log_p - match.log_posterior(line) > contradicted) {
    set_contradiction(found, energy, unusual, usual_drift);
    return found;
  }

  const Moments moments(match, line);
  const bool is_rate_seen = match.span_us() > 0;
  // Where offset and drift are independent: there the offset is known best.
  const double earlier = is_rate_seen && moments.drift_drift > 0 ? moments.offset_drift / moments.drift_drift : 0;
  const double on_seen = match.middle() - earlier;
  const double on_film = match.on_film({moments.offset, moments.drift}, on_seen);
  // A motion that is longer in the film may be so at its start or at its end.
  const double variance = moments.offset_offset - earlier * moments.offset_drift + moments.longer_longer / 12;
  FittedClock& clock = found.clock.emplace();
  clock.found_at_us = saturating_add(us_of(energy.begin()), std::llround(on_film));
  const CameraTime found_at = after(seen.begin, microseconds{std::llround(on_seen)});
  clock.relation = {.offset_us = 0, .drift_ppm = 1e6 * moments.drift, .reference_us = us_of(energy.begin())};
  if (__builtin_sub_overflow(us_of(found_at), us_of(clock.relation.camera_from(clock.found_at_us)), &clock.relation.offset_us))
    return {.clock = {}, .refused = "the two clocks lie further apart than 64 bits of microseconds"};
  const double half_us = normal_95 * std::hypot(std::sqrt(variance), seen.sigma_us);
  clock.offset_low_us = saturating_subtract(clock.relation.offset_us, std::llround(half_us));
  clock.offset_high_us = saturating_add(clock.relation.offset_us, std::llround(half_us));
  clock.drift_within_ppm = 1e6 * normal_95 * (is_rate_seen ? std::sqrt(moments.drift_drift) : usual_drift);
  clock.anchors = static_cast<int>(match.moves().size());
  clock.method = fmt::format("the arm's motions in the film ({})", clock.anchors);
  if (counted) found.remark = remark_on_counted(energy, clock, is_rate_seen);
  return found;
}

}  // namespace tactile::alignment
