#include "tactile/labels/posterior/clock_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "tactile/core/random.hpp"
#include "tactile/labels/posterior/run_model_numbers.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds coarse_bin = 8ms;
constexpr std::int64_t longest_us = std::int64_t{12} * 3600 * 1'000'000;  // of a log or film
constexpr double negligible = 12, negligible_at_end = 7;                  // [nats] below the likeliest offset

/// The evidence of `together` bins each. @param width  values of a bin
std::vector<double> joined(std::span<const double> values, std::size_t width, std::size_t together) {
  const std::size_t bins = values.size() / width / together;
  std::vector<double> sums(bins * width, 0.0);
  for (std::size_t b = 0; b < bins * together; ++b) {
    for (std::size_t k = 0; k < width; ++k) sums[b / together * width + k] += values[b * width + k];
  }
  return sums;
}

/// In each bin, the share of paths in which the skin begins to move, but for releases, drawn without what the arm does.
std::vector<double> motions_begin(const RunStates& states, const BinLikelihoods& likelihoods) {
  constexpr std::size_t paths = 60;
  Random random(4);
  const std::vector<std::uint8_t> unknown(likelihoods.bins(), arm_unknown);
  std::vector<double> begin(likelihoods.bins(), 0.0);
  for (const Path& path : drawn_paths(states, filtered(states, likelihoods, unknown, true), unknown, paths, random)) {
    for (std::size_t b = 1; b < path.size(); ++b) {
      const Happening before = states.happening_of(path[b - 1]), now = states.happening_of(path[b]);
      if (now != before && has_motion(now) && now != Happening::release) begin[b] += 1.0 / paths;
    }
  }
  return begin;
}

/// A finer grid, within `around` of the likely offsets: of at most `most`, and at most a third of them within 100 ms or exactly
/// alike, since where the arm rests during the recording all offsets are, and they must not hide another possibility.
std::vector<std::int64_t> refined(std::vector<WeighedOffset> likely, std::int64_t around_us, std::int64_t step_us,
                                  std::size_t most, double less = negligible) {
  constexpr std::int64_t near_us = 100'000;
  std::stable_sort(likely.begin(), likely.end(),
                   [](const WeighedOffset& a, const WeighedOffset& b) { return a.log_weight > b.log_weight; });
  std::vector<WeighedOffset> chosen;
  std::vector<std::int64_t> finer;
  for (const WeighedOffset& one : likely) {
    if (chosen.size() == most || one.log_weight < likely.front().log_weight - less) break;
    const auto is_near = [&](const WeighedOffset& other) { return std::abs(other.us - one.us) <= near_us; };
    const auto is_alike = [&](const WeighedOffset& other) { return other.log_weight == one.log_weight; };
    if (3 * static_cast<std::size_t>(std::count_if(chosen.begin(), chosen.end(), is_near)) >= most) continue;
    if (3 * static_cast<std::size_t>(std::count_if(chosen.begin(), chosen.end(), is_alike)) >= most) continue;
    chosen.push_back(one);
    for (std::int64_t d = -around_us; d <= around_us; d += step_us) finer.push_back(one.us + d);
  }
  return ascending(std::move(finer));
}

}  // namespace

