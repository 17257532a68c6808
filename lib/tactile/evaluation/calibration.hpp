#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/calibration.hpp"
#include "tactile/results/judged_run.hpp"

namespace tactile::evaluation {

inline constexpr std::size_t reliability_bins = 15;

/// Samples by the network's largest probability; bin i holds those in (i / 15, (i + 1) / 15].
struct Reliability {
  struct Bin {
    std::uint64_t samples = 0, correct = 0;
    double confidence = 0;  ///< the sum over its samples
  };
  std::array<Bin, reliability_bins> bins{};

  void add(double confidence, bool right);  ///< the largest probability, in [0, 1], and whether its class is true
  Reliability& operator+=(const Reliability& other);
  std::uint64_t samples() const;
};

/// The expected calibration error, in [0, 1]:
///
///   ECE = sum over bins of (samples in it / all samples) * | share of them predicted correctly - mean of their largest
///   probability |
///
/// Source: Guo et al., On Calibration of Modern Neural Networks, ICML 2017, equation 3.
double calibration_error(const Reliability& reliability);  ///< 0 without samples

/// The reliability of one run's samples.
struct RunReliability : results::JudgedRun {
  Reliability reliability{};
};

results::Calibration calibration_of(std::span<const RunReliability> runs, const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
