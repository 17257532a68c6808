#include "tactile/heatmaps/store_heatmaps.hpp"

#include <algorithm>
#include <numeric>
#include <thread>
#include <vector>

#include "tactile/heatmaps/render_samples.hpp"

namespace tactile {

StoredHistory store_heatmaps(const Dataset& dataset, const HeatmapOptions& options, unsigned threads,
                             const ProgressCallback& progress) {
  check_renders(dataset, options);
  const SensorSize size = heatmap_size(dataset.sensor(), options.factor);
  const StoredHeatmaps description{.name = stored_name(options), .settings = options, .width = size.width, .height = size.height};
  if (const auto stored = dataset.find_heatmaps(description.name); stored && stored->settings == description.settings)
    return {*stored, true};
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  const std::span<const Sample> samples = dataset.samples();
  HeatmapsWriter writer(dataset, description);
  for (std::size_t begin = 0; begin < samples.size();) {
    std::size_t end = begin;  // a batch: as many whole runs as there are threads
    for (unsigned runs = 0; runs < threads && end < samples.size(); ++runs) {
      const std::uint32_t run_index = samples[end].run_index;
      while (end < samples.size() && samples[end].run_index == run_index) ++end;
    }
    std::vector<std::uint32_t> indexes(end - begin);
    std::iota(indexes.begin(), indexes.end(), static_cast<std::uint32_t>(begin));
    writer.append(render_samples(dataset, options, indexes, threads));
    tell(progress, end, samples.size(), description.name);
    begin = end;
  }
  writer.commit();
  return {description, false};
}

}  // namespace tactile
