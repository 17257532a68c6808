// Predicts what the skin feels, at every tick of a recording.
//   predict RECORDING MODEL        e.g. predict data/fan/02/events.aedat4 models/th40-single-1
// Prints CSV: the tick [us], the predicted class, and the probabilities of none, press and slip.
#include <exception>
#include <iostream>
#include <span>

#include "tactile/events/recording_reader.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/model/inference/classifier.hpp"

namespace {

void predict(const char* file, const char* bundle) {
  namespace model = tactile::model;
  tactile::events::RecordingReader recording(file);
  const tactile::events::Stream& stream = tactile::events::event_stream(recording);
  const model::Classifier classifier(bundle, 1);
  const auto& rendering = classifier.rendering();
  const auto predictor = classifier.on_events(stream.size.value(), rendering);

  std::cout << "t_us,predicted,p_none,p_press,p_slip\n";
  const auto print_tick = [&](tactile::CameraTime tick) {
    predictor->move_to(tick);
    predictor->prepare();
    const model::Logits logits = predictor->classify();
    const model::Probabilities p = model::probabilities_of(logits, classifier.temperature().value);
    std::cout << tick.time_since_epoch().count() << ',' << name_of(model::verdict_of(logits)) << ',' << p[0] << ',' << p[1] << ','
              << p[2] << '\n';
  };
  const auto add = [&](std::span<const tactile::events::Event> events) { predictor->add(events); };
  follow_ticks(recording, stream.id, rendering.history, rendering.tick, {add, print_tick});
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: predict RECORDING MODEL\n";
    return 2;
  }
  try {
    predict(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::cerr << "predict: " << error.what() << '\n';
    return 1;
  }
}
