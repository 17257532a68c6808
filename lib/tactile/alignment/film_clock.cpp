#include "tactile/alignment/film_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tactile/alignment/film_match.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

constexpr double most_longer_us = 400'000, most_drift = 0.3;
constexpr double usual = 3;             // standard deviations
constexpr double contradicted = 12;     // [nats] by which another length or rate fits better than any usual one
constexpr double well_explained = 0.9;  // of the variance of the energies, by a usual line: then there is no contradiction
constexpr double least_probability = 0.95;
constexpr const char* nothing_moves = "nothing moves that the film should show";

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

/// A line of a grid, and how much of the probability is near it.
struct Place {
  FilmLine line;
  double probability = 0;     ///< that the film shows this motion, at this place
  bool is_by_chance = false;  ///< else it shows it at another place as well
};

struct Coarse {
  Place usual, any;  ///< among usual drifts, by their probability; and among all drifts
  double offset_step = 0, drift_step = 0;
};

/// @param log_p  of each line, 0 by chance
Place best_of(const FilmMatch& match, const std::vector<FilmLine>& lines, const std::vector<double>& log_p) {
  const auto most = static_cast<std::size_t>(std::max_element(log_p.begin(), log_p.end()) - log_p.begin());
  Place place{.line = lines[most]};
  // A motion of another length fits at all offsets at which one lies within the other.
  double near_us = 100'000;
  for (const FilmMatch::Stretch& move : match.moves()) {
    const double film = match.on_film(place.line, move.middle());
    if (film > 0 && film < match.film_us()) near_us = std::max(near_us, 0.5 * move.length());
  }
  double near = 0, elsewhere = 0;
  for (std::size_t i = 0; i < lines.size(); ++i)
    (std::abs(lines[i].offset - place.line.offset) <= near_us ? near : elsewhere) += std::exp(log_p[i] - log_p[most]);
  const double by_chance = std::exp(-log_p[most]) * static_cast<double>(lines.size());
  place.probability = near / (near + elsewhere + by_chance);
  place.is_by_chance = by_chance > elsewhere;
  return place;
}

/// By a grid of half a frame or 8 ms, and of drifts by which the outer motions move by a tenth of a second. Nothing if it would
/// be too large.
std::optional<Coarse> coarse_match(const FilmMatch& match) {
  constexpr double most_offsets = 8'192, widest_drift_step = 0.02, apart_us = 100'000, most_drifts = 40, most_usual = 100;
  constexpr double least_step_us = 8'000;
  const double from = -match.film_us(), to = match.length_us();
  const double step = std::max({0.5 * match.frame_us(), least_step_us, (to - from) / most_offsets});
  const double drift_step = std::min(widest_drift_step, apart_us / std::max(match.span_us(), 1.0));
  const double usual_steps = std::ceil(usual * match.usual_drift() / drift_step);
  const double shortest = std::ranges::min_element(match.moves(), {}, &FilmMatch::Stretch::length)->length();
  if ((match.span_us() > 0 && usual_steps > most_usual) || step > std::max(0.5 * shortest, match.frame_us())) return std::nullopt;
  const int drifts =
      match.span_us() > 0 ? static_cast<int>(std::max(usual_steps, std::min(most_drift / drift_step, most_drifts))) : 0;
  std::vector<FilmLine> lines;
  std::vector<double> log_p;
  for (int d = -drifts; d <= drifts; ++d) {
    for (int i = 0; from + step * i <= to; ++i) {
      lines.push_back({.offset = from + step * i, .drift = drift_step * d});
      log_p.push_back(match.log_likelihood(lines.back()));
    }
  }
  Coarse found{.usual = {}, .any = best_of(match, lines, log_p), .offset_step = step, .drift_step = drift_step};
  for (std::size_t i = 0; i < lines.size(); ++i) log_p[i] += match.log_prior(lines[i]);
  found.usual = best_of(match, lines, log_p);
  return found;
}

