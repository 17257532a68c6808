#include "tactile/evaluation/full_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "tactile/core/error.hpp"
#include "tactile/core/infinite.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/model/inference/background_ratio.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t batch = 256;  // heatmaps rendered before they are classified together

}  // namespace

results::FullRun classify_full_run(const std::filesystem::path& recording, const model::Classifier& classifier, unsigned threads,
                                   const std::function<void(std::size_t)>& advance, const heatmaps::TickCallback& see,
                                   std::optional<microseconds> tick, const heatmaps::ChangeEvents& change) {
  heatmaps::HeatmapOptions rendering = classifier.rendering();
  rendering.tick = tick.value_or(rendering.tick);
  events::RecordingReader reader(recording);
  const events::Stream& stream = events::event_stream(reader);
  const events::SensorSize size = stream.size ? heatmaps::heatmap_size(*stream.size, rendering.factor) : events::SensorSize{};
  const events::SensorSize expected = classifier.input_size();
  if (size != expected) {
    throw Error(fmt::format("{}: its heatmaps are {} x {} cells; expected the {} x {} that {} was trained on", recording.string(),
                            size.width, size.height, expected.width, expected.height, classifier.bundle().string()));
  }
  results::FullRun run;
  model::BackgroundRatio ratio(*stream.size, rendering.history, rendering.mask);
  std::vector<std::uint8_t> waiting;
  const auto classify_waiting = [&] {
    const auto logits = classifier.classify(waiting, threads);
    std::transform(logits.begin(), logits.end(), std::back_inserter(run.verdicts), model::verdict_of);
    std::transform(logits.begin(), logits.end(), std::back_inserter(run.probabilities),
                   [&](const model::Logits& of) { return model::probabilities_of(of, classifier.temperature().value); });
    run.close += static_cast<std::size_t>(std::count_if(logits.begin(), logits.end(), model::is_close));
    waiting.clear();
    if (advance) advance(logits.size());
  };
  const auto use = [&](CameraTime t, std::span<const std::uint8_t> heatmap, std::uint64_t events) {
    if (see) see(t, heatmap, events);
    run.events.push_back(events);
    run.ratios.push_back(static_cast<float>(ratio.at(t)));
    waiting.insert(waiting.end(), heatmap.begin(), heatmap.end());
    if (waiting.size() >= batch * heatmap.size()) classify_waiting();
  };
  const heatmaps::ChangeEvents change_and_watch = [&](std::span<const events::Event> recorded, bool is_last) {
    const std::span<const events::Event> changed = change ? change(recorded, is_last) : recorded;
    ratio.add(changed);
    return changed;
  };
  run.ticks = heatmaps::for_every_tick(reader, stream.id, rendering, use, change_and_watch);
  if (!waiting.empty()) classify_waiting();
  return run;
}

std::vector<Touch> decided(const model::Decision& decision, const results::FullRun& run) {
  return model::decided(decision, run.ticks.tick, run.verdicts, run.probabilities);
}

std::uint64_t apply_gate(results::FullRun& run, const model::GateRule& rule) {
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
