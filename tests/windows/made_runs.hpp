#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::test {

/// A run as the tests make it: random events, a press and a slip.
struct LabelledRun {
  std::string object = "fan";
  std::string run = "01";
  events::SensorSize sensor{40, 30};
  bool simulated = false;
  std::uint64_t seed = 1;
  std::int64_t begin_us = 1'700'000'000'000'301;
  std::int64_t length_us = 1'500'000;
  std::int64_t mean_gap_us = 150;  ///< between two events
  std::vector<TouchInterval> intervals{{Touch::press, camera_time(200'000), camera_time(260'000)},
                                       {Touch::slip, camera_time(700'000), camera_time(900'001)}};  ///< from `begin_us`
  std::vector<labels::LabelFlag> flags{};
  bool labelled = true;
};

inline std::vector<events::Event> random_events(const LabelledRun& run) {
  Random random(run.seed);
  std::vector<events::Event> events;
  for (std::int64_t t = 0; t <= run.length_us;
       t += static_cast<std::int64_t>(random.below(2 * static_cast<std::uint64_t>(run.mean_gap_us)))) {
    events::Event event;
    event.t = camera_time(run.begin_us + t);
    event.x = static_cast<std::int16_t>(random.below(static_cast<std::uint64_t>(run.sensor.width)));
    event.y = static_cast<std::int16_t>(random.below(static_cast<std::uint64_t>(run.sensor.height)));
    event.on = static_cast<std::uint8_t>(random.below(2));
    events.push_back(event);
  }
  return events;
}

inline labels::Labels labels_of(const LabelledRun& run) {
  labels::Labels labels;
  for (const TouchInterval& interval : run.intervals) {
    const CameraTime start = after(interval.start, microseconds{run.begin_us}),
                     end = after(interval.end, microseconds{run.begin_us});
    labels::LabelledInterval labelled;
    labelled.touch = interval.touch;
    labelled.start = {start, start, start};
    labelled.end = {end, end, end};
    labelled.source = "events";
    labels.intervals.push_back(labelled);
  }
  labels.flags = run.flags;
  return labels;
}

/// Writes the run's folder below `data`.
inline RunFolder make_run(const std::filesystem::path& data, const LabelledRun& run) {
  const std::filesystem::path folder = data / run.object / run.run;
  std::filesystem::create_directories(folder);
  const RunFolder made = run_folder_at(folder);
  events::RecordingWriter writer(made.events(), {events::event_stream_declaration(run.sensor, "DVXplorer_TEST")});
  writer.write_events(0, random_events(run));
  writer.close();
  if (run.labelled) labels::write_labels(made.labels(), labels_of(run));
  write_run_info(made, {.object = run.object,
                        .run = run.run,
                        .session = "",
                        .simulated = run.simulated,
                        .complete = true,
                        .width = run.sensor.width,
                        .height = run.sensor.height});
  return made;
}

/// fan/01, fan/02 and usb-hub/01, each with other events.
inline void make_three_runs(const std::filesystem::path& data) {
  make_run(data, {.object = "fan", .run = "01", .seed = 1});
  make_run(data, {.object = "fan", .run = "02", .seed = 2, .begin_us = -700'123});
  make_run(data, {.object = "usb-hub", .run = "01", .seed = 3});
}

}  // namespace tactile::test
