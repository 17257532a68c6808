#include <algorithm>

#include "bytes_as_file.hpp"
#include "checked_labels.hpp"
#include "tactile/core/error.hpp"
#include "tactile/labels/label_history.hpp"
#include "tactile/labels/label_json.hpp"

namespace {

using namespace tactile;

/// What an edit changes, as text.
std::string edited_part(const labels::Labels& labels) {
  nlohmann::json parts = nlohmann::json::array();
  for (const labels::LabelledInterval& interval : labels.intervals) parts.push_back(labels::json_of(interval));
  for (const labels::LabelFlag& flag : labels.flags) parts.push_back(labels::json_of(flag));
  for (const TouchInterval& rejected : labels.rejected) parts.push_back(labels::json_of_rejected(rejected));
  return parts.dump();
}

/// Undoes edits and makes them again: each state is consistent, and the last one is the first, or there is an Error.
void go_back_and_forth(const labels::Labels& read) {
  constexpr std::size_t most = 20;
  labels::Labels now = read;
  const std::size_t made = now.history.entries.size() - now.history.undone;
  std::size_t steps = 0;
  try {
    for (; steps < std::min(made, most); ++steps) {
      now = labels::undone(std::move(now));
      test::check(now);
    }
  } catch (const Error&) {
    return;  // another program changed them
  }
  now = labels::redone(std::move(now), steps);
  test::check(now);
  test::abort_unless(edited_part(now) == edited_part(read) && now.history.undone == read.history.undone);
}

}  // namespace

/// For any input, labels that are read are consistent, their clocks convert times, and their edits are undone and redone exactly,
/// or there is an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const test::BytesAsFile file(data, size);
  try {
    const labels::Labels labels = labels::read_labels(file.path());
    test::check(labels);
    go_back_and_forth(labels);
    std::vector<alignment::FittedClock> clocks = labels.robot_clocks;
    if (labels.video_clock) clocks.push_back(*labels.video_clock);
    for (const alignment::FittedClock& clock : clocks) {
      clock.relation.clock_us_from(clock.relation.camera_from(1'000'000));
    }
  } catch (const Error&) {
  }
  return 0;
}
