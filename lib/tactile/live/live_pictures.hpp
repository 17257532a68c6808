#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tactile/characterise/scene.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/live/event_watch.hpp"

namespace tactile::live {

/// The events of the last history as pictures, and what the scene is like.
struct LivePicture {
  std::uint64_t number = 0;                      ///< of this picture, from 1; 0: there is none yet
  std::chrono::microseconds length{};            ///< that it covers: the history, or less if that had too many events
  std::shared_ptr<const std::string> events{};   ///< as `review::CountBytes`
  std::shared_ptr<const std::string> heatmap{};  ///< as `review::heatmap_bytes`
  std::optional<characterise::Scene> scene{};    ///< of the last second that was looked at
  std::vector<std::string> warnings{};           ///< about it
};

/// Makes pictures of what a stream of events shows now, up to twenty a second, and looks at its scene every five seconds.
class LivePictures {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// @param watch  must outlive this. @throws Error  as `HeatmapRenderer`
  LivePictures(EventWatch& watch, events::SensorSize sensor, heatmaps::HeatmapOptions rendering);

  /// Takes the windows that are full, and wants the next ones. Without an event for half a second, the picture is empty.
  void look(Time now);

  const LivePicture& newest() const { return newest_; }

 private:
  void take_picture();
  void take_scene();
  void draw(std::span<const events::Event> events, CameraTime end, std::chrono::microseconds length);
  std::vector<events::Event> inside_the_sensor(std::span<const events::Event> events) const;

  EventWatch& watch_;
  events::SensorSize sensor_;
  heatmaps::HeatmapOptions rendering_;
  LivePicture newest_;
  std::deque<characterise::Scene> earlier_;
  Time picture_wanted_{}, scene_wanted_{}, last_event_{};
  std::uint64_t events_ = 0;
  bool is_empty_ = false;
};

}  // namespace tactile::live
