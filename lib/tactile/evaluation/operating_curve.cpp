#include "tactile/evaluation/operating_curve.hpp"

#include <algorithm>

namespace tactile::evaluation {

const std::vector<double>& default_thresholds() {
  static const std::vector<double> thresholds{0.01, 0.02, 0.05, 0.1,  0.2,  0.3,   0.4,   0.5,   0.6,    0.7,
                                              0.8,  0.9,  0.95, 0.98, 0.99, 0.995, 0.998, 0.999, 0.9995, 0.9999};
  return thresholds;
}

std::vector<Touch> verdicts_above(std::span<const model::Probabilities> probabilities, double threshold) {
  std::vector<Touch> verdicts(probabilities.size());
  std::transform(probabilities.begin(), probabilities.end(), verdicts.begin(), [threshold](const model::Probabilities& of) {
    const Touch likelier =
        of[static_cast<std::size_t>(Touch::slip)] > of[static_cast<std::size_t>(Touch::press)] ? Touch::slip : Touch::press;
    return static_cast<double>(of[static_cast<std::size_t>(likelier)]) >= threshold ? likelier : Touch::none;
  });
  return verdicts;
}

results::OperatingPoint operating_point(double threshold, std::span<const results::RunDetections> detections,
                                        std::span<const RunFalseAlarms> alarms, const results::BootstrapOptions& options) {
  const results::FalseAlarmTable table = false_alarm_table(alarms, options);
  return {threshold,
          delay_summary(detections, Touch::press, options),
          delay_summary(detections, Touch::slip, options),
          table.per_min,
          table.total.alarms,
          table.outside_labels_per_min,
          table.wrong_class_per_min};
}

}  // namespace tactile::evaluation
