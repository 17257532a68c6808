#include "tactile/model/classifier.hpp"

#include <algorithm>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/model/lenet.hpp"

namespace tactile {

struct Classifier::State {
  ModelBundle bundle;
  nlohmann::json json;
  ModelDescription description;
  LeNet network;
  unsigned threads;
};

Classifier::Classifier(const std::filesystem::path& bundle, unsigned threads) {
  const ModelBundle files{bundle.filename().empty() ? bundle.parent_path() : bundle};
  const ModelDescription description = read_description(files);
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  state_ = std::make_unique<State>(
      State{files, read_json(files.description()), description,
            LeNet(description.input, read_bundle_weights(files, description), description.settings.network), threads});
}

Classifier::~Classifier() = default;
Classifier::Classifier(Classifier&&) noexcept = default;
Classifier& Classifier::operator=(Classifier&&) noexcept = default;

const std::filesystem::path& Classifier::bundle() const { return state_->bundle.folder; }
const nlohmann::json& Classifier::description() const { return state_->json; }
const ModelDescription& Classifier::model() const { return state_->description; }
const HeatmapOptions& Classifier::rendering() const { return state_->description.settings.rendering; }
SensorSize Classifier::input_size() const { return state_->description.input; }

std::vector<Logits> Classifier::classify(std::span<const std::uint8_t> heatmaps) const {
  return classify(heatmaps, state_->threads);
}

std::vector<Logits> Classifier::classify(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  return state_->network.logits(heatmaps, threads);
}

std::vector<Touch> Classifier::verdicts(std::span<const std::uint8_t> heatmaps) const {
  return verdicts(heatmaps, state_->threads);
}

std::vector<Touch> Classifier::verdicts(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  const auto logits = classify(heatmaps, threads);
  std::vector<Touch> verdicts(logits.size());
  std::transform(logits.begin(), logits.end(), verdicts.begin(), verdict_of);
  return verdicts;
}

std::vector<Probabilities> Classifier::probabilities(std::span<const std::uint8_t> heatmaps) const {
  const auto logits = classify(heatmaps);
  std::vector<Probabilities> probabilities(logits.size());
  std::transform(logits.begin(), logits.end(), probabilities.begin(), probabilities_of);
  return probabilities;
}

}  // namespace tactile
