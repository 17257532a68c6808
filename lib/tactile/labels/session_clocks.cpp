#include "tactile/labels/session_clocks.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace tactile {
namespace {

std::int64_t first_us(const RobotPiece& piece) { return us_of(piece.log.states.front().t); }
std::int64_t last_us(const RobotPiece& piece) { return us_of(piece.log.states.back().t); }
std::int64_t middle_us(const RobotPiece& piece) { return first_us(piece) + (last_us(piece) - first_us(piece)) / 2; }

bool has_lift(const RobotPiece& piece) {
  return std::any_of(piece.phases.begin(), piece.phases.end(),
                     [](const MotionPhase& phase) { return phase.kind == MotionKind::lift; });
}

/// Where a clock that starts anew within a run holds.
void bound(RobotClocks& clocks, const RunSignals& run) {
  if (run.robot.size() < 2) return;
  for (std::size_t i = 0; i < run.robot.size(); ++i) {
    if (!clocks.pieces[i]) continue;
    clocks.pieces[i]->from = clocks.pieces[i]->relation.camera_from(first_us(run.robot[i]));
    clocks.pieces[i]->to = clocks.pieces[i]->relation.camera_from(last_us(run.robot[i]));
  }
}

}  // namespace

std::vector<RobotClocks> robot_clocks_of(std::span<const RunSignals* const> runs, const RobotClocksOptions& options) {
  std::vector<RobotClocks> clocks(runs.size());
  std::vector<ClockAnchor> shared;
  std::size_t tellers = 0;  // runs that have an anchor of the clock that all share
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const RunSignals& run = *runs[r];
    clocks[r].pieces.resize(run.robot.size());
    for (std::size_t i = 0; i < run.robot.size(); ++i) {
      FoundAnchors found = clock_anchors(
          {.robot = run.robot[i].log, .rate = run.rate, .quiet = run.quiet, .imu = run.imu, .coarse = run.coarse_offsets[i]},
          options.anchors);
      if (run.robot.size() == 1 && !found.anchors.empty()) {
        shared.insert(shared.end(), found.anchors.begin(), found.anchors.end());
        ++tellers;
      }
      clocks[r].anchors.push_back(std::move(found.anchors));
      clocks[r].doubts.insert(clocks[r].doubts.end(), found.doubts.begin(), found.doubts.end());
    }
  }

  for (std::size_t r = 0; r < runs.size(); ++r) {
    const RunSignals& run = *runs[r];
    for (std::size_t i = 0; i < run.robot.size(); ++i) {
      const RobotPiece& piece = run.robot[i];
      const bool is_shared = run.robot.size() == 1;
      const std::vector<ClockAnchor>& anchors = is_shared ? shared : clocks[r].anchors[i];
      if (anchors.empty()) continue;  // nothing to relate it by; `doubts` says if something was there and could not be used
      ClockFitOptions fit = options.fit;
      fit.middle_us = middle_us(piece);
      ClockFit fitted = fit_clock(anchors, first_us(piece), fit);
      if (fitted.clock) {
        if (is_shared && runs.size() > 1) fitted.clock->method += fmt::format(", {} runs of one session", tellers);
        clocks[r].pieces[i] = std::move(fitted.clock);
      } else if (has_lift(piece)) {
        clocks[r].doubts.push_back("the robot's clock cannot be related: " + fitted.refused);
      }
    }
    bound(clocks[r], run);
  }
  return clocks;
}

}  // namespace tactile
