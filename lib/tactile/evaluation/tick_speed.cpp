#include "tactile/evaluation/tick_speed.hpp"

#include <algorithm>
#include <ctime>
#include <vector>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/run_ticks.hpp"

namespace tactile::evaluation {
namespace {

/// Processor time of this thread [us]: other programs do not count.
double thread_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void to_json(nlohmann::json& json, const TickSpeed& speed) {
  json = {{"us_p50", speed.us_p50}, {"us_p99", speed.us_p99}, {"ticks", speed.ticks}};
}

std::optional<TickSpeed> measure_tick_speed(const std::filesystem::path& recording, const model::Classifier& classifier,
                                            std::uint64_t most_ticks) {
  events::RecordingReader reader(recording);
  const events::Stream& stream = events::event_stream(reader);
  const heatmaps::HeatmapOptions rendering = classifier.rendering();
  const auto model = classifier.on_events(stream.size.value_or(events::SensorSize{}), rendering);
  const TickRange ticks = events::listed_ticks(reader, stream.id, rendering.history, rendering.tick);
  if (ticks.count == 0) return std::nullopt;
  const auto measured = std::min<std::uint64_t>(most_ticks, static_cast<std::uint64_t>(ticks.count));
  std::vector<events::Event> events;
  events::for_events_between(reader, stream.id, before(ticks.first, rendering.history),
                             ticks.at(static_cast<std::int64_t>(measured)),
                             [&](std::span<const events::Event> some) { events.insert(events.end(), some.begin(), some.end()); });
  std::vector<double> us;
  auto next = events.begin();
  for (std::uint64_t i = 0; i < measured; ++i) {
    const CameraTime t = ticks.at(static_cast<std::int64_t>(i));
    const auto end = std::find_if(next, events.end(), [t](const events::Event& event) { return event.t >= t; });
    const double begun = thread_us();
    model->add({next, end});
    model->move_to(t);
    model->prepare();
    model->classify();
    us.push_back(thread_us() - begun);
    next = end;
  }
  return TickSpeed{quantile(us, 0.5), quantile(us, 0.99), measured};
}

}  // namespace tactile::evaluation
