#include "tactile/alignment/stage_anchors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/duration_units.hpp"

namespace tactile::alignment {
namespace {

constexpr double shortest_travel_s = 0.03;
// From the command to open until the tips are seen to move, and its standard deviation: a slow stage, or one that sits on a
// screw, takes a tenth of a second.
constexpr double opening_s = 0.03, opening_sigma_s = 0.05;

double delay_of(const StageCommand& command, const AnchorOptions& options) {
  return command.closes ? in_s(options.stage_delay) : opening_s;
}

void add_anchor(AnchorSearch& search, const StageCommand& command, const ActivityStart& start) {
  // A travel may be longer or shorter by a third.
  const double sigma_s = command.closes ? 0.5 * in_s(search.options.stage_delay) : opening_sigma_s;
  search.add(command.at_s, start.at_s - command.at_s - delay_of(command, search.options), sigma_s, AnchorKind::stage_output,
             0.5 * sigma_s);
}

/// A shift of the clocks at which a command made an activity.
struct StageMatch {
  double shift_s = 0;
  double explained = 0;  ///< share of the events that the commands explain
};

/// Of all pairs of command and activity; the best first.
std::vector<StageMatch> matches_of(const std::vector<StageCommand>& commands, const std::vector<ActivityStart>& starts,
                                   const AnchorOptions& options, double all_events) {
  std::vector<StageMatch> matches;
  for (const ActivityStart& start : starts) {
    for (const StageCommand& command : commands)
      matches.push_back({.shift_s = start.at_s - command.at_s - delay_of(command, options)});
  }
  constexpr double slack_s = 0.5 * (longest_travel_s - shortest_travel_s);
  for (StageMatch& match : matches) {
    std::vector<const ActivityStart*> taken;
    for (const StageCommand& command : commands) {
      const double at_s = command.at_s + match.shift_s;
      const ActivityStart* start =
          command.closes ? start_within(starts, at_s - slack_s + delay_of(command, options), at_s + longest_travel_s)
                         : start_within(starts, at_s - 0.05, at_s + 0.1);
      if (start == nullptr || std::find(taken.begin(), taken.end(), start) != taken.end()) continue;
      taken.push_back(start);
      match.explained += start->events / all_events;
    }
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const StageMatch& a, const StageMatch& b) { return a.explained > b.explained; });
  return matches;
}

}  // namespace

std::vector<StageCommand> stage_commands(const AnchorSearch& search) {
  std::vector<StageCommand> commands;
  for (const robot::OutputChange& change : search.inputs.robot.output_changes) {
    commands.push_back({.at_s = 0.5 * (search.origins.seconds_of(change.last_before) + search.origins.seconds_of(change.at)),
                        .closes = change.to > change.from});
  }
  return commands;
}

std::vector<ActivityStart> activity_starts(const AnchorInputs& inputs) {
  std::vector<ActivityStart> starts;
  for (const Burst& burst : bursts_in(inputs.rate, inputs.quiet))
    starts.push_back({.at_s = in_s(inputs.rate.bin) * static_cast<double>(burst.begin), .events = burst.events});
  return starts;
}

const ActivityStart* start_within(const std::vector<ActivityStart>& starts, double from_s, double to_s) {
  for (const ActivityStart& start : starts) {
    if (start.at_s >= from_s && start.at_s <= to_s) return &start;
  }
  return nullptr;
}

void add_stage_anchors(AnchorSearch& search, const std::vector<StageCommand>& commands, const std::vector<ActivityStart>& starts,
                       double shift_s) {
  constexpr double tolerance_s = 0.05;
  for (const StageCommand& command : commands) {
    const double at_s = command.at_s + shift_s;
    const ActivityStart* start = command.closes ? start_within(starts, at_s + shortest_travel_s, at_s + longest_travel_s)
                                                : start_within(starts, at_s - tolerance_s, at_s + 2 * tolerance_s);
    if (start != nullptr) add_anchor(search, command, *start);
  }
}

void match_stage(AnchorSearch& search, const std::vector<StageCommand>& commands, const std::vector<ActivityStart>& starts,
                 const std::vector<double>& possible_s) {
  double all_events = 0;
  for (const ActivityStart& start : starts) all_events += std::max(0.0, start.events);
  std::vector<StageMatch> matches = matches_of(commands, starts, search.options, all_events);
  std::erase_if(matches, [&](const StageMatch& match) {
    return !possible_s.empty() && std::none_of(possible_s.begin(), possible_s.end(), [&](double shift_s) {
      return std::abs(match.shift_s - shift_s) < 0.5 * longest_travel_s;
    });
  });
  if (matches.empty() || !(all_events > 0)) {
    search.found.doubts.push_back(doubt("stage-unseen", "the skin does nothing that a command to the stage could have caused"));
    return;
  }
  const StageMatch& best = matches.front();
  const auto other = std::find_if(matches.begin(), matches.end(), [&](const StageMatch& match) {
    return std::abs(match.shift_s - best.shift_s) > 0.5 * longest_travel_s;
  });
  // A single command has no pattern: the largest activity must stand out clearly.
  const double needed = commands.size() == 1 ? std::max(3.0, search.options.ambiguous_below) : search.options.ambiguous_below;
  if (other != matches.end() && best.explained < needed * other->explained) {
    search.found.doubts.push_back(
        doubt("stage-ambiguous",
              "which activity of the skin the stage's commands caused is ambiguous: the best match explains only {:.2f} "
              "times as many events as the second, expected {:.2f}",
              best.explained / other->explained, needed));
    return;
  }
  for (const StageCommand& command : commands) {
    const double at_s = command.at_s + best.shift_s;
    const ActivityStart* start = command.closes ? start_within(starts, at_s - 0.2, at_s + longest_travel_s)
                                                : start_within(starts, at_s - 0.05, at_s + 0.1);
    if (start != nullptr) add_anchor(search, command, *start);
  }
}

}  // namespace tactile::alignment
