#include "bytes_as_file.hpp"
#include "tactile/core/error.hpp"
#include "tactile/labels/labels.hpp"

/// Whatever the bytes, intervals that are read do not overlap, flags name one that is there, and clocks can be asked.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  const test::BytesAsFile file(data, size);
  try {
    const Labels labels = read_labels(file.path());
    for (std::size_t i = 1; i < labels.intervals.size(); ++i) {
      if (labels.intervals[i].start.at < labels.intervals[i - 1].end.at) std::abort();
    }
    for (const LabelFlag& flag : labels.flags) {
      if (flag.interval_index && *flag.interval_index >= labels.intervals.size()) std::abort();
    }
    std::vector<FittedClock> clocks = labels.robot_clocks;
    if (labels.video_clock) clocks.push_back(*labels.video_clock);
    for (const FittedClock& clock : clocks) {
      clock.relation.clock_us_from(clock.relation.camera_from(1'000'000));
    }
  } catch (const Error&) {
  }
  return 0;
}
