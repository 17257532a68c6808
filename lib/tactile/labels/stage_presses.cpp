#include "tactile/labels/stage_presses.hpp"

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

std::vector<Closing> closings_of(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks) {
  std::vector<Closing> closings;
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    if (!clocks.pieces[i]) continue;
    for (const robot::OutputChange& change : signals.robot[i].log.output_changes) {
      if (change.to > change.from)
        closings.push_back({change.output, clocks.pieces[i]->relation.camera_from(change.at), clocks.pieces[i]->uncertainty()});
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

/// Whether the skin let go between the last press before this slip and the slip.
bool follows_release(const Labels& labels, std::size_t slip) {
  if (slip == 0 || labels.intervals[slip - 1].touch != Touch::press) return false;
  const CameraTime pressed = labels.intervals[slip - 1].start.at, slips = labels.intervals[slip].start.at;
  return std::any_of(labels.releases.begin(), labels.releases.end(),
                     [&](const TouchInterval& release) { return release.start > pressed && release.end <= slips; });
}

}  // namespace

std::optional<CameraTime> stage_command(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                        CameraTime press) {
  std::optional<CameraTime> command;
  for (const Closing& closing : closings_of(signals, clocks)) {
    if (closing.at <= press && closing.at >= before(press, longest_travel)) command = closing.at;
  }
  return command;
}

std::vector<LabelFlag> missing_presses(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
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
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    if (labels.intervals[i].touch != Touch::slip || !follows_release(labels, i)) continue;
    flags.push_back(flag_of(doubt("press-missing-before-slip",
                                  "the skin was released before the slip at {:.2f} s, and no press is labelled between them",
                                  in_s(between(signals.rate.begin, labels.intervals[i].start.at)))));
  }
  return flags;
}

}  // namespace tactile::labels
