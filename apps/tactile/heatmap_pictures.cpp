#include "heatmap_pictures.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tactile/core/parallel.hpp"
#include "tactile/pictures/picture_folder.hpp"

namespace tactile::cli {
namespace {

constexpr std::uint32_t together = 512;  // heatmaps in memory

/// Digits of the longest time of a run's samples, so that their names sort by time.
std::vector<std::size_t> time_widths(const windows::Dataset& dataset) {
  std::vector<std::size_t> widths(dataset.runs().size());
  for (const windows::Sample& sample : dataset.samples())
    widths[sample.run_index] = std::max(widths[sample.run_index], std::to_string(us_of(sample.t)).size());
  return widths;
}

}  // namespace

void check_heatmap_pictures(const std::filesystem::path& folder, const std::string& history_name) {
  pictures::check_picture_folder(folder / history_name);
}

std::uint64_t write_heatmap_pictures(const windows::Dataset& dataset, const windows::StoredHeatmaps& history,
                                     const std::filesystem::path& folder, unsigned threads, const ProgressCallback& progress) {
  const std::span<const windows::Sample> samples = dataset.samples();
  const std::vector<std::size_t> widths = time_widths(dataset);
  const std::size_t length = static_cast<std::size_t>(history.width) * static_cast<std::size_t>(history.height);
  pictures::PictureFolder pictures(folder / history.name, "object,run,t_us,label");
  for (std::uint32_t first = 0; first < samples.size(); first += together) {
    std::vector<std::uint32_t> indexes(std::min<std::size_t>(together, samples.size() - first));
    std::iota(indexes.begin(), indexes.end(), first);
    std::vector<std::uint8_t> heatmaps = dataset.read_heatmaps(history.name, indexes);
    std::vector<std::string> names;
    for (const std::uint32_t index : indexes) {
      const windows::Sample& sample = samples[index];
      const windows::DatasetRun& run = dataset.runs()[sample.run_index];
      names.push_back(fmt::format("{0}/{1}/{0}-{1}-{2:0{3}}-{4}.png", run.object, run.run, us_of(sample.t),
                                  widths[sample.run_index], name_of(sample.touch)));
      pictures.list(names.back(), run.object, run.run, us_of(sample.t), name_of(sample.touch));
    }
    parallel_for(indexes.size(), threads, [&](std::size_t i) {
      pictures.write(names[i], cv::Mat(history.height, history.width, CV_8UC1, heatmaps.data() + i * length));
    });
    report_progress(progress, first + indexes.size(), samples.size(), "pictures of " + history.name);
  }
  pictures.commit();
  return samples.size();
}

}  // namespace tactile::cli
