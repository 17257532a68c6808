#include "tactile/model/training/calibrate_model.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/sample_logits.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::model {
namespace {

std::vector<std::uint32_t> runs_to_fit_on(const windows::Dataset& dataset, const ModelDescription& model,
                                          std::span<const std::string> ids) {
  const auto& held_out = model.settings.split.held_out;
  const bool holds_out = model.settings.split.kind == windows::SplitKind::unseen;
  std::vector<std::uint32_t> runs;
  for (std::uint32_t i = 0; i < dataset.runs().size(); ++i) {
    const windows::DatasetRun& run = dataset.runs()[i];
    if (std::find(ids.begin(), ids.end(), run.run) == ids.end() || learned_from(model, run)) continue;
    if (holds_out && std::find(held_out.begin(), held_out.end(), run.object) != held_out.end()) continue;
    runs.push_back(i);
  }
  return runs;
}

}  // namespace

double loss_at(std::span<const Logits> logits, std::span<const Touch> truth, double temperature) {
  double sum = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) {
    // In logarithms: a probability that is 0 in float32 has a finite loss.
    const double largest = *std::max_element(logits[i].begin(), logits[i].end());
    double weights = 0;
    for (const float logit : logits[i]) weights += std::exp((static_cast<double>(logit) - largest) / temperature);
    sum += std::log(weights) - (static_cast<double>(logits[i][static_cast<std::size_t>(truth[i])]) - largest) / temperature;
  }
  return sum / static_cast<double>(logits.size());
}

double fitted_temperature(std::span<const Logits> logits, std::span<const Touch> truth) {
  // The loss is convex in 1 / temperature, and so has one minimum over its logarithm too.
  double low = std::log(1.0 / 20), high = std::log(20.0);
  for (int step = 0; step < 100; ++step) {
    const double third = (high - low) / 3, a = low + third, b = high - third;
    if (loss_at(logits, truth, std::exp(a)) < loss_at(logits, truth, std::exp(b))) {
      high = b;
    } else {
      low = a;
    }
  }
  return std::exp((low + high) / 2);
}

Temperature calibrate_model(const windows::Dataset& dataset, const ModelBundle& bundle, std::span<const std::string> runs,
                            unsigned threads) {
  const ModelDescription model = read_description(bundle);
  const std::vector<std::uint32_t> chosen = runs_to_fit_on(dataset, model, runs);
  const std::vector<std::uint32_t> samples = samples_of_runs(dataset, chosen);
  if (samples.empty()) {
    throw Error(fmt::format(
        "--calibrate {}: no such run of {} has samples that the model did not learn from; expected ids of other runs, such as 02",
        fmt::join(runs, ","), dataset.file().string()));
  }
  std::vector<std::uint32_t> left = test_runs_of(dataset, model);
  std::erase_if(left, [&](std::uint32_t run) { return std::find(chosen.begin(), chosen.end(), run) != chosen.end(); });
  if (samples_of_runs(dataset, left).empty()) {
    throw Error(fmt::format("--calibrate {}: no run is left to test {} on; expected fewer runs, or more recorded ones",
                            fmt::join(runs, ","), bundle.name()));
  }
  const EngineKind engine = model.settings.network.is_fast() ? EngineKind::fast : EngineKind::libtorch;
  std::filesystem::remove(temperature_file(bundle));  // one of other weights would be refused
  const Classifier classifier = open_classifier(bundle.folder, threads, engine);
  const std::vector<Logits> logits = sample_logits(dataset, classifier, samples, std::max(1U, threads));
  std::vector<Touch> truth;
  for (const std::uint32_t sample : samples) truth.push_back(dataset.samples()[sample].touch);
  Temperature temperature{.value = fitted_temperature(logits, truth),
                          .fitted_on = {},
                          .samples = samples.size(),
                          .loss_before = loss_at(logits, truth, 1),
                          .loss_after = 0,
                          .weights_sha256 = model.weights_sha256};
  temperature.loss_after = loss_at(logits, truth, temperature.value);
  for (const std::uint32_t run : chosen) temperature.fitted_on.push_back(learned_run_of(dataset.runs()[run]));
  write_temperature(bundle, temperature);
  return temperature;
}

}  // namespace tactile::model
