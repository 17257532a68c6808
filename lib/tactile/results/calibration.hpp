#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"

namespace tactile::results {

/// Samples whose largest probability lies in (from, to].
struct ReliabilityBin {
  double from = 0, to = 0;
  std::uint64_t samples = 0;
  double confidence = std::numeric_limits<double>::quiet_NaN();  ///< mean of their largest probability; NaN without samples
  Figure accuracy{};                                             ///< share of them predicted correctly
};

template <class Members>
void list_members(Members& members, ReliabilityBin& bin) {
  members("from", bin.from);
  members("to", bin.to);
  members("samples", bin.samples);
  members("confidence", bin.confidence);
  members("accuracy", bin.accuracy);
}

/// How well the network's probabilities agree with its accuracy.
struct Calibration {
  Figure error{};                           ///< ECE of the samples of all runs together
  std::map<std::string, Figure> objects{};  ///< ECE
  std::vector<ReliabilityBin> bins{};
};

template <class Members>
void list_members(Members& members, Calibration& calibration) {
  members("ece", calibration.error);
  members("objects", calibration.objects);
  members("bins", calibration.bins);
}

}  // namespace tactile::results
