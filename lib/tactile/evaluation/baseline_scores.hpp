#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/evaluation/baselines.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::evaluation {

/// Balanced samples as the baselines see them: number of events, and features of the heatmap.
struct BaselineSamples {
  std::vector<Touch> truth;
  std::vector<std::uint64_t> events;
  std::vector<Features> moments;

  void add(Touch touch, std::uint64_t events_in_window, std::span<const std::uint8_t> heatmap, events::SensorSize size) {
    truth.push_back(touch);
    events.push_back(events_in_window);
    moments.push_back(moments_of(heatmap, size));
  }

  void append(const BaselineSamples& more);
};

/// All samples of a run. @throws Error  if the dataset cannot be read
BaselineSamples samples_of(const windows::Dataset& dataset, const model::Classifier& classifier, std::uint32_t run,
                           unsigned threads);

/// The samples that the model learned from directly, with no other model between; none where the dataset has none of these runs.
/// @throws Error  if the dataset cannot be read
BaselineSamples training_samples(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads,
                                 const ProgressCallback& progress = {});

inline constexpr std::array baseline_names{"majority", "event_count", "logistic_moments"};

/// The predictions of each baseline on the samples of one run.
using BaselineConfusions = std::array<results::Confusion, baseline_names.size()>;

/// Every baseline, fitted on the samples that a model learned from.
class FittedBaselines {
 public:
  /// @throws Error  if there is no sample
  explicit FittedBaselines(const BaselineSamples& training);

  BaselineConfusions confusions_of(const BaselineSamples& run) const;

 private:
  MajorityBaseline majority_;
  EventCountBaseline event_count_;
  LogisticBaseline moments_;
};

/// The scores of the baselines; none if a run has no predictions.
/// @param confusions  one entry for each of `runs`
std::vector<results::BaselineScore> baseline_scores(std::span<const std::optional<BaselineConfusions>> confusions,
                                                    std::span<const results::JudgedRun> runs,
                                                    const results::BootstrapOptions& bootstrap);

}  // namespace tactile::evaluation
