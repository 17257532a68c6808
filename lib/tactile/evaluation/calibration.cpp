#include "tactile/evaluation/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tactile/evaluation/accuracy.hpp"

namespace tactile::evaluation {
namespace {

Reliability sum_of(std::span<const RunReliability> runs, const RunsByObject& chosen) {
  Reliability sum;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) sum += runs[i].reliability;
  }
  return sum;
}

}  // namespace

void Reliability::add(double confidence, bool right) {
  const double place = std::ceil(confidence * static_cast<double>(reliability_bins)) - 1;
  Bin& bin = bins[static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(reliability_bins - 1)))];
  ++bin.samples;
  bin.correct += right ? 1 : 0;
  bin.confidence += confidence;
}

Reliability& Reliability::operator+=(const Reliability& other) {
  for (std::size_t i = 0; i < reliability_bins; ++i) {
    bins[i].samples += other.bins[i].samples;
    bins[i].correct += other.bins[i].correct;
    bins[i].confidence += other.bins[i].confidence;
  }
  return *this;
}

std::uint64_t Reliability::samples() const {
  std::uint64_t sum = 0;
  for (const Bin& bin : bins) sum += bin.samples;
  return sum;
}

double calibration_error(const Reliability& reliability) {
  double error = 0;
  for (const Reliability::Bin& bin : reliability.bins) error += std::abs(static_cast<double>(bin.correct) - bin.confidence);
  return error / std::max(1.0, static_cast<double>(reliability.samples()));
}

results::Calibration calibration_of(std::span<const RunReliability> runs, const results::BootstrapOptions& options) {
  const auto objects = results_by_object(runs, [](const RunReliability& run) { return run.reliability.samples() > 0; });
  const CrossedResults chosen = without_names(objects);
  const Statistic error = [runs](const RunsByObject& drawn) -> std::optional<double> {
    return calibration_error(sum_of(runs, drawn));
  };
  results::Calibration calibration;
  for (const auto& [name, cells] : objects) calibration.objects[name] = figure_of_object(cells, error, options, {0, 1});
  calibration.error = figure_over_objects(chosen, error, options, {0, 1});
  const Reliability all = sum_of(runs, all_of(chosen));
  for (std::size_t i = 0; i < reliability_bins; ++i) {
    const Reliability::Bin& bin = all.bins[i];
    const auto n = static_cast<double>(bin.samples);
    const Statistic accuracy = [runs, i](const RunsByObject& drawn) -> std::optional<double> {
      std::uint64_t samples = 0, correct = 0;
      for (const auto& object : drawn) {
        for (const std::size_t run : object) {
          samples += runs[run].reliability.bins[i].samples;
          correct += runs[run].reliability.bins[i].correct;
        }
      }
      if (samples == 0) return std::nullopt;
      return static_cast<double>(correct) / static_cast<double>(samples);
    };
    calibration.bins.push_back({static_cast<double>(i) / reliability_bins, static_cast<double>(i + 1) / reliability_bins,
                                bin.samples, n > 0 ? bin.confidence / n : std::numeric_limits<double>::quiet_NaN(),
                                figure_over_objects(chosen, accuracy, options, {0, 1})});
  }
  return calibration;
}

}  // namespace tactile::evaluation
