// Measures the heatmap of a tick, and the same steps by dense calls of OpenCV, by event rate and by history.
// `scripts/bench --heatmaps` runs it and makes the table and the picture of docs/performance/.
//
//   heatmap_benchmark RECORDING… [--benchmark_…]
//
// Events are those of the recordings while the skin moves, or are anywhere on the sensor. Their rate is constant.

#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <string>
#include <vector>

#include "dense_heatmaps.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::bench {
namespace {

constexpr events::SensorSize sensor{640, 480};
constexpr std::size_t pieces = 10;          // of the events, spread evenly over them
constexpr std::size_t ticks_of_piece = 20;  // that are measured, after a full history

/// The steps as the definition gives them: at every tick the counts of its window, the mean of the counts above zero, exp,
/// multiply, minMaxLoc, resize.
cv::Mat1b plain_heatmap(std::span<const events::Event> window) {
  cv::Mat1f counts, denoised;
  counts = cv::Mat1f::zeros(sensor.height, sensor.width);
  for (const events::Event& event : window) counts(event.y, event.x) += 1;
  const double mean = cv::mean(counts, counts > 0)[0];
  cv::Mat1f exponential;
  cv::exp(counts - mean, exponential);
  denoised = counts.mul(1 / (1 + exponential));
  double largest = 0;
  cv::minMaxLoc(denoised, nullptr, &largest);
  cv::Mat1f resized;
  cv::resize(denoised * (largest > 0 ? 255 / largest : 0.0), resized, {}, 0.2, 0.2, cv::INTER_AREA);
  cv::Mat1b heatmap;
  resized.convertTo(heatmap, CV_8U);
  return heatmap;
}

/// The events of the milliseconds in which the skin moves, of all recordings one after the other.
std::vector<events::Event> moving_events(std::span<const std::filesystem::path> recordings) {
  constexpr std::size_t fewest_events = 100;  // in such a millisecond
  std::vector<events::Event> all;
  for (const auto& file : recordings) {
    std::vector<events::Event> of_recording;
    events::RecordingReader recording(file);
    events::for_all_events(recording, events::event_stream(recording).id, [&](std::span<const events::Event> events) {
      of_recording.insert(of_recording.end(), events.begin(), events.end());
    });
    for (auto begin = of_recording.begin(); begin != of_recording.end();) {
      const CameraTime end_of_ms = after(begin->t, 1ms);
      const auto end = std::find_if(begin, of_recording.end(), [&](const events::Event& event) { return event.t >= end_of_ms; });
      if (static_cast<std::size_t>(end - begin) >= fewest_events) all.insert(all.end(), begin, end);
      begin = end;
    }
  }
  if (all.empty()) throw Error("no events to render; expected recordings in which something moves");
  return all;
}

std::vector<events::Event> events_anywhere(std::size_t count) {
  Random random(1);
  std::vector<events::Event> events(count);
  for (events::Event& event : events) {
    event.x = static_cast<std::int16_t>(random.below(static_cast<std::uint64_t>(sensor.width)));
    event.y = static_cast<std::int16_t>(random.below(static_cast<std::uint64_t>(sensor.height)));
  }
  return events;
}

/// The shortest time of each tick with one method, which other programs delay least.
class Shortest {
 public:
  void take(std::size_t tick, const auto& step) {
    const auto begin = std::chrono::steady_clock::now();
    step();
    us_[tick] = std::min(us_[tick], std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  double mean() const { return std::accumulate(us_.begin(), us_.end(), 0.0) / static_cast<double>(us_.size()); }
  double largest() const { return *std::max_element(us_.begin(), us_.end()); }

 private:
  std::vector<double> us_ = std::vector<double>(pieces * ticks_of_piece, std::numeric_limits<double>::infinity());
};

void expect_alike(std::span<const std::uint8_t> ours, std::span<const std::uint8_t> dense) {
  for (std::size_t i = 0; i < ours.size(); ++i) {
    if (std::abs(ours[i] - dense[i]) > 1) throw Error("heatmap_benchmark: the methods give different heatmaps");
  }
}

/// Measures every tick of every piece with each method in turn, in several rounds.
void compare(benchmark::State& state, const std::vector<events::Event>& source, double events_per_s,
             const heatmaps::HeatmapOptions& options) {
  const auto events_until = [&](std::size_t tick) {
    return static_cast<std::size_t>(events_per_s * 1e-6 * static_cast<double>(options.tick.count()) * static_cast<double>(tick));
  };
  const auto history = static_cast<std::size_t>(options.history / options.tick);
  std::vector<events::Event> events(events_until(history + ticks_of_piece));
  const auto events_between = [&](std::size_t tick, std::size_t later_tick) {
    return std::span<const events::Event>(events).subspan(events_until(tick), events_until(later_tick) - events_until(tick));
  };
  const auto time_of = [&](std::size_t tick) { return camera_time(options.tick.count() * static_cast<std::int64_t>(tick)); };
  Shortest ours_us, kept_us, plain_us;
  double active = 0;
  for (auto _ : state) {
    static_cast<void>(_);
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      for (std::size_t i = 0, tick = 1; i < events.size(); ++i) {
        while (i >= events_until(tick)) ++tick;
        events[i] = source[(source.size() * piece / pieces + i) % source.size()];
        events[i].t = before(time_of(tick), 1us);
      }
      heatmaps::HeatmapRenderer ours(sensor, options);
      const std::size_t size = static_cast<std::size_t>(ours.size().width) * static_cast<std::size_t>(ours.size().height);
      std::vector<std::uint8_t> heatmaps(ticks_of_piece * size);
      const auto heatmap = [&](std::size_t i) { return std::span(heatmaps).subspan(i * size, size); };
      for (std::size_t tick = 1; tick <= history; ++tick) {
        ours.add(events_between(tick - 1, tick));
        ours.move_to(time_of(tick));
        ours.render(heatmap(0));
      }
      for (std::size_t i = 0, tick = history + 1; i < ticks_of_piece; ++i, ++tick) {
        ours_us.take(piece * ticks_of_piece + i, [&] {
          ours.add(events_between(tick - 1, tick));
          ours.move_to(time_of(tick));
          ours.render(heatmap(i));
        });
        active += ours.counts().histogram().active_pixels();
      }
      DenseHeatmaps kept(sensor, 0.2);
      kept.add(events_between(0, history));
      kept.render();
      for (std::size_t i = 0, tick = history + 1; i < ticks_of_piece; ++i, ++tick) {
        kept_us.take(piece * ticks_of_piece + i, [&] {
          kept.add(events_between(tick - 1, tick));
          kept.forget(events_between(tick - history - 1, tick - history));
          kept.render();
        });
        expect_alike(heatmap(i), kept.heatmap());
      }
      cv::Mat1b plain;
      for (std::size_t i = 0, tick = history + 1; i < ticks_of_piece; ++i, ++tick) {
        plain_us.take(piece * ticks_of_piece + i, [&] { plain = plain_heatmap(events_between(tick - history, tick)); });
        expect_alike(heatmap(i), {plain.data, plain.total()});
      }
    }
  }
  state.counters["events_per_s"] = events_per_s;
  state.counters["history_ms"] = static_cast<double>(options.history.count()) / 1000;
  state.counters["active_pixels"] =
      active / static_cast<double>(pieces * ticks_of_piece) / static_cast<double>(state.iterations());
  state.counters["ours_us"] = ours_us.mean();
  state.counters["ours_longest_us"] = ours_us.largest();
  state.counters["kept_us"] = kept_us.mean();
  state.counters["plain_us"] = plain_us.mean();
}

}  // namespace
}  // namespace tactile::bench

