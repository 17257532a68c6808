#include "tactile/model/training/stream_runs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/run_ticks.hpp"
#include "tactile/events/waiting_events.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::model {
namespace {

using namespace std::chrono_literals;

constexpr microseconds first_part = 40ms, before_end = 20ms, after_end = 50ms;
constexpr float weight_of_first_part = 3, weight_of_unclear = 2;

RunFolder folder_of(const windows::Dataset& dataset, std::uint32_t run) {
  return {dataset.run_folder(run), dataset.runs()[run].object, dataset.runs()[run].run};
}

labels::Labels labels_of(const windows::Dataset& dataset, std::uint32_t run) {
  windows::check_unchanged(dataset, run);
  return labels::read_labels(folder_of(dataset, run).labels());
}

bool is_between(CameraTime t, CameraTime start, CameraTime end) { return start < t && t <= end; }

void set_truth(StreamRun& run, const TickRange& ticks, const labels::Labels& labels, bool include_flagged) {
  run.truth.assign(run.ticks, Touch::none);
  run.weights.assign(run.ticks, 1.0F);
  const auto for_ticks = [&](CameraTime start, CameraTime end, const auto& use) {
    for (std::size_t k = 0; k < run.ticks; ++k) {
      if (is_between(ticks.at(static_cast<std::int64_t>(k)), start, end)) use(k);
    }
  };
  for (const TouchInterval& unclear : labels::unclear_motion(labels))
    for_ticks(unclear.start, unclear.end, [&](std::size_t k) { run.weights[k] = weight_of_unclear; });
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    const TouchInterval touch = labels.intervals[i].interval();
    const bool is_used = include_flagged || !labels.interval_is_flagged(i);
    TickSpan span{touch.touch, run.ticks, 0};
    for_ticks(touch.start, touch.end, [&](std::size_t k) {
      run.truth[k] = touch.touch;
      run.weights[k] = 1;
      span.begin = std::min(span.begin, k);
      span.end = k + 1;
    });
    for_ticks(touch.start, touch.start + first_part, [&](std::size_t k) { run.weights[k] = weight_of_first_part; });
    for_ticks(touch.end - before_end, touch.end + after_end, [&](std::size_t k) { run.weights[k] = 0; });
    if (!is_used) for_ticks(touch.start - after_end, touch.end + after_end, [&](std::size_t k) { run.weights[k] = 0; });
    if (is_used && span.begin < span.end) run.touches.push_back(span);
  }
}

/// Which part of a side, cut into `parts`, each of its pixels lies in; nothing outside.
std::vector<std::optional<std::size_t>> parts_of(int pixels, double low, double high, std::size_t parts) {
  std::vector<std::optional<std::size_t>> of(static_cast<std::size_t>(pixels));
  for (std::size_t i = 0; i < of.size(); ++i) {
    const double part = std::floor((static_cast<double>(i) - low) / (high - low) * static_cast<double>(parts));
    if (part >= 0 && part < static_cast<double>(parts)) of[i] = static_cast<std::size_t>(part);
  }
  return of;
}

StreamRun read_run(const windows::Dataset& dataset, std::uint32_t index, const StreamGrid& grid,
                   const heatmaps::HeatmapOptions& rendering) {
  const labels::Labels labels = labels_of(dataset, index);
  events::WaitingEvents waiting(dataset.sensor(), rendering.mask);
  StreamRun run;
  run.name = windows::name_of(dataset.runs()[index]);
  const auto column_of = parts_of(dataset.sensor().width, grid.left, grid.right, StreamImage::columns);
  const auto row_of = parts_of(dataset.sensor().height, grid.top, grid.bottom, StreamImage::rows);
  const auto at = [&](CameraTime t) {
    const std::size_t first = run.counts.size();
    run.counts.resize(first + StreamImage::size);
    for (const events::Event& event : waiting.take_before(t)) {
      const auto column = column_of[static_cast<std::size_t>(event.x)], row = row_of[static_cast<std::size_t>(event.y)];
      if (!column || !row) continue;
      std::uint8_t& count = run.counts[first + StreamImage::at(event.on != 0 ? 1 : 0, *row, *column)];
      if (count < 255) ++count;
    }
  };
  events::RecordingReader recording(folder_of(dataset, index).events());
  const TickRange ticks = events::follow_ticks(recording, events::event_stream(recording).id, rendering.history, rendering.tick,
                                               {[&](std::span<const events::Event> events) { waiting.add(events); }, at});
  run.ticks = static_cast<std::size_t>(ticks.count);
  set_truth(run, ticks, labels, member<bool>(dataset.settings(), "include_flagged", dataset.file().string()));
  return run;
}

}  // namespace

StreamGrid grid_of_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs, const events::MaskPixels& mask) {
  const auto count_of = [](int side) { return std::vector<std::uint64_t>(static_cast<std::size_t>(side)); };
  std::vector<std::uint64_t> columns = count_of(dataset.sensor().width), rows = count_of(dataset.sensor().height);
  const events::PixelMask masked(dataset.sensor(), mask);
  for (const std::uint32_t index : runs) {
    const labels::Labels labels = labels_of(dataset, index);
    events::RecordingReader recording(folder_of(dataset, index).events());
    events::for_all_events(recording, events::event_stream(recording).id, [&](std::span<const events::Event> events) {
      for (const events::Event& event : events) {
        const auto holds = [&event](const labels::LabelledInterval& of) { return of.interval().contains(event.t); };
        if (masked.covers(event) || std::none_of(labels.intervals.begin(), labels.intervals.end(), holds)) continue;
        ++columns[static_cast<std::size_t>(event.x)];
        ++rows[static_cast<std::size_t>(event.y)];
      }
    });
  }
  return grid_around(columns, rows);
}

std::vector<StreamRun> stream_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs, const StreamGrid& grid,
                                   const heatmaps::HeatmapOptions& rendering, unsigned threads,
                                   const ProgressCallback& progress) {
  std::vector<StreamRun> read(runs.size());
  report_progress(progress, 0, runs.size(), "reading whole runs");
  parallel_for(runs.size(), threads, [&](std::size_t i) { read[i] = read_run(dataset, runs[i], grid, rendering); });
  return read;
}

}  // namespace tactile::model
