#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/detection.hpp"
#include "tactile/results/judged_run.hpp"
#include "tactile/results/label_sensitivity.hpp"

namespace tactile::evaluation {

inline constexpr std::size_t label_draws = 200;

/// The run's labels that are in use, with each onset and end drawn from its own 95 % interval:
///
///   at + z (high - at) / 1.96 for z >= 0, at + z (at - low) / 1.96 for z < 0,   z normal
///
/// No interval begins before the one ahead of it ends, or ends before it begins.
std::vector<TouchInterval> drawn_labels(const RunTruth& truth, Random& random);

/// What the figures need of a detection by a draw of the labels, in 8 bytes: 200 draws of every run are kept.
struct DrawnDetection {
  explicit DrawnDetection(const results::Detection& detection);

  std::uint64_t us : 56;  ///< the delay; of a missed one: how long after its onset it could be detected
  std::uint64_t touch : 4;
  std::uint64_t outcome : 3;  ///< a DetectionOutcome
  std::uint64_t ahead : 1;
};
static_assert(sizeof(DrawnDetection) == 8);

/// A run scored by each draw of its labels. Without a draw it has none of these.
struct DrawnLabelsScores {
  std::uint32_t samples = 0;                 ///< balanced ones: each has the class of its tick by the drawn labels
  std::vector<std::uint32_t> correct{};      ///< of the samples, by each draw
  std::vector<DrawnDetection> detections{};  ///< of every label in use by the first draw, then by the second, and so on

  bool empty() const { return correct.empty(); }
  std::span<const DrawnDetection> detections_by(std::size_t draw) const;
};

/// A run scored by its labels as they are.
struct LabelledScore {
  results::Confusion confusion;
  std::vector<results::Detection> detections;
};

/// @param verdicts  one for each tick
/// @param samples   ticks of the balanced samples, by index
/// @param seed      the same for a run's labels, whichever training is scored
/// @return  by `label_draws` draws; by none where no label has an interval
DrawnLabelsScores scores_by_drawn_labels(const TickRange& ticks, std::span<const Touch> verdicts,
                                         std::span<const std::size_t> samples, const RunTruth& truth, const DelayOptions& options,
                                         std::uint64_t seed);

/// One run with its labels as they are, and drawn.
struct RunByDrawnLabels : results::JudgedRun {
  LabelledScore as_labelled{};
  DrawnLabelsScores drawn{};
};

/// The spread of accuracy and delays. The spread of the draws is added to the interval of the figure: root of the sum of squares.
results::LabelUncertainty label_uncertainty(std::span<const RunByDrawnLabels> runs,
                                            const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
