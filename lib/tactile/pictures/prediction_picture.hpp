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

/// A touch, and words on how it was detected, such as "2 ms"; empty where that is not known.
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
  bool has_truth = false;                   ///< the row of the truth is left out without
  std::vector<PredictedInterval> truth;
  std::vector<TouchInterval> unlabelled;  ///< motion without labels, drawn grey in the row of the truth
  bool has_labels = false;                ///< the row of labels is left out without
  std::vector<PredictedInterval> labels;
  std::vector<std::string> remarks;  ///< written under the panels

  /// What the predictions are judged by: the truth, or else the labels.
  const std::vector<PredictedInterval>& reference() const { return has_truth ? truth : labels; }
};

/// A figure after the paper's tenth: the event rate, the probabilities of press and slip, and rows for what was predicted, true
/// and labelled, one under the other on one axis of camera time. The intervals of the reference are shaded in all panels, with
/// their words over the first. Next to the truth, labels are a thin row.
/// @param width_px  of the figure
/// @throws Error  if there is no tick
/// Source: Faris et al., arXiv:2403.10120, figure 10.
Plot prediction_plot(const PredictionPicture& picture, int width_px = 1100);

/// Draws it as PNG or SVG. @throws Error as `draw` does
void draw_prediction(const PredictionPicture& picture, const std::filesystem::path& file);

}  // namespace tactile::pictures
