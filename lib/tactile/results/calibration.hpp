#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"

namespace tactile::results {

/// Samples whose largest probability lies in (from, to].
struct ReliabilityBin {
  double from = 0, to = 0;
  std::uint64_t samples = 0;
  double confidence = std::numeric_limits<double>::quiet_NaN();  ///< mean of their largest probability; NaN without samples
  Figure accuracy{};  ///< share of them predicted correctly; objects drawn first, then runs
};

/// How well the network's probabilities agree with its accuracy.
struct Calibration {
  Figure error;                           ///< ECE of the samples of all runs together; objects drawn first, then runs
  std::map<std::string, Figure> objects;  ///< ECE; runs drawn
  std::vector<ReliabilityBin> bins;
};

/// {"ece", "objects", "bins": [{"from", "to", "samples", "confidence", "accuracy"}]}
void to_json(nlohmann::json& json, const Calibration& calibration);
void from_json(const JsonView& json, Calibration& calibration);

}  // namespace tactile::results
