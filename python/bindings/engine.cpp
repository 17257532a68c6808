#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <mutex>

#include "arrays.hpp"
#include "interruption.hpp"
#include "recording.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "working_alone.hpp"

namespace tactile::python {
namespace {

using model::Classifier;
using model::Logits;

NumpyArray<float> array_of_logits(const std::vector<Logits>& logits) {
  std::vector<float> values;
  values.reserve(touch_count * logits.size());
  for (const Logits& of_one : logits) values.insert(values.end(), of_one.begin(), of_one.end());
  return array_of(std::move(values), {logits.size(), touch_count});
}

NumpyArray<float> classify(const Classifier& classifier, const GivenArray<std::uint8_t, 3>& heatmaps) {
  const events::SensorSize size = classifier.input_size();
  if (heatmaps.shape(1) != static_cast<std::size_t>(size.height) || heatmaps.shape(2) != static_cast<std::size_t>(size.width)) {
    throw Error(classifier.bundle().string() + ": heatmaps have " + std::to_string(heatmaps.shape(1)) + " rows of " +
                std::to_string(heatmaps.shape(2)) + "; expected " + std::to_string(size.height) + " rows of " +
                std::to_string(size.width));
  }
  const std::span<const std::uint8_t> values(heatmaps.data(), heatmaps.size());
  std::vector<Logits> logits;
  {
    const OtherThreadsRun other_threads_run;
    logits = classifier.classify(values);
  }
  return array_of_logits(logits);
}

NumpyArray<float> probabilities(const Classifier& classifier, const GivenArray<float, 2>& logits) {
  if (logits.shape(1) != touch_count) throw Error("logits: rows of " + std::to_string(logits.shape(1)) + "; expected rows of 3");
  std::vector<float> values;
  {
    const OtherThreadsRun other_threads_run;
    values.reserve(logits.size());
    for (std::size_t row = 0; row < logits.shape(0); ++row) {
      const float* const first = logits.data() + row * touch_count;
      const auto p = model::probabilities_of({first[0], first[1], first[2]}, classifier.temperature().value);
      values.insert(values.end(), p.begin(), p.end());
    }
  }
  return array_of(std::move(values), {logits.shape(0), touch_count});
}

/// Ticks, logits and numbers of events of a recording's full ticks.
nb::tuple predict(const Classifier& classifier, Recording& recording, double tick_ms) {
  heatmaps::HeatmapOptions rendering = classifier.rendering();
  if (tick_ms > 0) rendering.tick = microseconds(std::llround(1000 * tick_ms));
  check(rendering);
  if (!recording.stream.size)
    throw Error(recording.reader.file().string() + ": its event stream declares no size; expected one for predictions");
  std::vector<std::int64_t> ticks;
  std::vector<Logits> logits;
  std::vector<std::uint64_t> events;
  {
    const WorkingAlone alone(recording.mutex);
    const auto predictor = classifier.on_events(*recording.stream.size, rendering);
    const auto add = [&](std::span<const events::Event> chunk) { predictor->add(chunk); };
    Interruption interruption;
    const auto predict_tick = [&](CameraTime tick) {
      interruption.check();
      predictor->move_to(tick);
      predictor->prepare();
      ticks.push_back(tick.time_since_epoch().count());
      logits.push_back(predictor->classify());
      events.push_back(predictor->events());
    };
    follow_ticks(recording.reader, recording.stream.id, rendering.history, rendering.tick, {add, predict_tick});
  }
  return nb::make_tuple(array_of(std::move(ticks)), array_of_logits(logits), array_of(std::move(events)));
}

/// A model on events that Python gives. Python's threads may share it.
class EventStream {
 public:
  EventStream(const Classifier& classifier, int width, int height)
      : predictor_(classifier.on_events({width, height}, classifier.rendering())) {}

  void add(const GivenEventBytes& bytes) {
    const std::span<const events::Event> events = events_of(bytes);
    const WorkingAlone alone(mutex_);
    predictor_->add(events);
  }

  NumpyArray<float> classify(std::int64_t t_us) {
    Logits logits{};
    {
      const WorkingAlone alone(mutex_);
      predictor_->move_to(camera_time(t_us));
      predictor_->prepare();
      logits = predictor_->classify();
    }
    return array_of(std::vector<float>(logits.begin(), logits.end()));
  }
  std::uint64_t events() const {
    const WorkingAlone alone(mutex_);
    return predictor_->events();
  }
  void restart() {
    const WorkingAlone alone(mutex_);
    predictor_->restart();
  }

 private:
  mutable std::mutex mutex_;
  std::unique_ptr<model::EventClassifier> predictor_;
};

}  // namespace

void bind_engine(nb::module_& module) {
  nb::class_<EventStream>(module, "EventStream")
      .def(nb::init<const Classifier&, int, int>(), nb::arg("classifier"), nb::arg("width"), nb::arg("height"),
           nb::keep_alive<1, 2>())
      .def("add", &EventStream::add, nb::arg("events"))
      .def("classify", &EventStream::classify, nb::arg("t_us"))
      .def_prop_ro("events", &EventStream::events)
      .def("restart", &EventStream::restart);

  nb::class_<Classifier>(module, "Classifier")
      .def(
          "__init__",
          [](Classifier* self, const std::string& bundle, const std::string& precision, unsigned threads) {
            const OtherThreadsRun other_threads_run;
            new (self) Classifier(bundle, threads, {.precision = model::precision_named(precision)});
          },
          nb::arg("bundle"), nb::arg("precision"), nb::arg("threads"))
      .def_prop_ro("description", [](const Classifier& classifier) { return classifier.description().dump(); })
      .def_prop_ro("temperature", [](const Classifier& classifier) { return classifier.temperature().value; })
      .def_prop_ro(
          "input_size",
          [](const Classifier& classifier) { return std::pair(classifier.input_size().height, classifier.input_size().width); })
      .def("classify", &classify, nb::arg("heatmaps"))
      .def("probabilities", &probabilities, nb::arg("logits"))
      .def("predict", &predict, nb::arg("recording"), nb::arg("tick_ms"));
}

}  // namespace tactile::python
