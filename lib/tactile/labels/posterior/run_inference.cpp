#include "tactile/labels/posterior/run_inference.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/random.hpp"
#include "tactile/labels/posterior/press_pattern.hpp"
#include "tactile/labels/posterior/run_model_numbers.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds fine_bin = 1000us;
constexpr std::size_t paths_of_round = 60, paths_at_end = 400;

PlaceCounts counts_in(const alignment::RunSignals& signals) {
  events::RecordingReader recording(signals.run.events());
  return place_counts(recording, signals.event_stream, signals.rate, fine_bin);
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

}  // namespace

RunInference::RunInference(const alignment::RunSignals& signals)
    : counts_(counts_in(signals)),
      states_(counts_.bin),
      clock_(signals, counts_, states_),
      rates_(first_rates(counts_)),
      evidence_(motion_evidence(counts_, rates_)),
      sample_{.states = &states_, .begin = counts_.begin, .bin = counts_.bin, .bins = counts_.bins()} {
  for (int round = 0; round < 2; ++round) {
    if (clock_.course()) clock_.search(evidence_, pattern_, false);
    draw(paths_of_round);
    learn();
    evidence_ = motion_evidence(counts_, rates_);
  }
  consider_noise_alone();
  if (clock_.course()) clock_.search(evidence_, pattern_, true);
}

/// Whether rates of noise by the whole recording explain it better. A drift of the noise may else be taken for a motion that
/// never ends, from whose beginning alone the rates are learned.
void RunInference::consider_noise_alone() {
  const std::vector<double> always(counts_.bins(), 1.0), never(counts_.bins(), 0.0);
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

RunPosterior RunInference::posterior(std::span<const WeighedOffset> prior) {
  clock_.consider(prior, evidence_, pattern_);
  draw(paths_at_end);
  RunPosterior posterior{
      .touches = likely_touches(sample_), .releases = likely_releases(sample_), .robot = {}, .film = {}, .arm_moves = {}};
  if (!clock_.course()) return posterior;
  const LikelyOffset found = offset();
  if (clock_.course()->is_of_film()) {
    posterior.film = found;
  } else {
    posterior.robot = found;
    posterior.arm_moves = clock_.course()->moves_at(found.median_us);
  }
  return posterior;
}

/// Draws paths from the posterior, with an offset of the clock each.
void RunInference::draw(std::size_t count) {
  Random random(1);
  const BinLikelihoods likelihoods(evidence_, pattern_);
  sample_.drawn.clear();
  const auto draw_from = [&](std::int64_t offset_us, std::vector<std::uint8_t> conditions, std::size_t times) {
    const Filtered kept = filtered(states_, likelihoods, conditions, true);
    DrawnPaths& drawn = sample_.drawn.emplace_back(DrawnPaths{offset_us, std::move(conditions), {}});
    for (std::size_t i = 0; i < times; ++i) drawn.paths.push_back(drawn_path(states_, kept, drawn.conditions, random));
  };
  if (!clock_.course()) return draw_from(0, std::vector<std::uint8_t>(counts_.bins(), arm_unknown), count);
  const std::vector<WeighedOffset>& offsets = clock_.likely();
  const std::vector<std::size_t> times = draws_of(offsets, count, random);
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    if (times[k] > 0) draw_from(offsets[k].us, clock_.conditions_at(offsets[k].us), times[k]);
  }
}

/// Rates of noise and motion, and the pattern of the first press, from the drawn paths.
void RunInference::learn() {
  const double each = sample_.share_of_path();
  std::vector<double> quiet(counts_.bins(), 0.0), moves(counts_.bins(), 0.0), strong(counts_.bins(), 0.0);
  sample_.for_all_paths([&](const Path& path, const DrawnPaths& drawn) {
    for (std::size_t b = 0; b < path.size(); ++b) {
      const std::size_t level = states_.level_of(path[b], drawn.conditions[b]);
      const Happening happening = states_.happening_of(path[b]);
      if (level == 0 && happening != Happening::slip) quiet[b] += each;
      if (level >= 3) strong[b] += each;
      if (level > 0 && happening != Happening::held && happening != Happening::carried) moves[b] += each;
    }
  });
  if (std::accumulate(quiet.begin(), quiet.end(), 0.0) > 200) rates_ = rates_given(counts_, quiet, strong);
  const std::vector<LikelyTouch> found = likely_touches(sample_);
  const auto press = std::find_if(found.begin(), found.end(),
                                  [](const LikelyTouch& one) { return one.touch == Touch::press && one.probability > 0.3; });
  if (press == found.end()) return;
  const auto bin_of = [&](CameraTime t) {
    return std::min(counts_.bins(), static_cast<std::size_t>(std::max<std::int64_t>(0, between(counts_.begin, t) / counts_.bin)));
  };
  pattern_ = pattern_evidence(counts_, bin_of(press->start.at), std::min(counts_.bins(), bin_of(press->end.at) + 1), moves);
}

LikelyOffset RunInference::offset() const {
  std::vector<std::int64_t> sorted;
  Random random(3);
  sample_.for_all_paths([&](const Path&, const DrawnPaths& drawn) {
    const double late_us = clock_.has_imu() ? numbers::imu_lag_us * random.uniform() : numbers::arm_to_skin_us * random.normal();
    sorted.push_back(drawn.offset_us - std::llround(late_us));
  });
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) { return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]; };
  const std::int64_t first_stamp_us =
      clock_.course()->is_of_film() ? us_of(clock_.course()->begin()) : us_of(clock_.piece()->log.states.front().t);
  return {at(0.5), at(0.025) - 1000, at(0.975) + 1000, first_stamp_us};
}

}  // namespace tactile::labels
