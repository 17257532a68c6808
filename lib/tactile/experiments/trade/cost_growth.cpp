#include "tactile/experiments/trade/cost_growth.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/evaluation/statistic.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/experiments/trade/dense_heatmaps.hpp"
#include "tactile/experiments/trade/tick_times.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/lenet_engine.hpp"

namespace tactile::trade {
namespace {

using Clock = std::chrono::steady_clock;

constexpr microseconds tick{2'000};
constexpr microseconds usual_history{40'000};
constexpr std::size_t fewest_events = 100;  // in a millisecond in which the skin moves

model::Weights random_weights(events::SensorSize input) {
  Random random(1);
  model::Weights weights;
  for (const model::ParameterShape& shape : model::lenet_layers(input).parameters()) {
    model::Parameter parameter{shape, std::vector<float>(shape.count())};
    const double inputs = std::max(1.0, static_cast<double>(shape.count()) / static_cast<double>(shape.sizes.front()));
    for (float& value : parameter.values) value = static_cast<float>(random.uniform(-1, 1) / std::sqrt(inputs));
    weights.push_back(std::move(parameter));
  }
  return weights;
}

struct TickParts {
  double rendering = std::numeric_limits<double>::infinity(), network = rendering;
};

void keep_shorter(TickParts& kept, Clock::time_point begin, Clock::time_point rendered, Clock::time_point end) {
  const TickParts now{us_between(begin, rendered), us_between(rendered, end)};
  if (now.rendering + now.network < kept.rendering + kept.network) kept = now;
}

results::GrowthPoint::MethodTime method_time_of(std::span<const TickParts> ticks) {
  std::vector<double> rendering, network, both;
  for (const TickParts& one : ticks) {
    rendering.push_back(one.rendering);
    network.push_back(one.network);
    both.push_back(one.rendering + one.network);
  }
  return {quantile(rendering, 0.5), quantile(network, 0.5), quantile(both, 0.5), quantile(both, 0.99)};
}

/// A stream of one rate: the events of each tick, all just before it.
class EvenStream {
 public:
  EvenStream(std::span<const events::Event> source, events::SensorSize from, events::SensorSize to, double events_per_s,
             std::size_t ticks, std::size_t begin)
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
  std::span<const events::Event> between(std::size_t from, std::size_t to) const {
    return std::span(events_).subspan(until(from), until(to) - until(from));
  }
  static CameraTime time_of(std::size_t at) { return camera_time(tick.count() * static_cast<std::int64_t>(at)); }

 private:
  std::size_t until(std::size_t at) const { return static_cast<std::size_t>(events_per_tick_ * static_cast<double>(at)); }
  double events_per_tick_;
  std::vector<events::Event> events_;
};

/// A point of the curves, measured turn by turn.
class MeasuredPoint {
 public:
  MeasuredPoint(std::span<const events::Event> source, events::SensorSize source_sensor, events::SensorSize sensor,
                double events_per_s, microseconds history, const GrowthOptions& options)
      : source_(source),
        source_sensor_(source_sensor),
        options_(options),
        rendering_{.history = history, .tick = tick},
        point_{.events_per_s = events_per_s,
               .history = history,
               .sensor = sensor,
               .heatmap = heatmaps::heatmap_size(sensor, rendering_.factor),
               .lit_share = 0,
               .sparse = {},
               .dense = {}},
        sparse_(std::size_t{options.pieces} * options.ticks),
        dense_(sparse_) {}

  void take_turn() {
    const auto history = static_cast<std::size_t>(rendering_.history / tick);
    const model::Weights weights = random_weights(point_.heatmap);
    model::LeNetEngine skipping(point_.heatmap, weights), whole(point_.heatmap, weights, {}, {.skip_empty = false});
    for (unsigned piece = 0; piece < options_.pieces; ++piece) {
      const EvenStream stream(source_, source_sensor_, point_.sensor, point_.events_per_s, history + options_.ticks,
                              source_.size() / options_.pieces * piece);
      const std::size_t first = std::size_t{piece} * options_.ticks;
      render_sparse(stream, skipping, std::span(sparse_).subspan(first, options_.ticks));
      render_dense(stream, whole, std::span(dense_).subspan(first, options_.ticks));
    }
  }

  results::GrowthPoint result() const {
    results::GrowthPoint point = point_;
    point.lit_share = cells_ == 0 ? 0 : static_cast<double>(lit_) / static_cast<double>(cells_);
    point.sparse = method_time_of(sparse_);
    point.dense = method_time_of(dense_);
    return point;
  }

 private:
  void render_sparse(const EvenStream& stream, model::LeNetEngine& network, std::span<TickParts> kept) {
    const auto history = static_cast<std::size_t>(rendering_.history / tick);
    std::vector<std::uint8_t> heatmap(static_cast<std::size_t>(point_.heatmap.width) *
                                      static_cast<std::size_t>(point_.heatmap.height));
    heatmaps::HeatmapRenderer renderer(point_.sensor, rendering_);
    for (std::size_t at = 1; at <= history; ++at) {
      renderer.add(stream.between(at - 1, at));
      renderer.move_to(EvenStream::time_of(at));
    }
    renderer.render(std::span(heatmap));
    network.classify(heatmap);
    for (std::size_t i = 0, at = history + 1; i < kept.size(); ++i, ++at) {
      const auto events = stream.between(at - 1, at);
      const auto begin = Clock::now();
      renderer.add(events);
      renderer.move_to(EvenStream::time_of(at));
      renderer.render(std::span(heatmap));
      const auto rendered = Clock::now();
      network.classify(heatmap);
      keep_shorter(kept[i], begin, rendered, Clock::now());
      lit_ +=
          static_cast<std::uint64_t>(std::count_if(heatmap.begin(), heatmap.end(), [](std::uint8_t cell) { return cell != 0; }));
      cells_ += heatmap.size();
    }
  }

  void render_dense(const EvenStream& stream, model::LeNetEngine& network, std::span<TickParts> kept) const {
    const auto history = static_cast<std::size_t>(rendering_.history / tick);
    DenseHeatmaps plain(point_.sensor, rendering_.factor);
    plain.add(stream.between(0, history));
    plain.render();
    network.classify(plain.heatmap());
    for (std::size_t i = 0, at = history + 1; i < kept.size(); ++i, ++at) {
      const auto coming = stream.between(at - 1, at), going = stream.between(at - history - 1, at - history);
      const auto begin = Clock::now();
      plain.add(coming);
      plain.forget(going);
      plain.render();
      const auto rendered = Clock::now();
      network.classify(plain.heatmap());
      keep_shorter(kept[i], begin, rendered, Clock::now());
    }
  }

  std::span<const events::Event> source_;
  events::SensorSize source_sensor_;
  GrowthOptions options_;
  heatmaps::HeatmapOptions rendering_;
  results::GrowthPoint point_;
  std::vector<TickParts> sparse_, dense_;
  std::uint64_t lit_ = 0, cells_ = 0;
};

}  // namespace

std::vector<events::Event> moving_events(std::span<const std::filesystem::path> recordings) {
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
  if (all.empty()) throw Error("no events to measure the growth of cost with; expected recordings in which something moves");
  return all;
}

results::CostGrowth measure_growth(std::span<const events::Event> source, events::SensorSize sensor, const GrowthOptions& options,
                                   const ProgressCallback& progress) {
  if (source.empty() || sensor.width <= 0 || sensor.height <= 0)
    throw Error("growth of cost: no events or no sensor; expected some of a sensor's");
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);  // as our engine
  const auto point = [&](events::SensorSize of, double rate, microseconds history) {
    return MeasuredPoint(source, sensor, of, rate, history, options);
  };
  std::vector<MeasuredPoint> by_rate, by_history, by_resolution;
  for (const double rate : options.rates) by_rate.push_back(point(sensor, rate, usual_history));
  for (const microseconds history : options.histories) by_history.push_back(point(sensor, options.usual_rate, history));
  for (const events::SensorSize of : options.sensors) by_resolution.push_back(point(of, options.usual_rate, usual_history));
  const std::uint64_t total = (by_rate.size() + by_history.size() + by_resolution.size()) * options.turns;
  std::uint64_t done = 0;
  try {
    for (unsigned turn = 0; turn < options.turns; ++turn) {
      for (auto* points : {&by_rate, &by_history, &by_resolution}) {
        for (MeasuredPoint& one : *points) {
          report_progress(progress, done++, total, "how cost grows");
          one.take_turn();
        }
      }
    }
  } catch (...) {
    cv::setNumThreads(threads);
    throw;
  }
  cv::setNumThreads(threads);
  results::CostGrowth growth;
  for (const MeasuredPoint& one : by_rate) growth.by_rate.push_back(one.result());
  for (const MeasuredPoint& one : by_history) growth.by_history.push_back(one.result());
  for (const MeasuredPoint& one : by_resolution) growth.by_resolution.push_back(one.result());
  return growth;
}

}  // namespace tactile::trade
