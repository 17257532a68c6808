#include <fmt/format.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <mutex>

#include "arrays.hpp"
#include "interruption.hpp"
#include "recording.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "working_alone.hpp"

namespace tactile::python {
namespace {

using events::Event;
using events::SensorSize;
using heatmaps::HeatmapOptions;
using heatmaps::HeatmapRenderer;

/// The settings as `heatmaps --json` and bundles have them.
HeatmapOptions options_in(const std::string& settings) {
  auto options = nlohmann::json::parse(settings).get<HeatmapOptions>();
  check(options);
  return options;
}

SensorSize sensor_of(const Recording& recording) {
  if (recording.stream.size) return *recording.stream.size;
  throw Error(recording.reader.file().string() + ": its event stream declares no size; expected one for heatmaps");
}

/// Times, heatmaps and numbers of events of ticks.
struct Heatmaps {
  SensorSize size;
  std::vector<std::int64_t> ticks;
  std::vector<std::uint8_t> values;
  std::vector<std::uint64_t> events;

  Heatmaps(SensorSize heatmap, std::size_t count) : size(heatmap) {
    ticks.reserve(count);
    events.reserve(count);
    values.reserve(count * cells());
  }
  std::size_t cells() const { return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height); }

  nb::tuple arrays() && {
    const std::size_t count = ticks.size();
    const auto height = static_cast<std::size_t>(size.height), width = static_cast<std::size_t>(size.width);
    return nb::make_tuple(array_of(std::move(ticks)), array_of(std::move(values), {count, height, width}),
                          array_of(std::move(events)));
  }
};

nb::tuple render_every_tick(Recording& recording, const std::string& settings) {
  const HeatmapOptions options = options_in(settings);
  const SensorSize sensor = sensor_of(recording);
  const auto render = [&] {
    const WorkingAlone alone(recording.mutex);
    const TickRange listed = heatmaps::listed_ticks(recording.reader, recording.stream.id, options);
    if (const std::string reason = why_too_many(listed); !reason.empty())
      throw Error(recording.reader.file().string() + ": " + reason);
    Heatmaps rendered(heatmaps::heatmap_size(sensor, options.factor), static_cast<std::size_t>(listed.count));
    Interruption interruption;
    for_every_tick(recording.reader, recording.stream.id, options,
                   [&](CameraTime tick, std::span<const std::uint8_t> heatmap, std::uint64_t events_in_window) {
                     interruption.check();
                     rendered.ticks.push_back(tick.time_since_epoch().count());
                     rendered.values.insert(rendered.values.end(), heatmap.begin(), heatmap.end());
                     rendered.events.push_back(events_in_window);
                   });
    return rendered;
  };
  return render().arrays();
}

/// @param ticks  ascending; each with its whole history inside the recording
nb::tuple render_ticks(Recording& recording, const std::string& settings, const GivenArray<std::int64_t, 1>& ticks) {
  const HeatmapOptions options = options_in(settings);
  const SensorSize sensor = sensor_of(recording);
  const std::span<const std::int64_t> times(ticks.data(), ticks.size());
  const std::string name = recording.reader.file().string();
  if (!std::is_sorted(times.begin(), times.end())) throw Error(name + ": ticks_us descend; expected ascending times");
  const auto render = [&] {
    const WorkingAlone alone(recording.mutex);
    Heatmaps rendered(heatmaps::heatmap_size(sensor, options.factor), times.size());
    HeatmapRenderer renderer(sensor, options);
    std::vector<std::uint8_t> heatmap(rendered.cells());
    std::size_t next = 0;
    Interruption interruption;
    const auto render_next = [&] {
      interruption.check();
      renderer.move_to(camera_time(times[next]));
      renderer.render(std::span(heatmap));
      rendered.ticks.push_back(times[next++]);
      rendered.values.insert(rendered.values.end(), heatmap.begin(), heatmap.end());
      rendered.events.push_back(renderer.events());
    };
    if (times.empty()) return rendered;

    CameraTime first = CameraTime::max(), last = CameraTime::min();
    for (const events::PacketRecord& packet : recording.reader.packets()) {
      if (packet.stream_id != recording.stream.id || packet.elements == 0) continue;
      first = std::min(first, packet.first);
      last = std::max(last, packet.last);
    }
    for (const std::int64_t tick : {times.front(), times.back()}) {
      if (before(camera_time(tick), options.history) < first || camera_time(tick) > last)
        throw Error(fmt::format("{}: tick {} us is not inside the recording with its history; expected {} to {}", name, tick,
                                after(first, options.history).time_since_epoch().count(), last.time_since_epoch().count()));
    }
    for_events_between(recording.reader, recording.stream.id, before(camera_time(times.front()), options.history),
                       camera_time(times.back()), [&](std::span<const Event> chunk) {
                         renderer.add(chunk);
                         while (next < times.size() && camera_time(times[next]) <= chunk.back().t) render_next();
                       });
    while (next < times.size()) render_next();
    return rendered;
  };
  return render().arrays();
}

/// A renderer of events that Python gives. Python's threads may share it.
class Renderer {
 public:
  Renderer(int width, int height, const std::string& settings) : renderer_({width, height}, options_in(settings)) {}

  void add(const GivenEventBytes& bytes) {
    const std::span<const Event> events = events_of(bytes);
    const WorkingAlone alone(mutex_);
    renderer_.add(events);
  }
  void move_to(std::int64_t t_us) {
    const WorkingAlone alone(mutex_);
    renderer_.move_to(camera_time(t_us));
  }
  std::uint64_t events() const {
    const WorkingAlone alone(mutex_);
    return renderer_.events();
  }

  NumpyArray<std::uint8_t> render() { return rendered<std::uint8_t>(); }
  NumpyArray<float> render_exact() { return rendered<float>(); }

 private:
  template <class Number>
  NumpyArray<Number> rendered() {
    const auto height = static_cast<std::size_t>(renderer_.size().height),
               width = static_cast<std::size_t>(renderer_.size().width);
    std::vector<Number> values(width * height);
    {
      const WorkingAlone alone(mutex_);
      renderer_.render(std::span(values));
    }
    return array_of(std::move(values), {height, width});
  }

  mutable std::mutex mutex_;
  HeatmapRenderer renderer_;
};

}  // namespace

std::span<const Event> events_of(const GivenEventBytes& bytes) {
  if (reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(Event) != 0)
    throw Error("events: their memory is not aligned to 8 bytes; expected a copy of the array");
  return {reinterpret_cast<const Event*>(bytes.data()), bytes.shape(0)};
}

void bind_heatmaps(nb::module_& module) {
  module.def("render_every_tick", &render_every_tick, nb::arg("recording"), nb::arg("settings"));
  module.def("render_ticks", &render_ticks, nb::arg("recording"), nb::arg("settings"), nb::arg("ticks_us"));
  module.def(
      "stored_name", [](const std::string& settings) { return heatmaps::stored_name(options_in(settings)); },
      nb::arg("settings"));
  module.def(
      "read_mask", [](const std::string& file) { return events::read_mask(file); }, nb::arg("file"));
  nb::class_<Renderer>(module, "Renderer")
      .def(nb::init<int, int, const std::string&>(), nb::arg("width"), nb::arg("height"), nb::arg("settings"))
      .def("add", &Renderer::add, nb::arg("events"))
      .def("move_to", &Renderer::move_to, nb::arg("t_us"))
      .def_prop_ro("events", &Renderer::events)
      .def("render", &Renderer::render)
      .def("render_exact", &Renderer::render_exact);
}

}  // namespace tactile::python
