#include "tactile/model/inference/classifier.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/model/definition/model_network.hpp"
#include "tactile/model/inference/own_classifier.hpp"
#include "tactile/model/inference/stream_classifier.hpp"

namespace tactile::model {

namespace {

/// Engines for concurrent threads: each thread takes one and returns it.
class Engines {
 public:
  explicit Engines(LeNetEngine first) { idle_.push_back(std::move(first)); }

  std::vector<Logits> logits(std::span<const std::uint8_t> heatmaps, events::SensorSize size, unsigned threads) {
    constexpr std::size_t share = 32;  // heatmaps per piece of work
    std::vector<Logits> logits(heatmap_count(heatmaps, size));
    const std::size_t cells = logits.empty() ? 0 : heatmaps.size() / logits.size();
    parallel_for((logits.size() + share - 1) / share, threads, [&](std::size_t i) {
      LeNetEngine engine = take();
      for (std::size_t k = i * share; k < std::min((i + 1) * share, logits.size()); ++k)
        logits[k] = engine.classify(heatmaps.subspan(k * cells, cells));
      give_back(std::move(engine));
    });
    return logits;
  }

 private:
  /// Copies the last idle engine instead of taking it, so there is always one to copy.
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

Classifier::Classifier(const std::filesystem::path& bundle, unsigned threads, const EngineOptions& options)
    : Classifier(bundle, threads, EngineKind::fast, [&](const ModelDescription& model, const Weights& weights) -> HeatmapNetwork {
        const LeNetEngine first(model.input, weights, model.settings.network, options);
        const auto engines = std::make_shared<Engines>(first);
        return {[engines, size = model.input](std::span<const std::uint8_t> heatmaps, unsigned on_threads) {
                  return engines->logits(heatmaps, size, on_threads);
                },
                [first]() -> ClassifyHeatmap {
                  return [engine = first](std::span<const std::uint8_t> heatmap) mutable { return engine.classify(heatmap); };
                }};
      }) {
  if (reads_heatmaps(kind()) || options.precision == Precision::fp32) return;
  throw Error(fmt::format("{}: a model of kind {} has no precision {}; expected fp32", bundle_.folder.string(), name_of(kind()),
                          name_of(options.precision)));
}

Classifier::Classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
                       const std::function<HeatmapNetwork(const ModelDescription&, const Weights&)>& make_network)
    : bundle_{bundle.filename().empty() ? bundle.parent_path() : bundle},
      description_(read_description(bundle_)),
      temperature_(read_temperature(bundle_, description_)),
      threads_(threads_or_all(threads)),
      engine_(engine) {
  if (kind() == ModelKind::own)
    throw Error(bundle_.folder.string() + ": a network of one's own; expected a model's folder, or the program 'tactile'");
  const Weights weights = read_bundle_weights(bundle_, description_);
  json_ = read_json(bundle_.description());
  try {
    if (reads_heatmaps(kind())) {
      network_ = make_network(description_, weights);
      return;
    }
    if (engine == EngineKind::libtorch)
      throw Error(fmt::format("a model of kind {} runs without libtorch; expected --engine fast", name_of(kind())));
    stream_ = std::make_shared<const StreamNetwork>(weights);
  } catch (const Error& e) {
    throw Error(bundle_.folder.string() + ": " + e.what());
  }
}

Classifier::Classifier(const std::filesystem::path& file, EngineKind engine,
                       const std::function<OpenOwnNetwork(const NetworkPorts&)>& open)
    : bundle_{file},
      description_(read_description(bundle_)),
      temperature_(read_temperature(bundle_, description_)),
      threads_(1),
      engine_(engine),
      open_own_(open(ports_of(*description_.own))) {
  json_ = read_json(own_description_file(file));
  OwnTicks(file.string(), ports_of(*description_.own), open_own_()).advance();  // reports a network that does not suit
  try {
    on_events(description_.input, rendering());  // reports a grid outside the sensor
  } catch (const Error& e) {
    throw Error(own_description_file(file).string() + ": " + e.what());
  }
}

std::unique_ptr<EventClassifier> Classifier::on_events(events::SensorSize sensor,
                                                       const heatmaps::HeatmapOptions& rendering) const {
  if (const events::SensorSize input = input_of(description_.settings, sensor); input != input_size()) {
    throw Error(fmt::format("the sensor gives {}; expected the {} that {} was trained on", input_text(kind(), input),
                            input_text(kind(), input_size()), bundle().string()));
  }
  if (reads_heatmaps(kind())) return std::make_unique<HeatmapClassifier>(sensor, rendering, network_.for_one_thread());
  if (kind() == ModelKind::own) return own_classifier(bundle().string(), *description_.own, sensor, rendering, open_own_());
  const microseconds own = this->rendering().tick;
  if (rendering.tick != own)
    throw Error(fmt::format("a tick of {} us; expected the {} us by which {} counts", rendering.tick.count(), own.count(),
                            bundle().string()));
  return std::make_unique<StreamClassifier>(sensor, own, rendering.mask, stream_);
}

std::vector<Logits> Classifier::classify(std::span<const std::uint8_t> heatmaps) const { return classify(heatmaps, threads_); }

std::vector<Logits> Classifier::classify(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  try {
    if (!network_.classify) throw Error("reads no heatmaps; expected a model that does");
    return network_.classify(heatmaps, threads);
  } catch (const Error& e) {
    throw Error(bundle().string() + ": " + e.what());
  }
}

std::vector<Touch> Classifier::verdicts(std::span<const std::uint8_t> heatmaps) const { return verdicts(heatmaps, threads_); }

std::vector<Touch> Classifier::verdicts(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  const auto logits = classify(heatmaps, threads);
  std::vector<Touch> verdicts(logits.size());
  std::transform(logits.begin(), logits.end(), verdicts.begin(), verdict_of);
  return verdicts;
}

std::vector<Probabilities> Classifier::probabilities(std::span<const std::uint8_t> heatmaps) const {
  const auto logits = classify(heatmaps);
  std::vector<Probabilities> probabilities(logits.size());
  std::transform(logits.begin(), logits.end(), probabilities.begin(),
                 [this](const Logits& of) { return probabilities_of(of, temperature_.value); });
  return probabilities;
}

}  // namespace tactile::model
