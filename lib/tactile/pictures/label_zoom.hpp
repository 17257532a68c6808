#pragma once

#include <vector>

#include "tactile/pictures/label_script.hpp"

namespace tactile::pictures {

inline constexpr std::size_t most_zooms = 4;

/// The onsets that are enlarged, by time: slips are chosen first, then flagged intervals, then the first presses.
std::vector<const labels::LabelledInterval*> onsets_to_enlarge(const labels::Labels& labels);

/// Draws an onset with 60 ms before and after it, in milliseconds from it, with the evidence of each source.
/// @param interval  of the script's labels
/// @param is_last   of several in a column: it has the label of the axis
void draw_zoom(LabelScript& script, const labels::LabelledInterval& interval, const PlotBox& box, bool is_last);

}  // namespace tactile::pictures