int main(int count, char** texts) {
  using namespace tactile;
  using namespace tactile::bench;
  try {
    cv::setNumThreads(1);
    benchmark::Initialize(&count, texts);
    const std::vector<std::filesystem::path> recordings(texts + 1, texts + count);
    const std::vector<events::Event> simulated = moving_events(recordings);
    const std::vector<events::Event> anywhere = events_anywhere(4'000'000);
    const auto measure = [&](const std::string& curve, const std::vector<events::Event>& source, double events_per_s,
                             std::chrono::milliseconds history) {
      benchmark::RegisterBenchmark(fmt::format("{}/{:.0f}/{}", curve, events_per_s, history.count()).c_str(),
                                   [&source, events_per_s, history](benchmark::State& state) {
                                     compare(state, source, events_per_s, {.history = history});
                                   })
          ->Iterations(15);
    };
    for (const double rate : {0.0, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7, 2e7}) {
      measure("rate/simulated", simulated, rate, 40ms);
      measure("rate/anywhere", anywhere, rate, 40ms);
    }
    for (const auto history : {2ms, 10ms, 20ms, 40ms, 100ms, 200ms, 500ms, 1000ms}) {
      measure("history/simulated", simulated, 3e5, history);
      measure("history/anywhere", anywhere, 3e5, history);
    }
    benchmark::RunSpecifiedBenchmarks();
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
