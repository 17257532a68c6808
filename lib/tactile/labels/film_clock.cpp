#include "tactile/labels/film_clock.hpp"

#include <algorithm>
#include <vector>

#include "tactile/alignment/film_of_arm.hpp"
#include "tactile/alignment/film_of_skin.hpp"

namespace tactile::labels {
namespace {

/// The arm's motion that the film must show: by the first piece of the log whose clock is known.
std::optional<alignment::SeenMotion> arm_in_film(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks) {
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    const std::optional<alignment::ArmMotion> arm = alignment::arm_motion(signals.robot[i].log);
    if (arm && clocks.pieces[i]) return alignment::seen_motion(*arm, signals.robot[i].phases, *clocks.pieces[i]);
  }
  return std::nullopt;
}

alignment::VideoClockFit video_clock_by_bursts(const alignment::RunSignals& signals,
                                               const alignment::VideoClockOptions& options) {
  std::vector<alignment::SeenBurst> seen;
  for (const alignment::Burst& burst : signals.bursts)
    seen.push_back({signals.rate.begin_of(burst.begin), signals.rate.begin_of(burst.end)});
  return alignment::fit_video_clock(*signals.video, seen, options);
}

/// Whether nothing but first shears relates the clocks of the log.
bool is_by_first_shear_alone(const alignment::RobotClocks& clocks) {
  const auto is_first_shear = [](const alignment::ClockAnchor& anchor) {
    return anchor.kind == alignment::AnchorKind::first_shear;
  };
  return std::all_of(clocks.anchors.begin(), clocks.anchors.end(), [&](const std::vector<alignment::ClockAnchor>& of_piece) {
    return std::all_of(of_piece.begin(), of_piece.end(), is_first_shear);
  });
}

}  // namespace

alignment::VideoClockFit fit_film_clock(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                        const alignment::VideoClockOptions& options) {
  // A film without its end may show one motion where another is expected.
  if (10 * signals.video->rows_without_frame > signals.video->frames)
    return {.clock = {},
            .refused = "the film lacks frames",
            .contradiction = {},
            .likeness = 0,
            .ambiguity = 0,
            .anchors = {},
            .remark = {}};
  const bool moves = std::any_of(signals.robot.begin(), signals.robot.end(),
                                 [](const alignment::RobotPiece& piece) { return !piece.phases.empty(); });
  const std::optional<alignment::SeenMotion> seen_arm = arm_in_film(signals, clocks);
  if (moves && seen_arm) return alignment::fit_video_clock(*signals.video, *seen_arm, options);
  return video_clock_by_bursts(signals, options);
}

std::optional<microseconds> skin_in_film_disagrees(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                                   const alignment::FittedClock& video_clock,
                                                   const alignment::VideoClockOptions& options, microseconds longest) {
  if (!is_by_first_shear_alone(clocks)) return std::nullopt;
  const alignment::VideoClockFit by_skin = video_clock_by_bursts(signals, options);
  if (!by_skin.clock) return std::nullopt;
  const microseconds apart{saturating_subtract(by_skin.clock->relation.offset_us, video_clock.relation.offset_us)};
  const microseconds expected = longest + by_skin.clock->uncertainty() + video_clock.uncertainty();
  return std::chrono::abs(apart) > expected ? std::optional(apart) : std::nullopt;
}

}  // namespace tactile::labels
