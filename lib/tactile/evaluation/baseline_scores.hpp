#pragma once

#include <array>
#include <atomic>
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

  void append(const BaselineSamples& more);
};

/// Adds the features of all samples of a run, which `add` has added in their order.
/// @throws Error  if the dataset cannot be read
void add_features(BaselineSamples& samples, const windows::Dataset& dataset, const model::Classifier& classifier,
                  std::uint32_t run);

/// All samples of a run, with their features. @throws Error  if the dataset cannot be read
BaselineSamples samples_of(const windows::Dataset& dataset, const model::Classifier& classifier, std::uint32_t run,
                           unsigned threads);

/// The samples that the model learned from directly, with no other model between; none where the dataset has none of these runs.
/// @throws Error  if the dataset cannot be read
BaselineSamples training_samples(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads,
                                 const ProgressCallback& progress = {});

inline constexpr std::array baseline_names{"majority",          "event_count",   "logistic_moments",
                                           "logistic_position", "boosted_trees", "temporal_convolution"};

/// The predictions of each baseline on the samples of one run; nothing of one that cannot read the samples.
using BaselineConfusions = std::array<std::optional<results::Confusion>, baseline_names.size()>;

/// Every baseline, fitted on the samples that a model learned from. They are fitted in parts, which may run beside other work.
class FittedBaselines {
 public:
  static constexpr std::size_t parts = 3;

  /// Without samples there are no baselines.
  FittedBaselines(BaselineSamples training, std::uint64_t seed);

  /// Fits one part. Each part must be fitted once, on any thread. @throws Error  as the function that fits it
  void fit(std::size_t part);

  /// Whether all parts have been fitted.
  bool are_fitted() const { return fitted_ == parts; }
  /// @pre  all parts have been fitted
  BaselineConfusions confusions_of(const BaselineSamples& run) const;

 private:
  void fit_simple();
  void fit_trees();
  void fit_temporal();

  BaselineSamples training_;  ///< until all parts are fitted
  bool has_samples_;
  std::uint64_t seed_;
  MajorityBaseline majority_;
  EventCountBaseline event_count_;
  LogisticBaseline moments_, fields_;
  std::optional<model::BoostedTrees> trees_;
  std::optional<model::TemporalNetwork> temporal_;
  std::atomic<std::size_t> fitted_{0};
};

/// The scores of the baselines that predicted every run.
/// @param confusions  one entry for each of `runs`
std::vector<results::BaselineScore> baseline_scores(std::span<const BaselineConfusions> confusions,
                                                    std::span<const results::JudgedRun> runs,
                                                    const results::BootstrapOptions& bootstrap);

}  // namespace tactile::evaluation
