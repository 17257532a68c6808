#pragma once

#include <filesystem>

#include "tactile/report/prediction_picture.hpp"

namespace tactile {

/// What `tactile eval --run` wrote of a run, as a picture without title and remarks: ticks, and the labelled and true intervals
/// that they lie in, to a tick.
///
/// @param history_ms  of the model, > 0
/// @throws Error  if the file cannot be read, or is no such table: the line is named
PredictionPicture read_prediction(const std::filesystem::path& file, double history_ms);

/// Puts how the run's intervals were met, as `tactile eval --run` wrote it, in the place of the intervals that the ticks lie in,
/// and tells tick, confirmation and false alarms.
/// @throws Error  if the file cannot be read, or is of another form: the member is named
void add_outcome(PredictionPicture& picture, const std::filesystem::path& file);

}  // namespace tactile
