#include "tactile/labels/posterior/run_inference.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/alignment/imu_motions.hpp"
#include "tactile/core/random.hpp"
#include "tactile/labels/posterior/press_pattern.hpp"
#include "tactile/labels/posterior/run_model_numbers.hpp"

namespace tactile::labels {
namespace {

constexpr std::size_t paths_of_round = 60, paths_at_end = 400;

/// Whether the camera moves in each bin, by its IMU; empty if it never does.
std::vector<std::uint8_t> felt_conditions(std::span<const events::ImuSample> imu, const PlaceCounts& counts) {
  constexpr microseconds within = 30ms;
  const std::vector<alignment::CameraSpan> felt = alignment::imu_motions(imu);
  if (felt.empty()) return {};
  std::vector<std::uint8_t> conditions(counts.bins(), arm_unknown);
  const auto fill = [&](CameraTime begin, CameraTime end, std::uint8_t condition) {
    const auto bin_of = [&](CameraTime t) {
      return std::clamp<std::ptrdiff_t>(between(counts.begin, t) / counts.bin, 0, std::ssize(conditions));
    };
    if (bin_of(begin) < bin_of(end)) std::fill(conditions.begin() + bin_of(begin), conditions.begin() + bin_of(end), condition);
  };
  fill(imu.front().t, imu.back().t, camera_still);
  for (const alignment::CameraSpan& move : felt) fill(before(move.begin, within), after(move.end, within), camera_moves);
  return conditions;
}

/// The pieces of the log, the longest first.
std::vector<const robot::RobotLog*> pieces_by_length(const alignment::RunSignals& signals) {
  std::vector<const robot::RobotLog*> pieces(signals.robot.size());
  std::transform(signals.robot.begin(), signals.robot.end(), pieces.begin(), [](const robot::RobotLog& piece) { return &piece; });
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const robot::RobotLog* a, const robot::RobotLog* b) { return a->states.size() > b->states.size(); });
  return pieces;
}

/// How many of `count` draws each offset gets, by its weight.
std::vector<std::size_t> draws_of(const std::vector<WeighedOffset>& offsets, std::size_t count, Random& random) {
  std::vector<WeighedOffset> normal = offsets;
  normalise(normal);
  std::vector<std::size_t> times(offsets.size(), 0);
  for (std::size_t i = 0; i < count; ++i) {
    double left = (static_cast<double>(i) + random.uniform()) / static_cast<double>(count);
    std::size_t k = 0;
    while (k + 1 < normal.size() && (left -= std::exp(normal[k].log_weight)) >= 0) ++k;
    ++times[k];
  }
  return times;
}

/// The offset of a clock, with the time that skin or IMU follow the arm by.
LikelyOffset offset_by(const std::vector<WeighedOffset>& offsets, bool has_imu) {
  Random random(3);
  std::vector<std::int64_t> sorted;
  const std::vector<std::size_t> times = draws_of(offsets, paths_at_end, random);
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    for (std::size_t i = 0; i < times[k]; ++i) {
      const double late_us = has_imu ? numbers::imu_lag_us * random.uniform() : numbers::arm_to_skin_us * random.normal();
      sorted.push_back(offsets[k].us - std::llround(late_us));
    }
  }
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) { return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]; };
  return {.median_us = at(0.5), .low_us = at(0.025) - 1000, .high_us = at(0.975) + 1000};
}

std::size_t index_of(const robot::RobotLog* piece, const alignment::RunSignals& signals) {
  return static_cast<std::size_t>(piece - signals.robot.data());
}

}  // namespace

