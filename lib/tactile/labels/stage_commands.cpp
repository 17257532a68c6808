#include "tactile/labels/stage_commands.hpp"

#include <algorithm>
#include <set>
#include <string>

#include "tactile/core/duration_units.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds longest_travel = 2s;

/// A change of an output to a greater value: the stage closes.
struct Closing {
  std::string output;
  CameraTime at{};
  microseconds uncertainty{};

  bool may_cause(CameraTime press) const {
    return press >= before(at, uncertainty) && press <= after(at, longest_travel + uncertainty);
  }
};

std::vector<Closing> closings_of(const alignment::RunSignals& signals, const RobotPieceClocks& clocks) {
  std::vector<Closing> closings;
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    if (!clocks[i]) continue;
    for (const robot::OutputChange& change : signals.robot[i].output_changes) {
      if (change.to > change.from)
        closings.push_back({change.output, clocks[i]->relation.camera_from(change.at), clocks[i]->uncertainty()});
    }
  }
  std::sort(closings.begin(), closings.end(), [](const Closing& a, const Closing& b) { return a.at < b.at; });
  return closings;
}

/// Those that no press follows, of the outputs that cause one. Each press follows one command.
std::vector<Closing> without_press(const std::vector<Closing>& closings, const Labels& labels) {
  std::vector<bool> taken(labels.intervals.size());
  std::set<std::string> of_stage;
  std::vector<Closing> alone;
  for (const Closing& closing : closings) {
    std::size_t i = 0;
    while (i < taken.size() &&
           (taken[i] || labels.intervals[i].touch != Touch::press || !closing.may_cause(labels.intervals[i].start.at)))
      ++i;
    if (i < taken.size()) {
      taken[i] = true;
      of_stage.insert(closing.output);
    } else {
      alone.push_back(closing);
    }
  }
  std::erase_if(alone, [&](const Closing& closing) { return !of_stage.contains(closing.output); });
  return alone;
}

}  // namespace

std::optional<CameraTime> stage_command(const alignment::RunSignals& signals, const RobotPieceClocks& clocks, CameraTime press) {
  std::optional<CameraTime> command;
  for (const Closing& closing : closings_of(signals, clocks)) {
    if (closing.may_cause(press)) command = closing.at;
  }
  return command;
}

std::vector<LabelFlag> commands_without_press(const alignment::RunSignals& signals, const RobotPieceClocks& clocks,
                                              const Labels& labels) {
  std::vector<LabelFlag> flags;
  for (const Closing& closing : without_press(closings_of(signals, clocks), labels)) {
    const bool is_recorded = before(closing.at, closing.uncertainty) >= signals.rate.begin &&
                             after(closing.at, longest_travel + closing.uncertainty) <= signals.rate.last;
    if (!is_recorded) continue;
    flags.push_back(flag_of(
        doubt("press-missing", "the stage was commanded to close at {:.2f} s, and no press is labelled in the {:.0f} s after it",
              in_s(between(signals.rate.begin, closing.at)), in_s(longest_travel))));
  }
  return flags;
}

}  // namespace tactile::labels
