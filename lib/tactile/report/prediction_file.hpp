#pragma once

#include <filesystem>

#include "tactile/pictures/prediction_picture.hpp"

namespace tactile::report {

/// Reads a run of `tactile eval --run` as a picture without title and remarks: its ticks, and the labelled and true intervals at
/// these ticks.
///
/// @param history_ms  of the model, > 0
/// @throws Error  if the file cannot be read, or is no such table: the line is named
pictures::PredictionPicture read_prediction(const std::filesystem::path& file, double history_ms);

/// Replaces the labelled and true intervals by those of the outcome file that `tactile eval --run` wrote, with how each was
/// detected, and adds tick, confirmation and false alarms to the remarks; by the truth, if the file has it.
/// @throws Error  if the file cannot be read, or is of another form: the member is named
void add_outcome(pictures::PredictionPicture& picture, const std::filesystem::path& file);

}  // namespace tactile::report
