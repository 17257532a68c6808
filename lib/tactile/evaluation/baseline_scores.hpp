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
#include "tactile/model/inference/boosted_trees.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/model/inference/temporal_network.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::evaluation {

/// Balanced samples as the baselines see them: number of events, features of the heatmap, and features of the events.
struct BaselineSamples {
  std::vector<Touch> truth;
  std::vector<std::uint64_t> events;
  std::vector<Features> moments, fields;
  std::vector<float> features{};  ///< `features::feature_count` of each sample; none if there is no `feature_bin`
  std::vector<float> steps{};     ///< `features::step_values` of each sample; none if the history is too short for them

  void add(Touch touch, std::uint64_t events_in_window, std::span<const std::uint8_t> heatmap, events::SensorSize size) {
    truth.push_back(touch);
    events.push_back(events_in_window);
    moments.push_back(moments_of(heatmap, size));
    fields.push_back(shares_of_fields(heatmap, size));
  }
};

/// Adds the features of all samples of a run, which `add` has added in their order.
/// @throws Error  if the dataset cannot be read
void add_features(BaselineSamples& samples, const windows::Dataset& dataset, const model::Classifier& classifier,
                  std::uint32_t run);

/// Adds all samples of a run, with their features. @throws Error  if the dataset cannot be read
void add_samples(BaselineSamples& samples, const windows::Dataset& dataset, const model::Classifier& classifier,
                 std::uint32_t run, unsigned threads);

/// The samples that the model learned from directly, with no other model between; none where the dataset has none of these runs.
/// @throws Error  if the dataset cannot be read
BaselineSamples training_samples(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads,
                                 const ProgressCallback& progress = {});

inline constexpr std::array baseline_names{"majority",          "event_count",   "logistic_moments",
                                           "logistic_position", "boosted_trees", "temporal_convolution"};

/// The predictions of each baseline on the samples of one run; nothing of one that cannot read the samples.
using BaselineConfusions = std::array<std::optional<results::Confusion>, baseline_names.size()>;

/// Every baseline, fitted on the samples that a model learned from.
class FittedBaselines {
 public:
  /// Without samples there are no baselines.
  FittedBaselines(const BaselineSamples& training, std::uint64_t seed);

  BaselineConfusions confusions_of(const BaselineSamples& run) const;

 private:
  struct Fitted {
    MajorityBaseline majority;
    EventCountBaseline event_count;
    LogisticBaseline moments, fields;
    std::optional<model::BoostedTrees> trees;
    std::optional<model::TemporalNetwork> temporal;
  };
  std::optional<Fitted> fitted_;
};

/// The scores of the baselines that predicted every run.
/// @param confusions  one entry for each of `runs`
std::vector<results::BaselineScore> baseline_scores(std::span<const BaselineConfusions> confusions,
                                                    std::span<const results::JudgedRun> runs,
                                                    const results::BootstrapOptions& bootstrap);

}  // namespace tactile::evaluation
