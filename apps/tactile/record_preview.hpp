#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "live_view.hpp"
#include "record_choices.hpp"
#include "record_runs.hpp"
#include "tactile/capture/run_recorder.hpp"
#include "tactile/live/touch_strength.hpp"

namespace tactile::cli {

/// The page of `record --preview`.
class RecordPreview {
 public:
  /// @param data  folder of runs, whose disk is watched
  RecordPreview(std::uint16_t port, std::filesystem::path data) : view_(port), data_(std::move(data)) {}

  PageChoices& choices() { return choices_; }

  // By the thread of the source.
  void see(std::span<const events::Event> events) { view_.see(events); }
  void see(std::span<const events::ImuSample> samples);

  /// Serves the page. @return  its address. @throws Error  if the port is in use
  std::string open(const capture::RunRecorder& recorder);
  void show(const RecordMoment& moment);  ///< at most twenty times a second
  void end(const capture::RunRecorder& recorder, const RecordedRuns& recorded);

 private:
  struct SeenSource {
    std::uint64_t packets = 0;
    std::chrono::steady_clock::time_point last{}, counted_at{};
    std::uint64_t counted = 0;
    double packets_per_s = 0;
  };
  nlohmann::json sources_json(const capture::RunRecorder& recorder, std::vector<std::string>& warnings);

  PageChoices choices_;  ///< the server's threads give them
  LiveView view_;
  std::filesystem::path data_;
  std::vector<SeenSource> seen_;
  live::TouchStrength strength_;
};

}  // namespace tactile::cli
