#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/live/event_watch.hpp"
#include "tactile/review/page_message.hpp"

namespace tactile::live {

struct LivePageOptions {
  events::SensorSize sensor;
  heatmaps::HeatmapOptions rendering{};  ///< of the heatmap; its history is that of the pictures
  std::vector<std::string> values{};     ///< names of what is noted, the columns of the chart after the event rate
  /// The newest picture of the film as a JPEG file, on a thread of the server; empty while there is none. Empty: no film.
  std::function<std::string()> film{};
  /// Takes what a person chooses on the page, on a thread of the server: the number of the question and the choice's name. False:
  /// the program does not ask this now. Empty: the page offers no choice.
  std::function<bool(std::uint64_t question, const std::string& choice)> choose{};
};

/// What a page shows of a program while that runs: its newest state, pictures of the newest events, the last minute as a chart.
///
/// What is watched hands over values and never waits for a browser: the newest state replaces the one before, a thread of the
/// page's own makes pictures and answers, and memory is bounded. Without a browser no picture is made.
class LivePage {
 public:
  /// @throws Error  if the rendering does not suit the sensor
  explicit LivePage(LivePageOptions options);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  EventWatch& events();  ///< gets all events of the stream

  /// The state as the page shows it. Any thread.
  void publish(nlohmann::json state);

  /// Values for the chart: it shows the highest of each in 0.05 s. Any thread. @param values  as many as the options name
  void note(std::span<const double> values);

  /// The last state. Returns once the browsers have it, or after half a second.
  void end(nlohmann::json state);

  /// GET /api/live: server-sent events, twenty a second, as long as the program runs. Each is one line of JSON:
  ///
  ///   state      as published; null before
  ///   live       rate_per_s (of the last second), silent_s (without an event), picture (its number), picture_us (that it
  ///   covers),
  ///              scene, warnings
  ///   columns    names of a step's values after its time: events_per_s, and those of the options
  ///   steps      the steps of 0.05 s that this client does not have yet; at first the last minute
  ///   ended      whether the program has ended: then it is the last one
  ///
  /// GET /api/live/events, /api/live/heatmap, /api/live/film: the newest picture; 204 while there is none.
  ///
  /// POST /api/live/choice, {"question": number, "choice": name}: what a person chooses. 409 if it is not asked now.
  ///
  /// @throws Refusal  of another path
  review::PageResponse answer(const review::PageRequest& request);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::live