/// The line that fits best, near another one. @param log_p  of a line
template <class LogP>
FilmLine fine_match(const FilmMatch& match, const Coarse& coarse, FilmLine line, const FilmLine& most, LogP log_p) {
  constexpr int each_way = 16, rounds = 6;
  double best = log_p(line);
  double part = 1;
  const auto improve = [&](double FilmLine::*value, double reach, double most_value) {
    const double middle = line.*value;
    for (int i = -each_way; i <= each_way; ++i) {
      FilmLine other = line;
      other.*value = std::clamp(middle + part * reach * i / each_way, -most_value, most_value);
      if (const double p = log_p(other); p > best) best = p, line = other;
    }
  };
  for (int round = 0; round < rounds; ++round, part /= 4) {
    improve(&FilmLine::offset, std::max(3 * match.frame_us(), coarse.offset_step), most.offset);
    improve(&FilmLine::longer, most.longer, most.longer);
    if (match.span_us() > 0)
      improve(&FilmLine::drift, std::max(2 * match.frame_us() / match.span_us(), coarse.drift_step), most.drift);
  }
  return line;
}

/// Mean and standard deviation of one number of a line.
struct Spread {
  double mean = 0, sigma = 0;
};

/// The moments of the posterior around the likeliest line.
struct Moments {
  Spread offset, drift, longer;
  double offset_drift = 0;  ///< covariance

  /// On a grid that follows what it finds, so that it is as wide and as fine as the posterior.
  Moments(const FilmMatch& match, const FilmLine& best) {
    constexpr double first_reach_us = 60'000;
    constexpr int rounds = 5;
    offset = {best.offset, first_reach_us / reach};
    longer = {0, usual_longer_us * usual / reach};
    drift = {best.drift,
             match.span_us() > 0 ? std::min(first_reach_us / match.span_us(), usual * match.usual_drift()) / reach : 0};
    const double moving = match.explained(best).moving;
    for (int round = 0; round < rounds; ++round) sum(match, moving);
  }

 private:
  static constexpr int each_way = 8;
  static constexpr double reach = 4;  // standard deviations

  void sum(const FilmMatch& match, double moving) {
    std::vector<FilmLine> lines;
    std::vector<double> log_p;
    const auto at = [](const Spread& spread, int i) { return spread.mean + reach * spread.sigma * i / each_way; };
    const int drifts = drift.sigma > 0 ? each_way : 0;
    for (int d = -drifts; d <= drifts; ++d) {
      for (int w = -each_way; w <= each_way; ++w) {
        for (int i = -each_way; i <= each_way; ++i) {
          lines.push_back({at(offset, i), at(drift, d), at(longer, w)});
          log_p.push_back(match.log_posterior_near(lines.back(), moving));
        }
      }
    }
    const double most = *std::max_element(log_p.begin(), log_p.end());
    for (double& p : log_p) p = std::exp(p - most);
    const double all = std::accumulate(log_p.begin(), log_p.end(), 0.0);
    const auto mean_of = [&](auto value) {
      double mean = 0;
      for (std::size_t i = 0; i < lines.size(); ++i) mean += log_p[i] / all * value(lines[i]);
      return mean;
    };
    // At least what the grid does not resolve.
    const auto follow = [&](Spread& spread, double FilmLine::*value) {
      const double mean = mean_of([&](const FilmLine& l) { return l.*value; });
      const double step = reach * spread.sigma / each_way;
      const double variance = mean_of([&](const FilmLine& l) { return (l.*value - mean) * (l.*value - mean); });
      spread = {mean, std::max(std::sqrt(variance), 0.5 * step)};
    };
    follow(offset, &FilmLine::offset);
    follow(drift, &FilmLine::drift);
    follow(longer, &FilmLine::longer);
    offset_drift = mean_of([&](const FilmLine& l) { return (l.offset - offset.mean) * (l.drift - drift.mean); });
  }
};

bool is_unusual(const FilmLine& line, double usual_drift) {
  return std::abs(line.drift) > usual * usual_drift || std::abs(line.longer) > usual * usual_longer_us;
}

