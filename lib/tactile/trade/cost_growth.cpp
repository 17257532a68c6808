#include "tactile/trade/cost_growth.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/engine/lenet_engine.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/trade/dense_heatmaps.hpp"

namespace tactile {
namespace {

using Clock = std::chrono::steady_clock;

constexpr microseconds tick{2'000};
constexpr microseconds usual_history{40'000};
constexpr std::size_t fewest_events = 100;  // of a millisecond in which the skin moves

Weights random_weights(SensorSize input) {
  Random random(1);
  Weights weights;
  for (const ParameterShape& shape : lenet_layers(input).parameters()) {
    Parameter parameter{shape, std::vector<float>(shape.count())};
    const double inputs = std::max(1.0, static_cast<double>(shape.count()) / static_cast<double>(shape.sizes.front()));
    for (float& value : parameter.values) value = static_cast<float>(random.uniform(-1, 1) / std::sqrt(inputs));
    weights.push_back(std::move(parameter));
  }
  return weights;
}

struct TickParts {
  double rendering = std::numeric_limits<double>::infinity(), network = rendering;
};

double us_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::micro>(end - begin).count();
}

void keep_shorter(TickParts& kept, Clock::time_point begin, Clock::time_point rendered, Clock::time_point end) {
  const TickParts now{us_between(begin, rendered), us_between(rendered, end)};
  if (now.rendering + now.network < kept.rendering + kept.network) kept = now;
}

GrowthPoint::Way way_of(std::span<const TickParts> ticks) {
  std::vector<double> rendering, network, both;
  for (const TickParts& one : ticks) {
    rendering.push_back(one.rendering);
    network.push_back(one.network);
    both.push_back(one.rendering + one.network);
  }
  return {quantile(rendering, 0.5), quantile(network, 0.5), quantile(both, 0.5), quantile(both, 0.99)};
}

/// A stream of one rate: which events there are until a tick, all just before it.
class EvenStream {
 public:
  EvenStream(std::span<const Event> source, SensorSize from, SensorSize to, double events_per_s, std::size_t ticks,
             std::size_t begin)
      : events_per_tick_(events_per_s * 1e-6 * static_cast<double>(tick.count())), events_(until(ticks)) {
    std::size_t at = 1;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      while (i >= until(at)) ++at;
      events_[i] = source[(begin + i) % source.size()];
      events_[i].x = static_cast<std::int16_t>(events_[i].x * to.width / from.width);
      events_[i].y = static_cast<std::int16_t>(events_[i].y * to.height / from.height);
      events_[i].t = before(time_of(at), 1us);
    }
  }
  /// Those between the ends of two ticks, counted from 0.
  std::span<const Event> between(std::size_t from, std::size_t to) const {
    return std::span(events_).subspan(until(from), until(to) - until(from));
  }
  static CameraTime time_of(std::size_t at) { return camera_time(tick.count() * static_cast<std::int64_t>(at)); }

 private:
  std::size_t until(std::size_t at) const { return static_cast<std::size_t>(events_per_tick_ * static_cast<double>(at)); }
  double events_per_tick_;
  std::vector<Event> events_;
};

GrowthPoint measure_point(std::span<const Event> source, SensorSize source_sensor, SensorSize sensor, double events_per_s,
                          microseconds history_us, const GrowthOptions& options) {
  const HeatmapOptions rendering{.history = history_us, .tick = tick};
  GrowthPoint point{.events_per_s = events_per_s,
                    .history = history_us,
                    .sensor = sensor,
                    .heatmap = heatmap_size(sensor, rendering.factor),
                    .lit_share = 0,
                    .sparse = {},
                    .dense = {}};
  const Weights weights = random_weights(point.heatmap);
  LeNetEngine skipping(point.heatmap, weights), whole(point.heatmap, weights, {}, {.skip_empty = false});
  const auto history = static_cast<std::size_t>(history_us / tick);
  std::vector<TickParts> sparse(std::size_t{options.pieces} * options.ticks), dense = sparse;
  std::vector<std::uint8_t> heatmap(static_cast<std::size_t>(point.heatmap.width) *
                                    static_cast<std::size_t>(point.heatmap.height));
  std::uint64_t lit = 0, cells = 0;
  for (unsigned piece = 0; piece < options.pieces; ++piece) {
    const EvenStream stream(source, source_sensor, sensor, events_per_s, history + options.ticks,
                            source.size() / options.pieces * piece);
    for (unsigned turn = 0; turn < options.turns; ++turn) {
      HeatmapRenderer renderer(sensor, rendering);
      for (std::size_t at = 1; at <= history; ++at) {
        renderer.add(stream.between(at - 1, at));
        renderer.move_to(EvenStream::time_of(at));
      }
      renderer.render(std::span(heatmap));
      skipping.classify(heatmap);
      for (std::size_t i = 0, at = history + 1; i < options.ticks; ++i, ++at) {
        const auto events = stream.between(at - 1, at);
        const auto begin = Clock::now();
        renderer.add(events);
        renderer.move_to(EvenStream::time_of(at));
        renderer.render(std::span(heatmap));
        const auto rendered = Clock::now();
        skipping.classify(heatmap);
        keep_shorter(sparse[std::size_t{piece} * options.ticks + i], begin, rendered, Clock::now());
        lit += static_cast<std::uint64_t>(
            std::count_if(heatmap.begin(), heatmap.end(), [](std::uint8_t cell) { return cell != 0; }));
        cells += heatmap.size();
      }
      DenseHeatmaps plain(sensor, rendering.factor);
      plain.add(stream.between(0, history));
      plain.render();
      whole.classify(plain.heatmap());
      for (std::size_t i = 0, at = history + 1; i < options.ticks; ++i, ++at) {
        const auto coming = stream.between(at - 1, at), going = stream.between(at - history - 1, at - history);
        const auto begin = Clock::now();
        plain.add(coming);
        plain.forget(going);
        plain.render();
        const auto rendered = Clock::now();
        whole.classify(plain.heatmap());
        keep_shorter(dense[std::size_t{piece} * options.ticks + i], begin, rendered, Clock::now());
      }
    }
  }
  point.lit_share = cells == 0 ? 0 : static_cast<double>(lit) / static_cast<double>(cells);
  point.sparse = way_of(sparse);
  point.dense = way_of(dense);
  return point;
}

nlohmann::json json_of(const GrowthPoint::Way& way) {
  return {{"rendering_us", way.rendering_us}, {"network_us", way.network_us}, {"p50_us", way.p50_us}, {"p99_us", way.p99_us}};
}

}  // namespace

void to_json(nlohmann::json& json, const GrowthPoint& point) {
  json = {{"events_per_s", point.events_per_s},
          {"th_ms", static_cast<double>(point.history.count()) / 1000},
          {"sensor", {point.sensor.width, point.sensor.height}},
          {"heatmap", {point.heatmap.width, point.heatmap.height}},
          {"lit_share", point.lit_share},
          {"sparse", json_of(point.sparse)},
          {"dense", json_of(point.dense)}};
}

void to_json(nlohmann::json& json, const CostGrowth& growth) {
  json = {{"rate", growth.by_rate}, {"history", growth.by_history}, {"resolution", growth.by_resolution}};
}

std::vector<Event> moving_events(std::span<const std::filesystem::path> recordings) {
  std::vector<Event> all;
  for (const auto& file : recordings) {
    std::vector<Event> of_recording;
    RecordingReader recording(file);
    for_all_events(recording, event_stream(recording).id,
                   [&](std::span<const Event> events) { of_recording.insert(of_recording.end(), events.begin(), events.end()); });
    for (auto begin = of_recording.begin(); begin != of_recording.end();) {
      const CameraTime end_of_ms = after(begin->t, 1ms);
      const auto end = std::find_if(begin, of_recording.end(), [&](const Event& event) { return event.t >= end_of_ms; });
      if (static_cast<std::size_t>(end - begin) >= fewest_events) all.insert(all.end(), begin, end);
      begin = end;
    }
  }
  if (all.empty()) throw Error("no events to measure the growth of cost with; expected recordings in which something moves");
  return all;
}

CostGrowth measure_growth(std::span<const Event> source, SensorSize sensor, const GrowthOptions& options,
                          const ProgressCallback& progress) {
  if (source.empty() || sensor.width <= 0 || sensor.height <= 0)
    throw Error("growth of cost: no events or no sensor; expected some of a sensor's");
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);  // as ours has one
  CostGrowth growth;
  const std::uint64_t total = options.rates.size() + options.histories.size() + options.sensors.size();
  std::uint64_t done = 0;
  const auto measure = [&](SensorSize of, double rate, microseconds history) {
    tell(progress, done++, total, "how cost grows");
    return measure_point(source, sensor, of, rate, history, options);
  };
  try {
    for (const double rate : options.rates) growth.by_rate.push_back(measure(sensor, rate, usual_history));
    for (const microseconds history : options.histories)
      growth.by_history.push_back(measure(sensor, options.usual_rate, history));
    for (const SensorSize of : options.sensors) growth.by_resolution.push_back(measure(of, options.usual_rate, usual_history));
  } catch (...) {
    cv::setNumThreads(threads);
    throw;
  }
  cv::setNumThreads(threads);
  return growth;
}

}  // namespace tactile
