#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/calibration.hpp"
#include "tactile/results/confusion.hpp"

namespace tactile::report {

// Results of the network on balanced samples, and its training. Values that are NaN are not drawn.

/// Rows true, columns predicted; each field with its count and its share of the row.
pictures::Plot confusion_plot(const std::string& title, const results::Confusion& confusion);

inline constexpr std::uint64_t few_samples = 20;  ///< a bin with fewer is drawn hollow

/// Accuracy by the largest probability, with the number of samples below.
pictures::Plot reliability_plot(const std::string& title, const std::vector<results::ReliabilityBin>& bins);

/// A training, epoch by epoch.
struct TrainingCurve {
  struct Epoch {
    double epoch = 0, loss = std::numeric_limits<double>::quiet_NaN();
    double accuracy = std::numeric_limits<double>::quiet_NaN();             ///< on the training samples, in [0, 1]
    double validation_accuracy = std::numeric_limits<double>::quiet_NaN();  ///< where there is a validation part
  };
  std::string name;
  std::vector<Epoch> epochs;
};

/// Loss and accuracy of each training; the first eight are named.
pictures::Plot training_plot(const std::string& title, const std::vector<TrainingCurve>& curves);

}  // namespace tactile::report
