#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/feature_network.hpp"
#include "tactile/evaluation/run_judge.hpp"
#include "tactile/events/pixel_mask.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::evaluation {

// Detectors that others published, as far as they carry over to any skin: what a model has to beat. Each reads the events of
// ticks, learns from the runs that the model learned from, and is judged by the same code.

/// The events in [t_k - tick, t_k) of a tick.
struct TickEvents {
  std::uint32_t on = 0, off = 0;
  float x = 0, y = 0, xx = 0, yy = 0;  ///< sums of their positions in [0, 1], and of the squares
};

/// Of every tick of a recording. @param mask  pixels whose events do not count
/// @throws Error  if it cannot be read, its sensor has no size, or a pixel of the mask lies outside it
std::vector<TickEvents> events_of_ticks(const std::filesystem::path& recording, const TickRange& ticks,
                                        const events::MaskPixels& mask = {});

/// A rule on one number x of a tick. Its log-odds of a touch are slope x + offset, by logistic regression.
struct LogOddsOfScore {
  double slope = 0, offset = 0;

  double of(double score) const { return slope * score + offset; }
};

/// The regression with the least mean loss + 5e-7 (slope^2 + offset^2): finite for scores that one threshold separates.
/// @param is_touch  of each score
LogOddsOfScore fit_log_odds(std::span<const double> scores, const std::vector<bool>& is_touch);

/// ln(1 + n) of every tick, with n the events of the last 10 ms, rounded to whole ticks: a threshold on them detects slip.
/// Source: A. Rigi, F. Baghaei Naeini, D. Makris, Y. Zweiri, A novel event-based incipient slip detection using dynamic
/// active-pixel vision sensor (DAVIS), Sensors 18 (2018) 333.
std::vector<double> event_rate_scores(std::span<const TickEvents> ticks, microseconds tick);

/// ln(1 + S) of every tick, with S the cumulative sum for Poisson counts n whose mean doubles:
///
///   S = max(0, S + n ln 2 - quiet)
///
/// Page's sum starts again from 0 after an alarm. Here it does once the change is over. A second sum finds that: once
/// S' = max(0, S' + quiet - n ln 2) reaches 3 quiet, both are 0.
/// @param quiet  median number of events in a tick without a touch, > 0
/// Source: E. S. Page, Continuous inspection schemes, Biometrika 41 (1954) 100-115.
std::vector<double> cusum_scores(std::span<const TickEvents> ticks, double quiet);

/// Of every tick, and of the last 1, 5 and 20 ticks: logarithms of the counts of each polarity, centre and spread of the events.
/// A small network on such features of a few time steps detects slip.
/// Source: N. Funk, E. Helmut, G. Chalvatzaki, R. Calandra, J. Peters, Evetac: an event-based optical tactile sensor for robotic
/// manipulation, IEEE Transactions on Robotics 40 (2024); there the features also track the markers of its skin.
inline constexpr std::size_t features_of_tick = 18;
std::vector<float> tick_features(std::span<const TickEvents> ticks);  ///< [ticks, features_of_tick]

inline constexpr std::array baseline_names{"event_rate", "cusum", "features"};

/// What each tick would be if it were one of a touch: what the nearest touch is. A lift without slip stands for one of slip.
std::vector<Touch> nearest_classes(const Course& course, const TickRange& ticks);

/// A run to learn from.
struct LearnedRun {
  std::vector<TickEvents> ticks;
  std::vector<std::optional<Touch>> truth;  ///< of each tick; nothing where it is not sure
};

/// All of them, fitted to the same runs. The result is the same for any number of threads.
class Baselines {
 public:
  /// @throws Error  if there is no tick of a touch, or none without
  Baselines(std::span<const LearnedRun> runs, microseconds tick);

  /// What one of them predicts. Rules do not tell press from slip: each tick gets the class that is given.
  /// @param baseline  place in `baseline_names`   @param classes  press or slip, of each tick, as `nearest_classes`
  std::vector<model::Probabilities> predict(std::size_t baseline, std::span<const TickEvents> ticks,
                                            std::span<const Touch> classes) const;

 private:
  std::vector<double> scores(std::size_t rule, std::span<const TickEvents> ticks) const;

  microseconds tick_;
  double quiet_ = 0;
  std::array<LogOddsOfScore, 2> rules_{};
  FeatureNetwork network_;
};

}  // namespace tactile::evaluation
