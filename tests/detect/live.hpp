#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "support/host_time.hpp"
#include "tactile/detect/live_detector.hpp"
#include "tactile/model/inference/heatmap_classifier.hpp"

namespace tactile::test {

inline constexpr events::SensorSize sensor{50, 50};
inline const heatmaps::HeatmapOptions short_history{.history = 10ms, .tick = 2ms};
inline constexpr std::int64_t base = 1'700'000'000'000'000;

/// A network that predicts slip for a heatmap with events.
inline model::Logits slip_where_anything_is(std::span<const std::uint8_t> heatmap) {
  for (const std::uint8_t cell : heatmap) {
    if (cell != 0) return {0, 0, 1};
  }
  return {1, 0, 0};
}

/// A network on the heatmaps of this sensor.
inline std::unique_ptr<model::EventClassifier> model_of(model::ClassifyHeatmap network,
                                                        const heatmaps::HeatmapOptions& rendering = short_history) {
  return std::make_unique<model::HeatmapClassifier>(sensor, rendering, std::move(network));
}

/// The packets of a queue.
struct Queued final : detect::PacketSupply {
  explicit Queued(capture::PacketQueue& from) : queue(from) {}
  bool next(capture::PacketQueue::Packet& packet, microseconds patience, microseconds rest) override {
    EXPECT_LE(rest, patience);
    return queue.pop(packet, patience);
  }
  void give_back(capture::PacketQueue::Packet packet) override { queue.give_back(std::move(packet)); }
  std::uint64_t lost_events() const override { return 0; }
  capture::PacketQueue& queue;
};

struct Live {
  std::vector<detect::ReportedTick> reported;
  std::vector<detect::DetectionFault> faults;
  int forgotten = 0;
  bool more_came = false;
  detect::LiveDetector detector;

  explicit Live(bool plays = false, Confirmation confirmation = {}, microseconds play_for = microseconds::max(),
                model::ClassifyHeatmap network = slip_where_anything_is)
      : detector(
            {model_of(std::move(network)), {.rendering = short_history, .decision = {.confirmation = confirmation}}},
            {.clock = {.tick = 2ms, .history = 10ms, .slack = 2ms, .by_events_alone = plays}, .play_for = play_for},
            [this](const detect::ReportedTick& tick) { reported.push_back(tick); },
            [this](const detect::DetectionFault& fault) { faults.push_back(fault); }, [this] { ++forgotten; }) {}

  void take(std::vector<std::int64_t> times, std::int64_t arrived, std::size_t source_index = 0, bool is_exact = false) {
    capture::QueuedPacket packet{.source_index = source_index, .arrived = host_time(arrived), .elements = {}};
    if (is_exact) packet.elements.arrived = packet.arrived;
    packet.elements.more_came = more_came;
    for (const std::int64_t t : times) {
      events::Event event;
      event.t = camera_time(t);
      event.x = static_cast<std::int16_t>((t / 100 % 50 + 50) % 50);
      packet.elements.events.push_back(event);
    }
    detector.take(packet);
  }
  /// Read from a connection on which further packets wait.
  void take_of_several(std::vector<std::int64_t> times, std::int64_t arrived) {
    more_came = true;
    take(std::move(times), arrived, 0, true);
    more_came = false;
  }
  /// 3 s of packets of 0.5 ms, reported as they arrive. Each `often` another packet arrives that begins 5 ms late, after its
  /// tick.
  void play_with_late_packets_each(std::int64_t often) {
    for (std::int64_t t = 0; t <= 3'000'000; t += 500) {
      take({t}, base + t);
      report_all(base + t);
      if (t % often == 0 && t > 20'000) take({t - 5'000, t}, base + t), report_all(base + t);
    }
  }
  void report_all(std::int64_t now) {
    while (detector.report_due(host_time(now))) {
    }
  }
};

}  // namespace tactile::test
