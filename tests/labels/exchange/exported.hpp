#pragma once

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile::test {

inline constexpr std::int64_t first_event_us = 1'710'534'882'413'934;

/// A time of the run, in us from its first event.
inline CameraTime in_run(std::int64_t us) { return camera_time(first_event_us + us); }

inline labels::LabelledInterval interval_of(const std::string& id, Touch touch, std::int64_t start_us, std::int64_t end_us) {
  labels::LabelledInterval interval;
  interval.id = id;
  interval.touch = touch;
  interval.start = {in_run(start_us), in_run(start_us - 700), in_run(start_us + 900)};
  interval.end = {in_run(end_us), in_run(end_us - 10'000), in_run(end_us + 20'000)};
  interval.source = "events";
  interval.evidence.events = interval.start.at;
  interval.evidence.robot = in_run(start_us - 5'123);
  return interval;
}

/// fan/01: two presses and a slip, none of them on a whole millisecond, in a recording of three seconds.
inline labels::LabelsToExport exported_run() {
  labels::LabelsToExport run;
  run.run = "fan/01";
  run.labels.intervals = {interval_of("press-1", Touch::press, 929'637, 1'067'241),
                          interval_of("press-2", Touch::press, 1'100'499, 1'200'501),
                          interval_of("slip-1", Touch::slip, 1'484'400, 1'988'001)};
  run.first_event = in_run(0);
  run.last_event = in_run(3'000'000);
  return run;
}

/// The same counting from the first frame of a film that began 1.2 s earlier and runs 80 ppm slow.
inline labels::LabelsToExport exported_on_film() {
  labels::LabelsToExport run = exported_run();
  run.times = {.origin = labels::TimeOrigin::video, .zero_us = -1'203'344, .drift_ppm = 80};
  return run;
}

}  // namespace tactile::test