std::vector<std::int64_t> ascending(std::vector<std::int64_t> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

double log_sum(std::span<const double> logarithms) {
  const double most = logarithms.empty() ? 0 : *std::max_element(logarithms.begin(), logarithms.end());
  double sum = 0;
  for (const double one : logarithms) sum += std::exp(one - most);
  return most + std::log(sum);
}

void normalise(std::vector<WeighedOffset>& offsets) {
  std::vector<double> logarithms(offsets.size());
  std::transform(offsets.begin(), offsets.end(), logarithms.begin(), [](const WeighedOffset& one) { return one.log_weight; });
  const double all = log_sum(logarithms);
  for (WeighedOffset& one : offsets) one.log_weight -= all;
}

double log_density(std::span<const WeighedOffset> offsets, double us) {
  constexpr double width_us = 4'000, elsewhere = 0.05, possible_us = 6e6;
  double density = 0;
  for (const WeighedOffset& one : offsets) {
    const double z = (us - static_cast<double>(one.us)) / width_us;
    density += std::exp(one.log_weight - 0.5 * z * z);
  }
  density /= width_us * std::sqrt(2 * std::numbers::pi);
  return std::log((1 - elsewhere) * density + elsewhere / possible_us);
}

ClockOffsets::ClockOffsets(const alignment::RunSignals& signals, const PlaceCounts& counts, const RunStates& states,
                           const robot::RobotLog* piece)
    : signals_(signals),
      counts_(counts),
      states_(states),
      together_(static_cast<std::size_t>(std::max<std::int64_t>(1, coarse_bin / counts.bin))),
      coarse_states_(counts.bin * static_cast<std::int64_t>(together_), counts.several_runs),
      piece_(piece) {
  if (piece != nullptr) {
    const std::optional<alignment::ArmMotion> motion = alignment::arm_motion(*piece);
    if (motion) course_.emplace(*motion, signals.robot.size() == 1);
    if (motion && !signals.imu.empty()) imu_.emplace(signals.imu, *motion);
    if (imu_ && imu_->empty()) imu_.reset();
  } else if (signals.video && !signals.video->steps.empty()) {
    course_.emplace(*signals.video);
  }
  const auto is_absurd = [&] { return saturating_subtract(us_of(course_->end()), us_of(course_->begin())) > longest_us; };
  if (course_ && (!course_->moves_at_all() || is_absurd())) course_.reset();
}

std::vector<std::uint8_t> ClockOffsets::conditions_at(std::int64_t offset_us) const {
  return course_->conditions(counts_.begin, counts_.bin, counts_.bins(), offset_us);
}

/// Offsets that the log may have before its content is looked at.
std::pair<std::int64_t, std::int64_t> ClockOffsets::possible() const {
  constexpr std::int64_t recorders_apart_us = 3'000'000;
  const auto known =
      !course_->has_speed() ? std::nullopt : signals_.coarse_offsets[static_cast<std::size_t>(piece_ - signals_.robot.data())];
  if (known)
    return {saturating_subtract(known->offset_us, known->within.count()),
            saturating_add(known->offset_us, known->within.count())};
  const std::int64_t at_begin = saturating_subtract(us_of(signals_.rate.begin), us_of(course_->begin()));
  const std::int64_t longer =
      (us_of(course_->end()) - us_of(course_->begin())) - between(signals_.rate.begin, signals_.rate.last).count();
  // A log of hours, or a piece of a log, lies anywhere.
  return {saturating_subtract(at_begin, std::max(recorders_apart_us, longer + 1'000'000)),
          saturating_add(at_begin, std::max(recorders_apart_us, 1'000'000 - longer))};
}

std::vector<WeighedOffset> ClockOffsets::by_imu(const Offsets& offsets) const {
  std::vector<WeighedOffset> weighed(offsets.size());
  std::transform(offsets.begin(), offsets.end(), weighed.begin(), [this](std::int64_t us) {
    return WeighedOffset{us, imu_at(us)};
  });
  return weighed;
}

std::optional<std::int64_t> ClockOffsets::likeliest_by_imu() const {
  if (!imu_ || likely_.empty()) return std::nullopt;
  const auto likeliest = std::max_element(likely_.begin(), likely_.end(), [this](const WeighedOffset& a, const WeighedOffset& b) {
    return imu_at(a.us) < imu_at(b.us);
  });
  return likeliest->us;
}

std::vector<WeighedOffset> ClockOffsets::weighed(const Offsets& offsets, const BinLikelihoods& likelihoods,
                                                 const RunStates& states, microseconds bin) const {
  constexpr std::size_t at_once = 2048;  // offsets of a log of hours would take gigabytes
  std::vector<WeighedOffset> weighed = by_imu(offsets);
  const double counted = imu_ ? numbers::counted : 1;
  for (std::size_t first = 0; first < weighed.size(); first += at_once) {
    const auto some = std::span(weighed).subspan(first, std::min(at_once, weighed.size() - first));
    std::vector<std::vector<std::uint8_t>> conditions(some.size());
    std::transform(some.begin(), some.end(), conditions.begin(),
                   [&](const WeighedOffset& one) { return course_->conditions(counts_.begin, bin, likelihoods.bins(), one.us); });
    const std::vector<double> evidences = log_evidences(states, likelihoods, conditions);
    for (std::size_t i = 0; i < some.size(); ++i) {
      const double outside = course_->changes_outside(signals_.rate.begin, signals_.rate.last, some[i].us);
      some[i].log_weight += counted * evidences[i] + outside * std::log(numbers::changes_unrecorded);
    }
  }
  return weighed;
}

/// Of a log of hours, those offsets at which its motions begin where the skin begins to move. The others are not weighed.
ClockOffsets::Offsets ClockOffsets::most_promising(Offsets grid, const BinLikelihoods& coarse) const {
  constexpr std::size_t most = 400;
  constexpr double of_chance = 0.02;
  constexpr microseconds sooner = 40ms, later = 300ms;
  if (grid.size() <= 2 * most || !course_->has_speed()) return grid;
  std::vector<double> until = motions_begin(coarse_states_, coarse);
  std::partial_sum(until.begin(), until.end(), until.begin());
  until.insert(until.begin(), 0.0);
  const microseconds bin = counts_.bin * static_cast<std::int64_t>(together_);
  const auto count_before = [&](CameraTime t) {
    return until[static_cast<std::size_t>(std::clamp<std::int64_t>(between(counts_.begin, t) / bin, 0, std::ssize(until) - 1))];
  };
  std::vector<WeighedOffset> scored;
  scored.reserve(grid.size());
  for (const std::int64_t us : grid) {
    double score = imu_at(us);
    for (const alignment::CameraSpan& move : course_->moves_at(us))
      score += std::log(of_chance + count_before(after(move.begin, later)) - count_before(before(move.begin, sooner)));
    scored.push_back({us, score});
  }
  std::stable_sort(scored.begin(), scored.end(),
                   [](const WeighedOffset& a, const WeighedOffset& b) { return a.log_weight > b.log_weight; });
  grid.clear();
  for (std::size_t i = 0; i < most; ++i) grid.push_back(scored[i].us);
  return ascending(std::move(grid));
}

/// The IMU distinguishes offsets that lie between those of the grid.
std::vector<WeighedOffset> ClockOffsets::with_imu_between(const std::vector<WeighedOffset>& grid, std::int64_t step) const {
  std::vector<WeighedOffset> finer;
  for (const WeighedOffset& one : grid) {
    const double events = one.log_weight - imu_at(one.us);
    for (std::int64_t us = one.us - step / 2; us < one.us + step / 2; us += 8'000) finer.push_back({us, events + imu_at(us)});
  }
  return finer;
}

void ClockOffsets::search(std::span<const double> evidence, std::span<const double> pattern, bool is_last) {
  const BinLikelihoods coarse(joined(evidence, motion_levels.size(), together_),
                              pattern.empty() ? std::vector<double>() : joined(pattern, happenings, together_));
  const auto weighed_coarsely = [&](const Offsets& us) {
    return weighed(us, coarse, coarse_states_, counts_.bin * static_cast<std::int64_t>(together_));
  };
  std::vector<WeighedOffset> offsets = likely_;
  if (offsets.empty()) {
    const auto [low, high] = possible();
    Offsets grid;
    const std::int64_t step = std::min<std::int64_t>(32'000, std::max<std::int64_t>(8'000, (high - low) / 8));
    for (std::int64_t i = 0; i <= saturating_subtract(high, low) / step; ++i) grid.push_back(low + i * step);
    offsets = weighed_coarsely(most_promising(std::move(grid), coarse));
    if (imu_) offsets = with_imu_between(offsets, step);
    offsets = weighed_coarsely(refined(std::move(offsets), imu_ ? 8'000 : step - 8'000, 8'000, 15));
  } else {
    for (WeighedOffset& one : offsets) one.us = one.us / 8'000 * 8'000;
    offsets = weighed_coarsely(refined(std::move(offsets), 24'000, 8'000, 12));
  }
  likely_ = std::move(offsets);
  if (!is_last || together_ == 1) return;
  const auto fine = imu_ ? refined(by_imu(refined(std::move(likely_), 8'000, 1'000, 5)), 0, 1'000, 15)
                         : refined(std::move(likely_), 0, 8'000, 60, negligible_at_end);
  likely_ = weighed(fine, BinLikelihoods(evidence, pattern), states_, counts_.bin);
}

void ClockOffsets::consider(std::span<const WeighedOffset> prior, std::span<const double> evidence,
                            std::span<const double> pattern) {
  if (prior.empty() || !course_) return;
  const BinLikelihoods likelihoods(evidence, pattern);
  const std::int64_t step = imu_ ? 1'000 : 8'000;
  const auto on_grid = [&](std::int64_t us) { return likely_.front().us + (us - likely_.front().us) / step * step; };
  Offsets others;
  for (const WeighedOffset& one : prior) others.push_back(on_grid(one.us));
  others = ascending(std::move(others));
  std::erase_if(others, [&](std::int64_t us) {
    return std::any_of(likely_.begin(), likely_.end(), [us](const WeighedOffset& one) { return one.us == us; });
  });
  const std::vector<WeighedOffset> more = weighed(others, likelihoods, states_, counts_.bin);
  likely_.insert(likely_.end(), more.begin(), more.end());
  for (WeighedOffset& one : likely_) one.log_weight += log_density(prior, static_cast<double>(one.us));
  std::sort(likely_.begin(), likely_.end(), [](const WeighedOffset& a, const WeighedOffset& b) { return a.us < b.us; });
}

}  // namespace tactile::labels
