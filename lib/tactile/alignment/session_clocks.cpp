#include "tactile/alignment/session_clocks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tactile::alignment {
namespace {

std::int64_t first_us(const RobotPiece& piece) { return us_of(piece.log.states.front().t); }
std::int64_t last_us(const RobotPiece& piece) { return us_of(piece.log.states.back().t); }
std::int64_t middle_us(const RobotPiece& piece) { return first_us(piece) + (last_us(piece) - first_us(piece)) / 2; }

/// Sets where each clock holds if the clock restarts within the run.
void set_bounds(RobotClocks& clocks, const RunSignals& run) {
  if (run.robot.size() < 2) return;
  for (std::size_t i = 0; i < run.robot.size(); ++i) {
    if (!clocks.pieces[i]) continue;
    clocks.pieces[i]->from = clocks.pieces[i]->relation.camera_from(first_us(run.robot[i]));
    clocks.pieces[i]->to = clocks.pieces[i]->relation.camera_from(last_us(run.robot[i]));
  }
  // Pieces do not overlap; where two would, the one with the greater uncertainty is wrong.
  for (std::size_t i = 0; i + 1 < run.robot.size(); ++i) {
    std::optional<FittedClock>&first = clocks.pieces[i], &second = clocks.pieces[i + 1];
    if (!first || !second || *first->to <= *second->from) continue;
    (first->uncertainty() > second->uncertainty() ? first : second).reset();
    clocks.doubts.push_back(
        doubt("pieces-overlap", "two pieces of the robot log would overlap: the clock with the greater uncertainty is refused"));
  }
}

/// One run's clock by its own anchors.
struct OwnClock {
  std::size_t run = 0;
  std::int64_t middle_us = 0;
  FittedClock clock;
};

/// Whether two runs may share both clocks: their offsets differ by no more than drift and uncertainty allow.
bool agree(const OwnClock& a, const OwnClock& b, double most_drift_ppm) {
  constexpr double slack_us = 10'000;
  const auto apart_us = static_cast<double>(saturating_subtract(a.middle_us, b.middle_us));
  const auto differ_us = static_cast<double>(saturating_subtract(a.clock.relation.offset_us, b.clock.relation.offset_us));
  return std::abs(differ_us) <= 1e-6 * most_drift_ppm * std::abs(apart_us) +
                                    static_cast<double>((a.clock.uncertainty() + b.clock.uncertainty()).count()) + slack_us;
}

/// Runs that agree with each other, largest group first. A controller that restarts between two runs of a session has another
/// clock.
std::vector<std::vector<std::size_t>> agreeing_runs(const std::vector<OwnClock>& own, double most_drift_ppm) {
  std::vector<std::vector<const OwnClock*>> groups;
  for (const OwnClock& clock : own) {
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& members) {
      return std::any_of(members.begin(), members.end(),
                         [&](const OwnClock* other) { return agree(clock, *other, most_drift_ppm); });
    });
    (group == groups.end() ? groups.emplace_back() : *group).push_back(&clock);
  }
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  std::vector<std::vector<std::size_t>> runs;
  for (const auto& members : groups) {
    std::vector<std::size_t>& group = runs.emplace_back();
    for (const OwnClock* member : members) group.push_back(member->run);
  }
  return runs;
}

}  // namespace

std::vector<RobotClocks> robot_clocks_of(std::span<const RunSignals* const> runs, const RobotClocksOptions& options) {
  std::vector<RobotClocks> clocks(runs.size());
  std::vector<OwnClock> own;  // of the runs whose log has one piece: they may share its clock
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const RunSignals& run = *runs[r];
    for (std::size_t i = 0; i < run.robot.size(); ++i) {
      const RobotPiece& piece = run.robot[i];
      FoundAnchors found = clock_anchors({.robot = piece.log,
                                          .motions = piece.phases,
                                          .rate = run.rate,
                                          .quiet = run.quiet,
                                          .slow_bursts = run.slow_bursts,
                                          .imu = run.imu,
                                          .host_from_camera = run.host_from_camera,
                                          .coarse = run.coarse_offsets[i]},
                                         options.anchors);
      std::ranges::move(found.doubts, std::back_inserter(clocks[r].doubts));
      std::ranges::move(found.contradictions, std::back_inserter(clocks[r].contradictions));
      ClockFitOptions fit = options.fit;
      fit.middle_us = middle_us(piece);
      ClockFit fitted = found.anchors.empty() ? ClockFit{} : fit_clock(found.anchors, first_us(piece), fit);
      if (fitted.clock && run.robot.size() == 1) own.push_back({r, middle_us(piece), *fitted.clock});
      if (!fitted.clock && !found.anchors.empty())
        clocks[r].doubts.push_back(doubt("clock-refused", "the robot's clock cannot be related: {}", fitted.refused));
      clocks[r].pieces.push_back(std::move(fitted.clock));
      clocks[r].anchors.push_back(std::move(found.anchors));
    }
    set_bounds(clocks[r], run);
  }
  if (runs.size() < 2) return clocks;

  const std::vector<std::vector<std::size_t>> groups = agreeing_runs(own, options.fit.most_drift_ppm);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    std::vector<ClockAnchor> shared;
    for (const std::size_t r : groups[g]) shared.insert(shared.end(), clocks[r].anchors[0].begin(), clocks[r].anchors[0].end());
    std::vector<std::size_t> served = groups[g];
    // A run without anchors has the clock of all others, if they share one.
    for (std::size_t r = 0; r < runs.size() && groups.size() == 1; ++r) {
      if (runs[r]->robot.size() == 1 && !clocks[r].pieces[0]) served.push_back(r);
    }
    for (const std::size_t r : served) {
      const RobotPiece& piece = runs[r]->robot[0];
      ClockFitOptions fit = options.fit;
      fit.middle_us = middle_us(piece);
      ClockFit fitted = fit_clock(shared, first_us(piece), fit);
      if (!fitted.clock) continue;  // each keeps its own
      fitted.clock->method += fmt::format(", {} of a session's {} runs", groups[g].size(), runs.size());
      clocks[r].pieces[0] = std::move(fitted.clock);
      if (g > 0)
        clocks[r].doubts.push_back(
            doubt("clock-unlike-session",
                  "the robot's clock does not agree with that of the session's other runs: was the camera or "
                  "controller restarted between them, or is the robot log of another recording?"));
    }
  }
  return clocks;
}

}  // namespace tactile::alignment
