#include "tactile/evaluation/baselines.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::evaluation {
namespace {

/// Scores that one threshold separates have no greatest likelihood; with this they have.
constexpr double ridge = 1e-6;

double probability_of(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

/// The loss of a rule, and its Newton step.
struct Step {
  double loss = 0, slope = 0, offset = 0;
};

Step step_at(const LogOddsOfScore& rule, std::span<const double> scores, const std::vector<bool>& is_touch) {
  double loss = 0, by_slope = 0, by_offset = 0, ss = 0, so = 0, oo = 0;
  const double share = 1 / static_cast<double>(scores.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const double log_odds = rule.of(scores[i]), p = probability_of(log_odds);
    loss += std::log1p(std::exp(-std::abs(log_odds))) + std::max(0.0, is_touch[i] ? -log_odds : log_odds);
    const double wrong = p - (is_touch[i] ? 1 : 0), weight = p * (1 - p);
    by_slope += wrong * scores[i], by_offset += wrong;
    ss += weight * scores[i] * scores[i], so += weight * scores[i], oo += weight;
  }
  by_slope = by_slope * share + ridge * rule.slope, by_offset = by_offset * share + ridge * rule.offset;
  ss = ss * share + ridge, so *= share, oo = oo * share + ridge;
  const double determinant = ss * oo - so * so;
  return {loss * share + ridge / 2 * (rule.slope * rule.slope + rule.offset * rule.offset),
          (oo * by_slope - so * by_offset) / determinant, (ss * by_offset - so * by_slope) / determinant};
}

/// Sums of the ticks before each, so that a window's sum is a difference.
class Windows {
 public:
  explicit Windows(std::span<const TickEvents> ticks) : sums_(ticks.size() + 1) {
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      const TickEvents& tick = ticks[k];
      const std::array<double, 6> of{
          static_cast<double>(tick.on), static_cast<double>(tick.off), tick.x, tick.y, tick.xx, tick.yy};
      for (std::size_t i = 0; i < of.size(); ++i) sums_[k + 1][i] = sums_[k][i] + of[i];
    }
  }

  /// on, off, x, y, xx, yy of the last `length` ticks up to `tick`
  std::array<double, 6> of(std::size_t tick, std::size_t length) const {
    const std::array<double, 6>& before = sums_[tick + 1 - std::min(length, tick + 1)];
    std::array<double, 6> sums = sums_[tick + 1];
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] -= before[i];
    return sums;
  }

 private:
  std::vector<std::array<double, 6>> sums_;
};

}  // namespace

std::vector<TickEvents> events_of_ticks(const std::filesystem::path& recording, const TickRange& ticks,
                                        const events::MaskPixels& mask) {
  events::RecordingReader reader(recording);
  const events::Stream& stream = events::event_stream(reader);
  if (!stream.size) throw Error(recording.string() + ": its event stream declares no size; expected that of its sensor");
  const float width = static_cast<float>(stream.size->width), height = static_cast<float>(stream.size->height);
  std::vector<TickEvents> all(static_cast<std::size_t>(std::max<std::int64_t>(ticks.count, 0)));
  if (all.empty()) return all;
  const CameraTime begin = before(ticks.first, ticks.tick);
  const events::PixelMask masked(*stream.size, mask, recording.string());
  events::for_all_events(reader, stream.id, [&](std::span<const events::Event> events) {
    for (const events::Event& event : events) {
      if (event.t < begin || masked.covers(event)) continue;
      const auto k = static_cast<std::size_t>(between(begin, event.t) / ticks.tick);
      if (k >= all.size()) continue;
      TickEvents& of = all[k];
      ++(event.on ? of.on : of.off);
      const float x = static_cast<float>(event.x) / width, y = static_cast<float>(event.y) / height;
      of.x += x, of.y += y, of.xx += x * x, of.yy += y * y;
    }
  });
  return all;
}

LogOddsOfScore fit_log_odds(std::span<const double> scores, const std::vector<bool>& is_touch) {
  constexpr int most_steps = 100;
  constexpr double small = 1e-9;
  LogOddsOfScore rule;
  if (scores.empty()) return rule;
  for (int i = 0; i < most_steps; ++i) {
    const Step step = step_at(rule, scores, is_touch);
    double share = 1;
    const auto moved = [&] { return LogOddsOfScore{rule.slope - share * step.slope, rule.offset - share * step.offset}; };
    while (share > small && !(step_at(moved(), scores, is_touch).loss <= step.loss)) share /= 2;
    if (share <= small) break;
    rule = moved();
    if (std::abs(step.slope) + std::abs(step.offset) < small) break;
  }
  return rule;
}

std::vector<double> event_rate_scores(std::span<const TickEvents> ticks, microseconds tick) {
  constexpr microseconds window{10'000};
  const Windows windows(ticks);
  const auto length = static_cast<std::size_t>(std::max<std::int64_t>(1, (window + tick / 2) / tick));
  std::vector<double> scores;
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const std::array<double, 6> sums = windows.of(k, length);
    scores.push_back(std::log1p(sums[0] + sums[1]));
  }
  return scores;
}

