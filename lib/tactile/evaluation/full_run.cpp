#include "tactile/evaluation/full_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/model/definition/model_network.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t batch = 256;  // ticks that are classified together

/// Collects what a model predicts of a run.
struct Predictions {
  const model::Classifier& classifier;
  results::FullRun& run;

  void add(std::span<const model::Logits> logits) {
    std::transform(logits.begin(), logits.end(), std::back_inserter(run.verdicts), model::verdict_of);
    std::transform(logits.begin(), logits.end(), std::back_inserter(run.probabilities),
                   [&](const model::Logits& of) { return model::probabilities_of(of, classifier.temperature().value); });
    run.close += static_cast<std::size_t>(std::count_if(logits.begin(), logits.end(), model::is_close));
  }
};

/// Follows a recording with a model that reads heatmaps.
void classify_heatmaps(events::RecordingReader& reader, const events::Stream& stream, const model::Classifier& classifier,
                       const heatmaps::HeatmapOptions& rendering, const FullRunOptions& options, results::FullRun& run) {
  Predictions predictions{classifier, run};
  std::vector<std::uint8_t> waiting;
  const auto classify_waiting = [&] {
    const auto logits = classifier.classify(waiting, options.threads);
    predictions.add(logits);
    waiting.clear();
    if (options.advance) options.advance(logits.size());
  };
  const auto use = [&](CameraTime, std::span<const std::uint8_t> heatmap, std::uint64_t events) {
    run.events.push_back(events);
    waiting.insert(waiting.end(), heatmap.begin(), heatmap.end());
    if (waiting.size() >= batch * heatmap.size()) classify_waiting();
  };
  run.ticks = heatmaps::for_every_tick(reader, stream.id, rendering, use, options.change);
  if (!waiting.empty()) classify_waiting();
}

/// Follows a recording with a model of any kind, tick by tick.
void classify_events(events::RecordingReader& reader, const events::Stream& stream, const model::Classifier& classifier,
                     model::EventClassifier& model, const heatmaps::HeatmapOptions& rendering, const FullRunOptions& options,
                     results::FullRun& run) {
  Predictions predictions{classifier, run};
  std::size_t waiting = 0;
  const auto advance = [&] {
    if (options.advance) options.advance(waiting);
    waiting = 0;
  };
  const auto classify = [&](CameraTime t) {
    model.move_to(t);
    model.prepare();
    const model::Logits logits = model.classify();
    predictions.add({&logits, 1});
    run.events.push_back(model.events());
    if (++waiting == batch) advance();
  };
  run.ticks = events::follow_ticks(reader, stream.id, rendering.history, rendering.tick,
                                   {[&](std::span<const events::Event> events) { model.add(events); }, classify}, options.change);
  if (waiting > 0) advance();
}

}  // namespace

results::FullRun classify_full_run(const std::filesystem::path& recording, const model::Classifier& classifier,
                                   const FullRunOptions& options) {
  heatmaps::HeatmapOptions rendering = classifier.rendering();
  rendering.tick = options.tick.value_or(rendering.tick);
  events::RecordingReader reader(recording);
  const events::Stream& stream = events::event_stream(reader);
  const events::SensorSize sensor = stream.size.value_or(events::SensorSize{});
  const events::SensorSize input = stream.size ? input_of(classifier.model().settings, sensor) : events::SensorSize{};
  if (input != classifier.input_size()) {
    throw Error(fmt::format("{}: gives {}; expected the {} that {} was trained on", recording.string(),
                            input_text(classifier.kind(), input), input_text(classifier.kind(), classifier.input_size()),
                            classifier.bundle().string()));
  }
  results::FullRun run;
  if (reads_heatmaps(classifier.kind())) {
    classify_heatmaps(reader, stream, classifier, rendering, options, run);
  } else {
    classify_events(reader, stream, classifier, *classifier.on_events(sensor, rendering), rendering, options, run);
  }
  return run;
}

std::vector<Touch> decided(const model::Decision& decision, const results::FullRun& run) {
  return model::decided(decision, run.ticks.tick, run.verdicts, run.probabilities);
}

std::size_t expected_ticks(const std::filesystem::path& recording, const heatmaps::HeatmapOptions& options) {
  const events::RecordingReader reader(recording);
  return static_cast<std::size_t>(heatmaps::listed_ticks(reader, events::event_stream(reader).id, options).count);
}

}  // namespace tactile::evaluation
