#include "bytes_as_file.hpp"
#include "checked_labels.hpp"
#include "tactile/core/error.hpp"

/// For any input, labels that are read are consistent and their clocks convert times, or there is an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  const test::BytesAsFile file(data, size);
  try {
    const labels::Labels labels = labels::read_labels(file.path());
    test::check(labels);
    std::vector<alignment::FittedClock> clocks = labels.robot_clocks;
    if (labels.video_clock) clocks.push_back(*labels.video_clock);
    for (const alignment::FittedClock& clock : clocks) {
      clock.relation.clock_us_from(clock.relation.camera_from(1'000'000));
    }
  } catch (const Error&) {
  }
  return 0;
}
