#pragma once

#include <optional>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// The robot's clock in each piece of the log; nothing where it is not known.
using RobotPieceClocks = std::vector<std::optional<alignment::FittedClock>>;

/// The command that caused a press: the last change of an output to a greater value within two seconds before it.
std::optional<CameraTime> stage_command(const alignment::RunSignals& signals, const RobotPieceClocks& clocks, CameraTime press);

/// Flags commands to the stage to close that no press follows within two seconds, though one follows another command. A command
/// that the recording does not show for so long counts for nothing.
std::vector<LabelFlag> commands_without_press(const alignment::RunSignals& signals, const RobotPieceClocks& clocks,
                                              const Labels& labels);

}  // namespace tactile::labels
