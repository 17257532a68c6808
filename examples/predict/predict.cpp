// Predicts what the skin feels, at every tick of a recording.
//   predict RECORDING MODEL        e.g. predict data/fan/02/events.aedat4 models/th40-single-1
// Prints CSV: the tick [us], the predicted class, and the probabilities of none, press and slip.
#include <exception>
#include <iostream>
#include <span>
#include <stdexcept>

#include "tactile/events/recording_reader.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/model/inference/classifier.hpp"

int main(int argc, char** argv) try {
  namespace events = tactile::events;
  namespace model = tactile::model;
  if (argc != 3) throw std::invalid_argument("expected RECORDING MODEL");
  events::RecordingReader recording(argv[1]);
  const events::Stream& stream = events::event_stream(recording);
  const model::Classifier classifier(argv[2], 1);
  const auto& rendering = classifier.rendering();
  const auto predictor = classifier.on_events(stream.size.value(), rendering);

  std::cout << "t_us,predicted,p_none,p_press,p_slip\n";
  const auto add = [&](std::span<const events::Event> next) { predictor->add(next); };
  const auto print_tick = [&](tactile::CameraTime tick) {
    predictor->move_to(tick);
    predictor->prepare();
    const model::Logits logits = predictor->classify();
    std::cout << tick.time_since_epoch().count() << ',' << name_of(model::verdict_of(logits));
    for (const auto p : model::probabilities_of(logits, classifier.temperature().value)) std::cout << ',' << p;
    std::cout << '\n';
  };
  follow_ticks(recording, stream.id, rendering.history, rendering.tick, {add, print_tick});
} catch (const std::exception& error) {
  std::cerr << "predict: " << error.what() << '\n';
  return 1;
}
