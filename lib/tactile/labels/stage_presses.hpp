#pragma once

#include <optional>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/alignment/session_clocks.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// The command that caused a press: the last change of an output to a greater value within two seconds before it.
std::optional<CameraTime> stage_command(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                        CameraTime press);

/// Flags where a press is missing: the stage was commanded to close and no press follows within two seconds, though one follows
/// another command; or a slip follows a release with no press between them. A command that the recording does not show for so
/// long counts for nothing.
std::vector<LabelFlag> missing_presses(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                       const Labels& labels);

}  // namespace tactile::labels
