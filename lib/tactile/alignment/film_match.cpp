#include "tactile/alignment/film_match.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tactile::alignment {
namespace {

constexpr double independent_us = 300'000;        // between steps whose energies are independent
constexpr double independent_moving_us = 60'000;  // the same while something moves: these steps show how exact an offset is

}  // namespace

FilmMatch::FilmMatch(const MotionEnergy& energy, const SeenMotion& seen, double usual_drift)
    : step_us_(static_cast<double>(seen.step.count())),
      frame_us_(static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1))),
      usual_drift_(usual_drift) {
  constexpr double one_motion_us = 100'000;
  const auto in_film = [&](VideoTime t) { return static_cast<double>((t - energy.begin()).count()); };
  for (const MotionStep& step : energy.steps) steps_.push_back({in_film(step.begin), in_film(step.end), step.energy});
  sums_.push_back({});
  for (const FilmStep& step : steps_) sums_.push_back(sums_.back().with(step));
  integrals_.push_back(0);
  for (std::size_t i = 0; i + 1 < seen.speed.size(); ++i) {
    const double mean = 0.5 * (seen.speed[i] + seen.speed[i + 1]);
    if (!std::isfinite(mean)) add_to(gaps_, i, 0);
    if (std::isfinite(mean) && mean > 0) add_to(moves_, i, one_motion_us);
    integrals_.push_back(integrals_[i] + (std::isfinite(mean) ? mean : 0));
  }
  set_middle([](const Stretch&) { return true; });
}

/// A gap within a motion does not end it.
void FilmMatch::add_to(std::vector<Stretch>& stretches, std::size_t i, double apart_us) const {
  const double begin = step_us_ * static_cast<double>(i);
  const auto goes_on_from = [apart_us](double end, double next) { return next <= end + apart_us; };
  const bool goes_on =
      !stretches.empty() &&
      (goes_on_from(stretches.back().end, begin) ||
       (!gaps_.empty() && goes_on_from(stretches.back().end, gaps_.back().begin) && goes_on_from(gaps_.back().end, begin)));
  if (!goes_on) stretches.push_back({begin, begin});
  stretches.back().end = begin + step_us_;
}

/// @param counts  whether a motion does; if none does, the first one
template <class Counts>
void FilmMatch::set_middle(Counts counts) {
  if (moves_.empty()) return;
  const auto first = std::find_if(moves_.begin(), moves_.end(), counts);
  const auto last = std::find_if(moves_.rbegin(), moves_.rend(), counts);
  const double begin = (first == moves_.end() ? moves_.front() : *first).middle();
  const double end = (last == moves_.rend() ? moves_.front() : *last).middle();
  middle_ = 0.5 * (begin + end);
  span_ = end - begin;
}

FilmLine FilmMatch::without_unseen_moves(const FilmLine& line) {
  const double before = middle_;
  std::vector<Stretch> reached;
  std::copy_if(moves_.begin(), moves_.end(), std::back_inserter(reached),
               [&](const Stretch& move) { return on_film(line, move.end) > 0 && on_film(line, move.begin) < film_us(); });
  if (!reached.empty()) moves_ = std::move(reached);
  set_middle([&](const Stretch& move) {
    const double film = on_film(line, move.middle());
    return film >= 0 && film <= film_us();
  });
  return {line.offset + line.drift / (1 + line.drift) * (middle_ - before), span_ > 0 ? line.drift : 0};
}

FilmMatch::Sums FilmMatch::Sums::with(const FilmStep& step) const {
  const double length = step.length();
  return {w + length, e + length * step.energy, ee + length * step.energy * step.energy,
          independent + std::min(length / independent_us, 1.0)};
}

double FilmMatch::integral(double t) const {
  const double place = std::clamp(t / step_us_, 0.0, static_cast<double>(integrals_.size() - 1));
  const std::size_t i = std::min(static_cast<std::size_t>(place), integrals_.size() - 2);
  return integrals_[i] + (place - static_cast<double>(i)) * (integrals_[i + 1] - integrals_[i]);
}

/// The first step that begins at this time of the speed or later.
std::size_t FilmMatch::first_after(const FilmLine& line, double seen) const {
  const double film = on_film(line, seen);
  const auto begins_before = [film](const FilmStep& step) { return step.begin < film; };
  return static_cast<std::size_t>(std::partition_point(steps_.begin(), steps_.end(), begins_before) - steps_.begin());
}

