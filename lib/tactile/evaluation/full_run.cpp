#include "tactile/evaluation/full_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "tactile/core/error.hpp"
#include "tactile/core/infinite.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/model/definition/model_network.hpp"
#include "tactile/model/inference/background_ratio.hpp"

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
/// @param at  called with each tick and its number of events
void classify_heatmaps(events::RecordingReader& reader, const events::Stream& stream, const model::Classifier& classifier,
                       const heatmaps::HeatmapOptions& rendering, const FullRunOptions& options,
                       const heatmaps::ChangeEvents& change, const std::function<void(CameraTime, std::uint64_t)>& at,
                       results::FullRun& run) {
  Predictions predictions{classifier, run};
  std::vector<std::uint8_t> waiting;
  const auto classify_waiting = [&] {
    const auto logits = classifier.classify(waiting, options.threads);
    predictions.add(logits);
    waiting.clear();
    if (options.advance) options.advance(logits.size());
  };
  const auto use = [&](CameraTime t, std::span<const std::uint8_t> heatmap, std::uint64_t events) {
    if (options.see) options.see(t, heatmap, events);
    at(t, events);
    waiting.insert(waiting.end(), heatmap.begin(), heatmap.end());
    if (waiting.size() >= batch * heatmap.size()) classify_waiting();
  };
  run.ticks = heatmaps::for_every_tick(reader, stream.id, rendering, use, change);
  if (!waiting.empty()) classify_waiting();
}

/// Follows a recording with a model of any kind, tick by tick.
void classify_events(events::RecordingReader& reader, const events::Stream& stream, const model::Classifier& classifier,
                     model::EventClassifier& model, const heatmaps::HeatmapOptions& rendering, const FullRunOptions& options,
                     const heatmaps::ChangeEvents& change, const std::function<void(CameraTime, std::uint64_t)>& at,
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
    at(t, model.events());
    if (++waiting == batch) advance();
  };
  run.ticks = events::follow_ticks(reader, stream.id, rendering.history, rendering.tick,
                                   {[&](std::span<const events::Event> events) { model.add(events); }, classify}, change);
  if (waiting > 0) advance();
}

}  // namespace

bool needs_ratios(const std::optional<model::GateRule>& gate) { return gate && gate->ratio; }

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
  std::optional<model::BackgroundRatio> ratio;
  if (options.ratios) ratio.emplace(sensor, rendering.history, rendering.mask);
  const auto at = [&](CameraTime t, std::uint64_t events) {
    run.events.push_back(events);
    if (ratio) run.ratios.push_back(static_cast<float>(ratio->at(t)));
  };
  const heatmaps::ChangeEvents change_and_watch = [&](std::span<const events::Event> recorded, bool is_last) {
    const std::span<const events::Event> changed = options.change ? options.change(recorded, is_last) : recorded;
    ratio->add(changed);
    return changed;
  };
  const heatmaps::ChangeEvents& change = ratio ? change_and_watch : options.change;
  if (reads_heatmaps(classifier.kind())) {
    classify_heatmaps(reader, stream, classifier, rendering, options, change, at, run);
  } else {
    classify_events(reader, stream, classifier, *classifier.on_events(sensor, rendering), rendering, options, change, at, run);
  }
  return run;
}

std::vector<Touch> decided(const model::Decision& decision, const results::FullRun& run) {
  return model::decided(decision, run.ticks.tick, run.verdicts, run.probabilities);
}

std::uint64_t apply_gate(results::FullRun& run, const model::GateRule& rule) {
  if (rule.ratio && run.ratios.size() != run.events.size())
    throw Error(fmt::format("a run of {} ticks has {} ratios for its gate; expected one for each tick", run.events.size(),
                            run.ratios.size()));
  std::uint64_t gated = 0;
  for (std::size_t k = 0; k < run.events.size(); ++k) {
    if (!rule.closes(run.events[k], run.ratios.empty() ? infinite : static_cast<double>(run.ratios[k]))) continue;
    ++gated;
    run.verdicts[k] = Touch::none;
    if (!run.probabilities.empty()) run.probabilities[k] = {1, 0, 0};
  }
  return gated;
}

std::size_t expected_ticks(const std::filesystem::path& recording, const heatmaps::HeatmapOptions& options) {
  const events::RecordingReader reader(recording);
  return static_cast<std::size_t>(heatmaps::listed_ticks(reader, events::event_stream(reader).id, options).count);
}

}  // namespace tactile::evaluation
