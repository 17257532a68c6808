#include "tactile/model/training/sample_logits.hpp"

#include <algorithm>

#include "tactile/model/training/train_model.hpp"

namespace tactile::model {
namespace {

/// The logits of samples of one run, of which the classifier sees the events as the dataset stores them.
void add_logits(const windows::Dataset& dataset, const Classifier& classifier, std::uint32_t run,
                std::span<const std::uint32_t> samples, std::vector<Logits>& logits) {
  const std::vector<events::Event> events = dataset.events(run);
  const auto model = classifier.on_events(dataset.sensor(), classifier.rendering());
  auto given = events.begin();
  for (const std::uint32_t sample : samples) {
    const CameraTime t = dataset.samples()[sample].t;
    const auto end = std::partition_point(given, events.end(), [t](const events::Event& event) { return event.t < t; });
    model->add(std::span(given, end));
    given = end;
    model->move_to(t);
    model->prepare();
    logits.push_back(model->classify());
  }
}

}  // namespace

std::vector<Logits> sample_logits(const windows::Dataset& dataset, const Classifier& classifier,
                                  std::span<const std::uint32_t> samples, unsigned threads) {
  if (reads_heatmaps(classifier.kind()))
    return classifier.classify(sample_heatmaps(dataset, classifier.rendering(), samples, threads), threads);
  std::vector<Logits> logits;
  while (!samples.empty()) {
    const std::uint32_t run = dataset.samples()[samples.front()].run_index;
    const auto next_run = std::find_if(samples.begin(), samples.end(),
                                       [&](std::uint32_t sample) { return dataset.samples()[sample].run_index != run; });
    const auto count = static_cast<std::size_t>(next_run - samples.begin());
    add_logits(dataset, classifier, run, samples.first(count), logits);
    samples = samples.subspan(count);
  }
  return logits;
}

}  // namespace tactile::model