bool FilmMatch::touches_gap(const FilmLine& line, const FilmStep& step) const {
  return std::any_of(gaps_.begin(), gaps_.end(), [&](const Stretch& gap) {
    return on_seen(line, step.end) > gap.begin && on_seen(line, step.begin) < gap.end;
  });
}

/// Those within the log; it may have gaps.
FilmMatch::StepRange FilmMatch::known_steps(const FilmLine& line) const {
  const std::size_t first = first_after(line, 0);
  std::size_t last = std::max(first, first_after(line, length_us()));
  while (last > first && on_seen(line, steps_[last - 1].end) > length_us()) --last;
  return {first, last};
}

FilmMatch::Sums FilmMatch::sums_of(const FilmLine& line, const StepRange& known) const {
  Sums sums = sums_[known.last].without(sums_[known.first]);
  for (const Stretch& gap : gaps_) {
    const std::size_t after = first_after(line, gap.begin);
    for (std::size_t i = std::max(known.first, after - std::min<std::size_t>(after, 1));
         i < known.last && on_seen(line, steps_[i].begin) < gap.end; ++i) {
      if (on_seen(line, steps_[i].end) > gap.begin) sums = sums.without(Sums{}.with(steps_[i]));
    }
  }
  return sums;
}

/// @param m  the motion's place in `moves`
void FilmMatch::add_move(const FilmLine& line, const StepRange& known, std::size_t m, MovingSums& sums) const {
  const Stretch& move = moves_[m];
  const double before = m == 0 ? 0 : 0.5 * (moves_[m - 1].end + move.begin);
  const double after = m + 1 == moves_.size() ? length_us() : 0.5 * (move.end + moves_[m + 1].begin);
  const double shorter = move.length() / std::max(move.length() + line.longer, 0.1 * move.length());
  const auto travelled = [&](double film) {
    const double seen = std::clamp(on_seen(line, film), before, after);
    return integral(std::clamp(move.middle() + (seen - move.middle()) * shorter, before, after));
  };
  const double reach = 0.5 * move.length() / shorter + 2 * frame_us_, until = std::min(move.middle() + reach, after);
  const std::size_t next = first_after(line, std::max(move.middle() - reach, before));
  for (std::size_t i = std::max(known.first, next - std::min<std::size_t>(next, 1));
       i < known.last && on_seen(line, steps_[i].begin) < until; ++i) {
    const FilmStep& step = steps_[i];
    if (!gaps_.empty() && touches_gap(line, step)) continue;
    const double length = step.length(), speed = (travelled(step.end) - travelled(step.begin)) / length;
    sums.v += length * speed;
    sums.vv += length * speed * speed;
    sums.ev += length * step.energy * speed;
    sums.us += std::min(length, independent_moving_us);
  }
}

FilmMatch::Explained FilmMatch::explained(const FilmLine& line) const {
  constexpr std::size_t fewest = 6;
  const StepRange known = known_steps(line);
  if (known.last - known.first < fewest) return {};
  const Sums film = sums_of(line, known);
  MovingSums arm;
  for (std::size_t m = 0; m < moves_.size(); ++m) add_move(line, known, m, arm);
  const double spread_e = film.w * film.ee - film.e * film.e, spread_v = film.w * arm.vv - arm.v * arm.v;
  const double both = film.w * arm.ev - film.e * arm.v;
  if (!(spread_e > 0) || !(spread_v > 0) || !(both > 0)) return {};
  return {.steps = film.independent,
          .moving = arm.us / independent_moving_us,
          .share = std::min(both * both / (spread_e * spread_v), 0.9999)};
}

double FilmMatch::log_likelihood(const FilmLine& line) const {
  const Explained by_motion = explained(line);
  return by_motion.log_likelihood(by_motion.steps);
}

double FilmMatch::log_prior(const FilmLine& line) const {
  const double z_longer = line.longer / usual_longer_us, z_drift = line.drift / usual_drift_;
  return -0.5 * (z_longer * z_longer + z_drift * z_drift);
}

}  // namespace tactile::alignment
