#include "tactile/heatmaps/render_samples.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"

namespace tactile {
namespace {

/// Where a sample's heatmap goes in the result.
struct Wanted {
  std::uint32_t sample_index = 0;
  std::size_t place = 0;
};

}  // namespace

void check_renders(const Dataset& dataset, const HeatmapOptions& options) {
  const HeatmapRenderer renderer(dataset.sensor(), options);
  const auto text_of = [](microseconds d) { return std::to_string(d.count()) + " us"; };
  if (options.history > dataset.sampling().history) {
    throw Error("history of " + text_of(options.history) + "; expected at most the " + text_of(dataset.sampling().history) +
                " of events that " + dataset.file().string() + " stores, 'tactile windows --history-ms' stores more");
  }
  for (const Sample& sample : dataset.samples()) {
    if (last_tick_until(sample.t, options.tick) != sample.t) {
      throw Error("tick of " + text_of(options.tick) + ": the sample at " + std::to_string(us_of(sample.t)) +
                  " us lies at none; expected a part of the tick of " + text_of(dataset.sampling().tick) + " that " +
                  dataset.file().string() + " was made with");
    }
  }
}

std::vector<std::uint8_t> render_samples(const Dataset& dataset, const HeatmapOptions& options,
                                         std::span<const std::uint32_t> sample_indexes, unsigned threads,
                                         const ProgressCallback& progress) {
  check_renders(dataset, options);
  const std::span<const Sample> samples = dataset.samples();
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
  const SensorSize size = heatmap_size(dataset.sensor(), options.factor);
  const std::size_t length = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  std::vector<std::uint8_t> heatmaps(sample_indexes.size() * length);

  std::mutex guard;
  std::uint64_t done = 0;
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    auto& [run_index, wanted] = runs[i];
    std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) { return a.sample_index < b.sample_index; });
    const std::vector<Event> events = dataset.events(run_index);
    HeatmapRenderer renderer(dataset.sensor(), options);
    SlidingCounts counts(dataset.sensor(), options.history);
    std::size_t given = 0;
    for (const Wanted& each : wanted) {
      const CameraTime t = samples[each.sample_index].t;
      // Events ahead of the window are given too, in order, and forgotten at once.
      const auto end = std::partition_point(events.begin() + static_cast<std::ptrdiff_t>(given), events.end(),
                                            [&](const Event& event) { return event.t < t; });
      const auto next = static_cast<std::size_t>(end - events.begin());
      counts.add(std::span(events).subspan(given, next - given));
      given = next;
      counts.move_to(t);
      renderer.render(counts, std::span(heatmaps).subspan(each.place * length, length));
    }
    const std::scoped_lock lock(guard);
    done += wanted.size();
    tell(progress, done, sample_indexes.size(), dataset.runs()[run_index].object + "/" + dataset.runs()[run_index].run);
  });
  return heatmaps;
}

}  // namespace tactile