RunInference::RunInference(const alignment::RunSignals& signals, PlaceCounts counts)
    : signals_(signals),
      counts_(std::move(counts)),
      states_(counts_.bin, counts_.several_runs),
      pieces_(pieces_by_length(signals)),
      rates_(first_rates(counts_)),
      evidence_(motion_evidence(counts_, rates_)),
      sample_{.states = &states_, .begin = counts_.begin, .bin = counts_.bin, .bins = counts_.bins()} {
  const auto add_clock = [&](const robot::RobotLog* piece) {
    auto clock = std::make_unique<ClockOffsets>(signals, counts_, states_, piece);
    if (clock->course()) clocks_.push_back(std::move(clock));
  };
  for (const robot::RobotLog* piece : pieces_) add_clock(piece);
  if (clocks_.empty()) {
    felt_ = felt_conditions(signals.imu, counts_);
    add_clock(nullptr);
  }
  constexpr int rounds = 2;
  for (int round = 0; round < rounds; ++round) {
    search(false);
    draw(paths_of_round);
    learn();
    evidence_ = motion_evidence(counts_, rates_);
  }
  consider_noise_alone();
  search(true);
}

/// Whether rates of noise by the whole recording explain it better. A drift of the noise may else be taken for a motion that
/// never ends, from whose beginning alone the rates are learned.
void RunInference::consider_noise_alone() {
  std::vector<double> always(counts_.bins());
  for (std::size_t b = 0; b < counts_.bins(); ++b) always[b] = counts_.is_recorded(b) ? 1 : 0;
  const std::vector<double> never(counts_.bins(), 0.0);
  const PlaceRates noise = rates_given(counts_, always, never);
  std::vector<double> evidence = motion_evidence(counts_, noise);
  const std::vector<std::uint8_t> unknown(counts_.bins(), arm_unknown);
  const auto explained = [&](const PlaceRates& rates, std::span<const double> of_level) {
    return log_likelihood_of_quiet(counts_, rates) + filtered(states_, BinLikelihoods(of_level, {}), unknown, false).log_evidence;
  };
  if (explained(noise, evidence) <= explained(rates_, evidence_)) return;
  rates_ = noise;
  evidence_ = std::move(evidence);
  pattern_.clear();
}

bool RunInference::longest_piece_moves() const {
  return !pieces_.empty() && !clocks_.empty() && clocks_.front()->piece() == pieces_.front();
}

OffsetsOfRun RunInference::robot_offsets() const {
  if (pieces_.empty()) return {};
  const robot::RobotLog& log = *pieces_.front();
  const RobotTime first = log.states.front().t, last = log.states.back().t;
  OffsetsOfRun run{.at = first + (last - first) / 2, .offsets = {}};
  if (!longest_piece_moves()) return run;
  run.offsets = clocks_.front()->likely();
  normalise(run.offsets);
  return run;
}

RunPosterior RunInference::posterior(std::span<const WeighedOffset> prior) {
  if (longest_piece_moves()) clocks_.front()->consider(prior, evidence_, pattern_);
  draw(paths_at_end);
  RunPosterior posterior{
      .touches = likely_touches(sample_), .releases = likely_releases(sample_), .robot = {}, .film = {}, .arm_moves = {}};
  if (clocks_.empty() || clocks_.front()->piece() == nullptr) {
    if (!clocks_.empty()) posterior.film = offset_by(clocks_.front()->likely(), false);
    // The arm rests, but commands are in its log.
    if (!pieces_.empty() && !prior.empty()) {
      posterior.robot.push_back(offset_by({prior.begin(), prior.end()}, false));
      posterior.robot.back().piece = index_of(pieces_.front(), signals_);
    }
    return posterior;
  }
  for (const std::unique_ptr<ClockOffsets>& clock : clocks_) {
    LikelyOffset offset = offset_by(clock->likely(), clock->has_imu());
    offset.piece = index_of(clock->piece(), signals_);
    offset.imu_us = clock->likeliest_by_imu();
    for (const alignment::CameraSpan& move : clock->course()->moves_at(offset.median_us))
      posterior.arm_moves.push_back({move, posterior.robot.size()});
    posterior.robot.push_back(offset);
  }
  return posterior;
}

void RunInference::search(bool is_last) {
  for (const std::unique_ptr<ClockOffsets>& clock : clocks_) clock->search(evidence_, pattern_, is_last);
}

