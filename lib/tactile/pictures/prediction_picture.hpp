#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/pictures/gnuplot.hpp"

namespace tactile::pictures {

/// The prediction of a model at one tick.
struct PredictedTick {
  CameraTime t{};
  double events_per_ms = 0;    ///< over the history
  double press = 0, slip = 0;  ///< probabilities, in [0, 1]
  Touch verdict = Touch::none;
};

/// A labelled interval, and words on how it was detected, such as "2 ms".
struct PredictedInterval {
  TouchInterval interval;
  std::string words;
  std::optional<CameraTime> first_right = std::nullopt;  ///< a tick, marked by a dashed line
};

/// The predictions of a model over a whole run, with labels and truth.
struct PredictionPicture {
  std::string title;
  std::vector<PredictedTick> ticks;         ///< ascending, evenly spaced; not empty
  std::optional<CameraTime> first_event{};  ///< of the recording, the origin of its axis; without it, the first tick
  bool has_labels = false;                  ///< the row of labels is left out without
  std::vector<PredictedInterval> labels;
  bool has_truth = false;  ///< the row of the truth is left out without
  std::vector<TouchInterval> truth;
  std::vector<TouchInterval> unlabelled;  ///< motion without labels, drawn grey in the row of the truth
  std::vector<std::string> remarks;       ///< written under the panels
};

/// A figure 1100 pixels wide, after the paper's tenth: the event rate, the probabilities of press and slip, and rows for what
/// was predicted, labelled and true, one under the other on one axis of camera time. Labelled intervals are shaded in all panels,
/// presses blue and slips orange.
/// @throws Error  if there is no tick
/// Source: Faris et al., arXiv:2403.10120, figure 10.
Plot prediction_plot(const PredictionPicture& picture);

/// Draws it as PNG or SVG. @throws Error as `draw` does
void draw_prediction(const PredictionPicture& picture, const std::filesystem::path& file);

}  // namespace tactile::pictures
