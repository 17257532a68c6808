#include "tactile/model/classifier.hpp"

#include <algorithm>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/model/lenet.hpp"

namespace tactile {

namespace {

/// Engines for as many threads as come at once: each takes one and gives it back.
class Engines {
 public:
  explicit Engines(LeNetEngine first) { idle_.push_back(std::move(first)); }

  std::vector<Logits> logits(std::span<const std::uint8_t> heatmaps, SensorSize size, unsigned threads) {
    const std::size_t cells = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    if (heatmaps.size() % cells != 0) {
      throw Error("heatmaps: " + std::to_string(heatmaps.size()) + " bytes; expected a whole number of heatmaps of " +
                  std::to_string(size.width) + " x " + std::to_string(size.height) + " cells");
    }
    constexpr std::size_t share = 32;  // heatmaps that a thread takes at once
    std::vector<Logits> logits(heatmaps.size() / cells);
    parallel_for((logits.size() + share - 1) / share, threads, [&](std::size_t i) {
      LeNetEngine engine = take();
      for (std::size_t k = i * share; k < std::min((i + 1) * share, logits.size()); ++k)
        logits[k] = engine.classify(heatmaps.subspan(k * cells, cells));
      give_back(std::move(engine));
    });
    return logits;
  }

 private:
  /// The last idle one is copied, not taken: there is always one to copy.
  LeNetEngine take() {
    const std::scoped_lock lock(guard_);
    if (idle_.size() == 1) return idle_.front();
    LeNetEngine engine = std::move(idle_.back());
    idle_.pop_back();
    return engine;
  }

  void give_back(LeNetEngine engine) {
    const std::scoped_lock lock(guard_);
    idle_.push_back(std::move(engine));
  }

  std::mutex guard_;
  std::vector<LeNetEngine> idle_;
};

}  // namespace

struct Classifier::State {
  ModelBundle bundle;
  nlohmann::json json;
  ModelDescription description;
  unsigned threads = 1;
  std::optional<LeNet> network;  // one of the two
  std::unique_ptr<Engines> engines;
};

Classifier::Classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine, const EngineOptions& options) {
  const ModelBundle files{bundle.filename().empty() ? bundle.parent_path() : bundle};
  const ModelDescription description = read_description(files);
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  const Weights weights = read_bundle_weights(files, description);
  state_ = std::make_unique<State>(State{files, read_json(files.description()), description, threads, {}, nullptr});
  if (engine == EngineKind::libtorch) {
    state_->network.emplace(description.input, weights, description.settings.network);
    return;
  }
  try {
    state_->engines = std::make_unique<Engines>(LeNetEngine(description.input, weights, description.settings.network, options));
  } catch (const Error& e) {
    throw Error(files.folder.string() + ": " + e.what());
  }
}

Classifier::~Classifier() = default;
Classifier::Classifier(Classifier&&) noexcept = default;
Classifier& Classifier::operator=(Classifier&&) noexcept = default;

const std::filesystem::path& Classifier::bundle() const { return state_->bundle.folder; }
const nlohmann::json& Classifier::description() const { return state_->json; }
const ModelDescription& Classifier::model() const { return state_->description; }
const HeatmapOptions& Classifier::rendering() const { return state_->description.settings.rendering; }
SensorSize Classifier::input_size() const { return state_->description.input; }
EngineKind Classifier::engine() const { return state_->network ? EngineKind::libtorch : EngineKind::fast; }

std::vector<Logits> Classifier::classify(std::span<const std::uint8_t> heatmaps) const {
  return classify(heatmaps, state_->threads);
}

std::vector<Logits> Classifier::classify(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  try {
    return state_->network ? state_->network->logits(heatmaps, threads)
                           : state_->engines->logits(heatmaps, state_->description.input, threads);
  } catch (const Error& e) {
    throw Error(bundle().string() + ": " + e.what());
  }
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