/// @param fits  better than any usual line
void set_contradiction(FilmClock& found, const MotionEnergy& energy, const FilmLine& fits, double usual_drift) {
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
  if (std::none_of(seen.speed.begin(), seen.speed.end(), [](float v) { return std::isfinite(v) && v > 0; })) return nothing_moves;
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
  FilmMatch match(energy, seen, usual_drift);
  if (match.moves().empty()) return {.clock = {}, .refused = nothing_moves};
  const std::optional<Coarse> coarse = coarse_match(match);
  if (!coarse)
    return {.clock = {},
            .refused = "film and robot log are too long to be compared; expected single runs, as tactile split cuts them"};
  constexpr double any_offset = 1e18;
  FilmMatch of_any = match;
  const FilmLine unusual =
      fine_match(of_any, *coarse, of_any.without_unseen_moves(coarse->any.line), {any_offset, most_drift, most_longer_us},
                 [&](const FilmLine& l) { return of_any.log_likelihood(l); });
  const FilmLine start = match.without_unseen_moves(coarse->usual.line);
  const FilmLine line = fine_match(match, *coarse, start, {any_offset, usual * usual_drift, usual * usual_longer_us},
                                   [&](const FilmLine& l) { return match.log_posterior(l); });
  if (coarse->any.probability >= least_probability && is_unusual(unusual, usual_drift) &&
      match.explained(line).share < well_explained && of_any.log_likelihood(unusual) - match.log_posterior(line) > contradicted) {
    set_contradiction(found, energy, unusual, usual_drift);
  } else if (coarse->usual.probability < least_probability) {
    found.refused =
        coarse->usual.is_by_chance ? "the motion in the film does not match the arm's" : "the film matches at several offsets";
  }
  if (!found.refused.empty()) return found;

  const Moments moments(match, line);
  const bool is_rate_seen = match.span_us() > 0;
  const double drift_variance = moments.drift.sigma * moments.drift.sigma;
  // Where offset and drift are independent: there the offset is known best.
  const double earlier = is_rate_seen ? moments.offset_drift / drift_variance : 0;
  const double on_seen = match.middle() - earlier;
  const double on_film = match.on_film({moments.offset.mean, moments.drift.mean}, on_seen);
  // A motion that is longer in the film may be so at its start or at its end, each motion in its own way.
  const double by_length = (moments.longer.mean * moments.longer.mean + moments.longer.sigma * moments.longer.sigma) / 12;
  const double variance = std::max(0.0, moments.offset.sigma * moments.offset.sigma - earlier * moments.offset_drift) + by_length;
  FittedClock& clock = found.clock.emplace();
  clock.found_at_us = saturating_add(us_of(energy.begin()), std::llround(on_film));
  const CameraTime found_at = after(seen.begin, microseconds{std::llround(on_seen)});
  clock.relation = {.offset_us = 0, .drift_ppm = 1e6 * moments.drift.mean, .reference_us = us_of(energy.begin())};
  if (__builtin_sub_overflow(us_of(found_at), us_of(clock.relation.camera_from(clock.found_at_us)), &clock.relation.offset_us))
    return {.clock = {}, .refused = "the two clocks lie further apart than 64 bits of microseconds"};
  const double half_us = normal_95 * std::hypot(std::sqrt(variance), seen.sigma_us);
  clock.offset_low_us = saturating_subtract(clock.relation.offset_us, std::llround(half_us));
  clock.offset_high_us = saturating_add(clock.relation.offset_us, std::llround(half_us));
  clock.drift_within_ppm =
      1e6 * normal_95 *
      (is_rate_seen ? std::sqrt(drift_variance + 2 * by_length / (match.span_us() * match.span_us())) : usual_drift);
  clock.anchors = static_cast<int>(match.moves().size());
  clock.method = fmt::format("the arm's motions in the film ({})", clock.anchors);
  if (counted) found.remark = remark_on_counted(energy, clock, is_rate_seen);
  return found;
}

}  // namespace tactile::alignment