/// What the arm does, if the first clock has this offset, and the others their likeliest.
std::vector<std::uint8_t> RunInference::conditions_at(std::int64_t offset_us) const {
  std::vector<std::uint8_t> conditions = clocks_.front()->conditions_at(offset_us);
  for (std::size_t i = 1; i < clocks_.size(); ++i) {
    const std::vector<WeighedOffset>& likely = clocks_[i]->likely();
    const auto likeliest = std::max_element(
        likely.begin(), likely.end(), [](const WeighedOffset& a, const WeighedOffset& b) { return a.log_weight < b.log_weight; });
    const std::vector<std::uint8_t> others = clocks_[i]->conditions_at(likeliest->us);
    for (std::size_t b = 0; b < conditions.size(); ++b) {
      if (conditions[b] == arm_unknown) conditions[b] = others[b];
    }
  }
  return conditions;
}

/// Draws paths from the posterior, with an offset of the clock each.
void RunInference::draw(std::size_t count) {
  Random random(1);
  const BinLikelihoods likelihoods(evidence_, pattern_);
  sample_.drawn.clear();
  const auto draw_from = [&](std::int64_t offset_us, std::vector<std::uint8_t> conditions, std::size_t times) {
    const Filtered kept = filtered(states_, likelihoods, conditions, true);
    std::vector<Path> paths = drawn_paths(states_, kept, conditions, times, random);
    sample_.drawn.push_back({offset_us, std::move(conditions), std::move(paths)});
  };
  if (!felt_.empty()) return draw_from(0, felt_, count);
  if (clocks_.empty()) return draw_from(0, std::vector<std::uint8_t>(counts_.bins(), arm_unknown), count);
  const std::vector<WeighedOffset>& offsets = clocks_.front()->likely();
  const std::vector<std::size_t> times = draws_of(offsets, count, random);
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    if (times[k] > 0) draw_from(offsets[k].us, conditions_at(offsets[k].us), times[k]);
  }
}

/// Rates of noise and motion, and the pattern of presses, from the drawn paths.
void RunInference::learn() {
  const double each = sample_.share_of_path();
  std::vector<double> quiet(counts_.bins(), 0.0), moves(counts_.bins(), 0.0), strong(counts_.bins(), 0.0);
  sample_.for_all_paths([&](const Path& path, const DrawnPaths& drawn) {
    for (std::size_t b = 0; b < path.size(); ++b) {
      if (!counts_.is_recorded(b)) continue;
      const std::size_t level = states_.level_of(path[b], drawn.conditions[b]);
      const Happening happening = states_.happening_of(path[b]);
      if (level == 0 && happening != Happening::slip) quiet[b] += each;
      if (level >= 3) strong[b] += each;
      if (level > 0 && happening != Happening::held && happening != Happening::carried) moves[b] += each;
    }
  });
  const auto needed = static_cast<double>(200ms / counts_.bin);
  if (std::accumulate(quiet.begin(), quiet.end(), 0.0) > needed) rates_ = rates_given(counts_, quiet, strong);
  constexpr double least = 0.3;
  const auto bin_of = [&](CameraTime t) {
    return std::min(counts_.bins(), static_cast<std::size_t>(std::max<std::int64_t>(0, between(counts_.begin, t) / counts_.bin)));
  };
  std::vector<PressBins> presses;
  for (const LikelyTouch& one : likely_touches(sample_)) {
    if (one.touch != Touch::press || one.probability <= least) continue;
    PressBins& press = presses.emplace_back(PressBins{bin_of(one.start.at), std::min(counts_.bins(), bin_of(one.end.at) + 1)});
    // A single run has the pattern of its first press. Of several runs, all presses count alike, however many events they have.
    if (!counts_.several_runs) break;
    const std::size_t events = counts_.signs_in(press.begin, press.end).size();
    press.probability = one.probability;
    press.weight = one.probability / static_cast<double>(std::max<std::size_t>(1, events));
  }
  constexpr std::size_t fewest = 3;  // so that the other presses give a pattern
  if (!presses.empty() && presses.size() < fewest) presses = {{presses.front().begin, presses.front().end}};
  pattern_ = presses.empty() ? std::vector<double>() : pattern_evidence(counts_, presses, moves);
}

}  // namespace tactile::labels
