#include "tactile/heatmaps/store_heatmaps.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <numeric>
#include <string>

#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/heatmaps/render_samples.hpp"

namespace tactile::heatmaps {
namespace {

/// The samples of one run, which are consecutive.
struct RunSamples {
  std::uint32_t run_index = 0;
  std::vector<std::uint32_t> sample_indexes;
};

std::vector<RunSamples> samples_by_run(const windows::Dataset& dataset) {
  std::vector<RunSamples> runs;
  for (std::uint32_t i = 0; i < dataset.samples().size(); ++i) {
    const std::uint32_t run_index = dataset.samples()[i].run_index;
    if (runs.empty() || runs.back().run_index != run_index) runs.push_back({run_index, {}});
    runs.back().sample_indexes.push_back(i);
  }
  return runs;
}

/// Executes steps in order that are prepared in parallel.
class InTurn {
 public:
  /// Calls `step` after the steps with lower numbers. @throws what `step` throws; waiting calls then return
  template <class Step>
  void call(std::size_t number, const Step& step) {
    std::unique_lock lock(guard_);
    done_.wait(lock, [&] { return failed_ || next_ == number; });
    if (failed_) return;
    failed_ = true;
    step();
    failed_ = false;
    ++next_;
    done_.notify_all();
  }
  void fail() {
    const std::scoped_lock lock(guard_);
    failed_ = true;
    done_.notify_all();
  }

 private:
  std::mutex guard_;
  std::condition_variable done_;
  std::size_t next_ = 0;
  bool failed_ = false;
};

}  // namespace

std::vector<StoredHistory> store_heatmaps(const windows::Dataset& dataset, std::span<const HeatmapOptions> histories,
                                          unsigned threads, const ProgressCallback& progress) {
  remove_leftovers_in(std::filesystem::absolute(dataset.file()).parent_path());  // even if nothing is missing
  std::vector<StoredHistory> stored;
  std::vector<HeatmapOptions> renderings;       // the missing ones
  std::deque<windows::HeatmapsWriter> writers;  // of each way
  for (const HeatmapOptions& options : histories) {
    check_renders(dataset, options);
    const events::SensorSize size = heatmap_size(dataset.sensor(), options.factor);
    const windows::StoredHeatmaps wanted{
        .name = stored_name(options), .settings = options, .width = size.width, .height = size.height};
    const auto found = dataset.find_heatmaps(wanted.name);
    const bool is_there = found && found->settings == wanted.settings;
    const bool is_coming = std::find(renderings.begin(), renderings.end(), options) != renderings.end();
    stored.push_back({wanted, is_there || is_coming});
    if (!is_there && !is_coming) renderings.push_back(options);
  }
  for (const StoredHistory& each : stored) {
    if (!each.kept) writers.emplace_back(dataset, each.heatmaps);
  }
  if (renderings.empty()) return stored;

  const std::vector<RunSamples> runs = samples_by_run(dataset);
  InTurn in_turn;
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    const std::uint32_t run_index = runs[i].run_index;
    const std::span<const std::uint32_t> sample_indexes = runs[i].sample_indexes;
    try {
      std::vector<std::vector<std::uint8_t>> heatmaps;
      for (const HeatmapOptions& options : renderings) {
        const events::SensorSize size = heatmap_size(dataset.sensor(), options.factor);
        heatmaps.emplace_back(sample_indexes.size() * static_cast<std::size_t>(size.width) *
                              static_cast<std::size_t>(size.height));
      }
      render_run(dataset, run_index, renderings, sample_indexes, [&](std::size_t rendering_index, std::size_t place) {
        const std::size_t length = heatmaps[rendering_index].size() / sample_indexes.size();
        return std::span(heatmaps[rendering_index]).subspan(place * length, length);
      });
      std::vector<windows::HeatmapsWriter::Packed> packed;
      for (std::size_t rendering_index = 0; rendering_index < renderings.size(); ++rendering_index)
        packed.push_back(writers[rendering_index].packed(std::move(heatmaps[rendering_index])));
      in_turn.call(i, [&] {
        for (std::size_t rendering_index = 0; rendering_index < renderings.size(); ++rendering_index)
          writers[rendering_index].append(packed[rendering_index]);
        const windows::DatasetRun& run = dataset.runs()[run_index];
        report_progress(progress, sample_indexes.back() + 1, dataset.samples().size(), run.object + "/" + run.run);
      });
    } catch (...) {
      in_turn.fail();
      throw;
    }
  });
  for (windows::HeatmapsWriter& writer : writers) writer.commit();
  return stored;
}

}  // namespace tactile::heatmaps