std::vector<double> cusum_scores(std::span<const TickEvents> ticks, double quiet) {
  std::vector<double> scores;
  double risen = 0, fallen = 0;
  for (const TickEvents& tick : ticks) {
    const double change = (static_cast<double>(tick.on) + static_cast<double>(tick.off)) * std::numbers::ln2 - quiet;
    risen = std::max(0.0, risen + change);
    fallen = std::max(0.0, fallen - change);
    if (fallen >= 3 * quiet) risen = fallen = 0;
    scores.push_back(std::log1p(risen));
  }
  return scores;
}

std::vector<Touch> nearest_classes(const Course& course, const TickRange& ticks) {
  std::vector<TouchInterval> touches = course.touches;
  if (course.lift_without_slip) touches.push_back({Touch::slip, *course.lift_without_slip, *course.lift_without_slip});
  std::vector<Touch> classes;
  for (std::int64_t k = 0; k < ticks.count; ++k) {
    const CameraTime t = ticks.at(k);
    const auto distance = [t](const TouchInterval& touch) {
      return std::max({between(t, touch.start), between(touch.end, t), microseconds{0}});
    };
    const auto nearest = std::min_element(touches.begin(), touches.end(), [&](const TouchInterval& a, const TouchInterval& b) {
      return distance(a) < distance(b);
    });
    classes.push_back(nearest == touches.end() ? Touch::slip : nearest->touch);
  }
  return classes;
}

std::vector<float> tick_features(std::span<const TickEvents> ticks) {
  const Windows windows(ticks);
  std::vector<float> features;
  features.reserve(ticks.size() * features_of_tick);
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    for (const std::size_t length : {1U, 5U, 20U}) {
      const auto [on, off, x, y, xx, yy] = windows.of(k, length);
      const double count = std::max(1.0, on + off), mean_x = x / count, mean_y = y / count;
      const auto spread = [](double square, double mean) { return std::sqrt(std::max(0.0, square - mean * mean)); };
      for (const double feature :
           {std::log1p(on), std::log1p(off), mean_x, mean_y, spread(xx / count, mean_x), spread(yy / count, mean_y)})
        features.push_back(static_cast<float>(feature));
    }
  }
  return features;
}

Baselines::Baselines(std::span<const LearnedRun> runs, microseconds tick) : tick_(tick) {
  std::vector<double> quiet;
  std::vector<float> features;
  std::vector<Touch> truth;
  for (const LearnedRun& run : runs) {
    const std::vector<float> of_run = tick_features(run.ticks);
    for (std::size_t k = 0; k < run.ticks.size(); ++k) {
      if (!run.truth[k]) continue;
      truth.push_back(*run.truth[k]);
      const auto of_tick = of_run.begin() + static_cast<std::ptrdiff_t>(k * features_of_tick);
      features.insert(features.end(), of_tick, of_tick + features_of_tick);
      if (truth.back() == Touch::none) quiet.push_back(run.ticks[k].on + run.ticks[k].off);
    }
  }
  if (quiet.empty() || truth.size() == quiet.size())
    throw Error("baselines: no tick of a touch, or none without; expected both in the runs to learn from");
  quiet_ = std::max(1.0, quantile(quiet, 0.5));
  for (std::size_t rule = 0; rule < rules_.size(); ++rule) {
    std::vector<double> sure;
    std::vector<bool> is_touch;
    for (const LearnedRun& run : runs) {
      const std::vector<double> of_run = scores(rule, run.ticks);
      for (std::size_t k = 0; k < of_run.size(); ++k) {
        if (run.truth[k]) sure.push_back(of_run[k]), is_touch.push_back(*run.truth[k] != Touch::none);
      }
    }
    rules_[rule] = fit_log_odds(sure, is_touch);
  }
  network_ = FeatureNetwork(features, features_of_tick, truth);
}

std::vector<double> Baselines::scores(std::size_t rule, std::span<const TickEvents> ticks) const {
  return rule == 0 ? event_rate_scores(ticks, tick_) : cusum_scores(ticks, quiet_);
}

std::vector<model::Probabilities> Baselines::predict(std::size_t baseline, std::span<const TickEvents> ticks,
                                                     std::span<const Touch> classes) const {
  if (baseline >= rules_.size()) return network_.predict(tick_features(ticks));
  std::vector<model::Probabilities> probabilities;
  const std::vector<double> of_rule = scores(baseline, ticks);
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const double log_odds = rules_[baseline].of(of_rule[k]);
    probabilities.push_back({static_cast<float>(probability_of(-log_odds)), 0, 0});
    probabilities.back()[static_cast<std::size_t>(classes[k])] = static_cast<float>(probability_of(log_odds));
  }
  return probabilities;
}

}  // namespace tactile::evaluation
