#include "tactile/model/training/sample_logits.hpp"

#include "tactile/model/training/follow_samples.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::model {

std::vector<Logits> sample_logits(const windows::Dataset& dataset, const Classifier& classifier,
                                  std::span<const std::uint32_t> samples, unsigned threads) {
  if (reads_heatmaps(classifier.kind()))
    return classifier.classify(sample_heatmaps(dataset, classifier.rendering(), samples, threads), threads);
  std::vector<Logits> logits;
  for_runs_of(dataset, samples, [&](std::uint32_t run, std::span<const std::uint32_t> of_run) {
    const auto model = classifier.on_events(dataset.sensor(), classifier.rendering());
    follow_samples(
        dataset, run, of_run, [&](std::span<const events::Event> events) { model->add(events); },
        [&](CameraTime t) {
          model->move_to(t);
          model->prepare();
          logits.push_back(model->classify());
        });
  });
  return logits;
}

}  // namespace tactile::model
