#include "tactile/heatmaps/store_heatmaps.hpp"

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/in_order.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/windows/older_heatmaps.hpp"
#include "tactile/windows/run_samples.hpp"

namespace tactile::heatmaps {
namespace {

using Packed = windows::HeatmapsWriter::Packed;

/// A history while it is written.
struct HistoryToStore {
  HeatmapOptions options;
  StoredHistory* stored = nullptr;
  windows::HeatmapsWriter writer;
  std::optional<windows::OlderHeatmaps> older;  ///< in the file that it replaces

  HistoryToStore(const windows::Dataset& dataset, HeatmapOptions rendering, StoredHistory& history)
      : options(std::move(rendering)), stored(&history), writer(dataset, history.heatmaps) {
    try {
      older = windows::OlderHeatmaps::find(dataset.file(), history.heatmaps);
    } catch (const Error& e) {
      warn(e);
    }
  }

  void warn(const Error& e) { stored->warning = std::string("all runs of this file are rendered again: ") + e.what(); }
};

/// The histories of a run that stay, packed; nothing for the others. A history whose file is damaged keeps no further run.
/// @param guard  of `renderings`
std::vector<std::optional<Packed>> kept_heatmaps(std::deque<HistoryToStore>& renderings, const std::string& source_sha256,
                                                 std::mutex& guard) {
  std::vector<std::optional<Packed>> kept;
  for (HistoryToStore& rendering : renderings) {
    kept.emplace_back();
    if (!rendering.older) continue;
    try {
      auto chunks = rendering.older->chunks_of(source_sha256);
      if (!chunks.empty()) kept.back() = rendering.writer.unpacked(std::move(chunks));
    } catch (const Error& e) {
      const std::scoped_lock lock(guard);
      rendering.stored->warning = std::string("a run is rendered again: ") + e.what();
    }
  }
  return kept;
}

/// All histories of a run, packed: kept or rendered.
std::vector<Packed> heatmaps_of_run(const windows::Dataset& dataset, const windows::RunSamples& run,
                                    std::deque<HistoryToStore>& renderings, std::vector<std::optional<Packed>> kept) {
  std::vector<std::size_t> missing;  // indexes into `renderings`
  std::vector<HeatmapOptions> options;
  std::vector<std::vector<std::uint8_t>> heatmaps;
  for (std::size_t i = 0; i < renderings.size(); ++i) {
    if (kept[i]) continue;
    missing.push_back(i);
    options.push_back(renderings[i].options);
    const windows::StoredHeatmaps& size = renderings[i].stored->heatmaps;
    heatmaps.emplace_back(std::size_t{run.count} * static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  }
  std::vector<std::uint32_t> sample_indexes(run.count);
  std::iota(sample_indexes.begin(), sample_indexes.end(), run.first);
  if (!missing.empty()) {
    render_run(dataset, run.run_index, options, sample_indexes, [&](std::size_t rendering_index, std::size_t place) {
      const std::size_t length = heatmaps[rendering_index].size() / run.count;
      return std::span(heatmaps[rendering_index]).subspan(place * length, length);
    });
  }
  for (std::size_t i = 0; i < missing.size(); ++i)
    kept[missing[i]] = renderings[missing[i]].writer.packed(std::move(heatmaps[i]));
  std::vector<Packed> all(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) all[i] = *std::move(kept[i]);
  return all;
}

}  // namespace

std::vector<StoredHistory> store_heatmaps(const windows::Dataset& dataset, std::span<const HeatmapOptions> histories,
                                          unsigned threads, const ProgressCallback& progress) {
  remove_leftovers_in(std::filesystem::absolute(dataset.file()).parent_path());  // even if nothing is missing
  std::vector<StoredHistory> stored;
  std::vector<HeatmapOptions> missing;
  for (const HeatmapOptions& options : histories) {
    check_renders(dataset, options);
    const events::SensorSize size = heatmap_size(dataset.sensor(), options.factor);
    const windows::StoredHeatmaps wanted{
        .name = stored_name(options), .settings = options, .width = size.width, .height = size.height};
    const auto found = dataset.find_heatmaps(wanted.name);
    const bool is_there = found && found->settings == wanted.settings;
    const bool is_coming = std::find(missing.begin(), missing.end(), options) != missing.end();
    stored.push_back({.heatmaps = wanted, .kept = is_there || is_coming, .warning = {}});
    if (!is_there && !is_coming) missing.push_back(options);
  }
  if (missing.empty()) return stored;
  std::deque<HistoryToStore> renderings;
  for (StoredHistory& each : stored) {
    if (!each.kept) renderings.emplace_back(dataset, missing[renderings.size()], each);
  }

  const std::vector<windows::RunSamples> runs = windows::samples_by_run(dataset);
  // Digests and files both need the runs' order. Each takes so long that they must not wait for each other. Not many runs may
  // be ahead: memory has them all.
  const std::size_t most_ahead = std::max(1U, threads_or_all(threads) / 2);
  InOrder digesting(most_ahead), writing(most_ahead);
  std::mutex guard;  // of warnings
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    const windows::RunSamples& run = runs[i];
    try {
      auto kept = kept_heatmaps(renderings, windows::source_sha256_of(dataset, run), guard);
      std::vector<bool> is_kept(kept.size());
      std::transform(kept.begin(), kept.end(), is_kept.begin(), [](const auto& each) { return each.has_value(); });
      std::vector<std::vector<std::uint8_t>> heatmaps;
      std::vector<std::vector<std::vector<std::uint8_t>>> chunks;
      for (Packed& packed : heatmaps_of_run(dataset, run, renderings, std::move(kept))) {
        heatmaps.push_back(std::move(packed.heatmaps));
        chunks.push_back(std::move(packed.chunks));
      }
      digesting.later(i, [&renderings, heatmaps = std::make_shared<decltype(heatmaps)>(std::move(heatmaps))] {
        for (std::size_t k = 0; k < renderings.size(); ++k) renderings[k].writer.add_to_digest((*heatmaps)[k]);
      });
      writing.later(i, [&, i, is_kept, chunks = std::make_shared<decltype(chunks)>(std::move(chunks))] {
        for (std::size_t k = 0; k < renderings.size(); ++k) {
          renderings[k].writer.append((*chunks)[k]);
          ++(is_kept[k] ? renderings[k].stored->runs_kept : renderings[k].stored->runs_rendered);
        }
        report_progress(progress, runs[i].first + runs[i].count, dataset.samples().size(),
                        name_of(dataset.runs()[runs[i].run_index]));
      });
    } catch (...) {
      digesting.fail();
      writing.fail();
      throw;
    }
  });
  for (HistoryToStore& rendering : renderings) rendering.writer.commit();
  return stored;
}

}  // namespace tactile::heatmaps
