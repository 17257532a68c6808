#include "tactile/heatmaps/render_samples.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/ticks.hpp"

namespace tactile::heatmaps {
namespace {

/// A sample, and the place of its heatmap in the result.
struct Wanted {
  std::uint32_t sample_index = 0;
  std::size_t place = 0;
};

}  // namespace

void check_renders(const windows::Dataset& dataset, const HeatmapOptions& options) {
  const HeatmapRenderer renderer(dataset.sensor(), options);
  const auto text_of = [](microseconds d) { return std::to_string(d.count()) + " us"; };
  if (options.history > dataset.sampling().history) {
    throw Error("history of " + text_of(options.history) + "; expected at most the " + text_of(dataset.sampling().history) +
                " of events that " + dataset.file().string() + " stores, 'tactile windows --history-ms' stores more");
  }
  for (const windows::Sample& sample : dataset.samples()) {
    if (last_tick_until(sample.t, options.tick) != sample.t) {
      throw Error("tick of " + text_of(options.tick) + ": the sample at " + std::to_string(us_of(sample.t)) +
                  " us is not at a tick; expected a divisor of " + text_of(dataset.sampling().tick) + ", the tick of " +
                  dataset.file().string());
    }
  }
}

void render_events(events::SensorSize sensor, const NextEvents& next, std::span<const HeatmapOptions> renderings,
                   std::span<const CameraTime> times, const HeatmapPlace& place_of) {
  std::vector<HeatmapRenderer> renderers;
  for (const HeatmapOptions& options : renderings) renderers.emplace_back(sensor, options);
  std::vector<events::Event> piece = next();
  auto given = piece.begin();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const CameraTime t = times[i];
    for (;;) {
      const auto end = std::partition_point(given, piece.end(), [&](const events::Event& event) { return event.t < t; });
      for (HeatmapRenderer& renderer : renderers) renderer.add(std::span(given, end));
      given = end;
      if (given != piece.end() || piece.empty()) break;
      for (HeatmapRenderer& renderer : renderers) renderer.move_to(piece.back().t);  // what no moment needs is dropped
      piece = next();
      given = piece.begin();
    }
    for (std::size_t rendering_index = 0; rendering_index < renderings.size(); ++rendering_index) {
      renderers[rendering_index].move_to(t);
      renderers[rendering_index].render(place_of(rendering_index, i));
    }
  }
}

void render_run(const windows::Dataset& dataset, std::uint32_t run_index, std::span<const HeatmapOptions> renderings,
                std::span<const std::uint32_t> sample_indexes, const HeatmapPlace& place_of) {
  std::vector<CameraTime> times;
  for (const std::uint32_t index : sample_indexes) times.push_back(dataset.samples()[index].t);
  bool is_read = false;
  const auto next = [&] { return std::exchange(is_read, true) ? std::vector<events::Event>() : dataset.events(run_index); };
  render_events(dataset.sensor(), next, renderings, times, place_of);
}

std::vector<std::uint8_t> render_samples(const windows::Dataset& dataset, const HeatmapOptions& options,
                                         std::span<const std::uint32_t> sample_indexes, unsigned threads,
                                         const ProgressCallback& progress) {
  check_renders(dataset, options);
  const std::span<const windows::Sample> samples = dataset.samples();
  std::map<std::uint32_t, std::vector<Wanted>> by_run;
  for (std::size_t place = 0; place < sample_indexes.size(); ++place) {
    const std::uint32_t index = sample_indexes[place];
    if (index >= samples.size()) {
      throw Error("sample " + std::to_string(index) + "; expected an index below the " + std::to_string(samples.size()) +
                  " samples of " + dataset.file().string());
    }
    by_run[samples[index].run_index].push_back({index, place});
  }
  std::vector<std::pair<std::uint32_t, std::vector<Wanted>>> runs(by_run.begin(), by_run.end());
  const events::SensorSize size = heatmap_size(dataset.sensor(), options.factor);
  const std::size_t length = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  std::vector<std::uint8_t> heatmaps(sample_indexes.size() * length);

  std::mutex guard;
  std::uint64_t done = 0;
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    const std::uint32_t run_index = runs[i].first;
    std::vector<Wanted>& wanted = runs[i].second;
    std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) { return a.sample_index < b.sample_index; });
    std::vector<std::uint32_t> of_run;
    for (const Wanted& each : wanted) of_run.push_back(each.sample_index);
    render_run(dataset, run_index, std::span(&options, 1), of_run,
               [&](std::size_t, std::size_t place) { return std::span(heatmaps).subspan(wanted[place].place * length, length); });
    const std::scoped_lock lock(guard);
    done += wanted.size();
    report_progress(progress, done, sample_indexes.size(),
                    dataset.runs()[run_index].object + "/" + dataset.runs()[run_index].run);
  });
  return heatmaps;
}

}  // namespace tactile::heatmaps
