#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "live_view.hpp"
#include "tactile/detect/detection_session.hpp"

namespace tactile::cli {

/// What the page of `detect` shows besides the ticks.
struct DetectPageLabels {
  std::string source, model;
  std::filesystem::path recorded{};  ///< folder of the runs; empty: nothing is recorded
};

/// The page of `detect --page`. Ticks come from the thread that reports them, never from the one that detects.
class DetectPage {
 public:
  DetectPage(std::uint16_t port, DetectPageLabels labels) : view_(port), labels_(std::move(labels)) {}

  void see(std::span<const events::Event> events) { view_.see(events); }  ///< by the thread of the source
  void warn(const std::string& text);                                     ///< any thread

  /// Serves the page. @return  its address. @throws Error  if the port is in use
  std::string open(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering);

  /// The same output, whose ticks the page gets too. Refers to this.
  detect::TickOutput shown(detect::TickOutput output);
  void end(const detect::DetectionSummary& summary);

 private:
  struct Lateness {
    std::chrono::steady_clock::time_point at;
    double ms;
  };
  void take(std::span<const detect::ReportedTick> ticks);
  nlohmann::json state_json(const char* state);
  nlohmann::json lateness_json() const;
  void look_at_disk();

  LiveView view_;
  DetectPageLabels labels_;
  std::optional<detect::ReportedTick> newest_;
  std::uint64_t ticks_ = 0, skipped_ = 0, late_ = 0, incomplete_ = 0;
  std::deque<Lateness> lateness_;  ///< of the last second
  microseconds tick_{2'000};
  std::chrono::steady_clock::time_point disk_seen_{};
  nlohmann::json disk_;
  std::vector<std::string> disk_warnings_;

  std::mutex guard_;  ///< of the next one
  std::deque<std::string> messages_;
};

}  // namespace tactile::cli
