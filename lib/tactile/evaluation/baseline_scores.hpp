#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/evaluation/baselines.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::evaluation {

/// Balanced samples as the baselines see them: number of events, and features of the heatmap.
struct BaselineSamples {
  std::vector<Touch> truth;
  std::vector<std::uint64_t> events;
  std::vector<Features> moments, fields;

  void add(Touch touch, std::uint64_t events_in_window, std::span<const std::uint8_t> heatmap, events::SensorSize size) {
    truth.push_back(touch);
    events.push_back(events_in_window);
    moments.push_back(moments_of(heatmap, size));
    fields.push_back(shares_of_fields(heatmap, size));
  }
};

/// The samples that the model learned from directly, with no other model between; none where the dataset has none of these runs.
/// @throws Error  if the dataset cannot be read
BaselineSamples training_samples(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads,
                                 const ProgressCallback& progress = {});

/// Fits every baseline on the training samples, and scores it on the samples of each test run.
/// @param tests    one entry for each run
/// @param objects  of each run
/// @return         empty where there is no training sample
std::vector<results::BaselineScore> baseline_scores(const BaselineSamples& training, std::span<const BaselineSamples> tests,
                                                    std::span<const std::string> objects,
                                                    const results::BootstrapOptions& bootstrap);

}  // namespace tactile::evaluation
