#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/truth.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::test {

inline constexpr events::SensorSize small_sensor{160, 120};  ///< heatmaps of 32 x 24

/// The five objects that are held out by default, and one more.
inline const std::vector<std::string> six_objects{"fan", "plastic-container", "small-box", "sprayer", "textured-box", "usb-hub"};

/// A run of 1.2 s: noise all the time, a patch on the left from 200 to 400 ms (press), one on the right from 700 to 900 ms
/// (slip). Camera time begins at 5 s.
inline void make_run(const std::filesystem::path& folder, std::uint64_t seed, bool with_labels = true, bool simulated = true) {
  std::filesystem::create_directories(folder);
  const RunFolder run = run_folder_at(folder);
  Random random(seed_for(seed, {run.object, run.run}));
  std::vector<events::Event> events;
  const auto add = [&](std::int64_t t_us, int x, int y, int width, int height) {
    events.push_back({camera_time(5'000'000 + t_us),
                      static_cast<std::int16_t>(x + static_cast<int>(random.below(static_cast<std::uint64_t>(width)))),
                      static_cast<std::int16_t>(y + static_cast<int>(random.below(static_cast<std::uint64_t>(height)))),
                      static_cast<std::uint8_t>(random.below(2))});
  };
  for (std::int64_t t_us = 0; t_us <= 1'200'000; t_us += 100) {
    const bool press = 200'000 < t_us && t_us <= 400'000, slip = 700'000 < t_us && t_us <= 900'000;
    if (t_us % 500 == 0) add(t_us, 0, 0, small_sensor.width, small_sensor.height);
    if (press) add(t_us, 10, 30, 50, 60);
    if (slip) add(t_us, 100, 30, 50, 60);
  }
  events::RecordingWriter writer(run.events(), {events::event_stream_declaration(small_sensor, "test")});
  writer.write_events(0, events);
  writer.close();
  RunInfo info{.object = run.object,
               .run = run.run,
               .session = "",
               .simulated = simulated,
               .complete = true,
               .width = small_sensor.width,
               .height = small_sensor.height};
  write_run_info(run, info);

  labels::Labels labels;
  Truth truth;
  for (const auto& [touch, start_ms] : {std::pair(Touch::press, 200), std::pair(Touch::slip, 700)}) {
    const CameraTime start = camera_time(5'000'000 + start_ms * 1000), end = after(start, 200ms);
    labels::LabelledInterval interval;
    interval.touch = touch;
    interval.start = {start, start, start};
    interval.end = {end, end, end};
    interval.source = "events";
    labels.intervals.push_back(interval);
    TrueInterval true_interval{{touch, start, end}, {}, {}, true};
    if (touch == Touch::slip) true_interval.gross = after(start, 20ms);
    truth.intervals.push_back(true_interval);
  }
  if (with_labels) labels::write_labels(run.labels(), labels);
  if (simulated) write_truth(run.truth(), truth);
}

/// Runs "01" ... of each object below `data`.
inline void make_runs(const std::filesystem::path& data, const std::vector<std::string>& objects, int runs) {
  for (const std::string& object : objects) {
    for (int run = 1; run <= runs; ++run) make_run(data / object / ("0" + std::to_string(run)), 1);
  }
}

}  // namespace tactile::test
