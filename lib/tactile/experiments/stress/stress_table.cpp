#include "tactile/experiments/stress/stress_table.hpp"

#include <fmt/core.h>

#include <cmath>

#include "tactile/core/csv.hpp"

namespace tactile::stress {
namespace {

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.9g}", value) : ""; }

std::string figure(const results::Figure& of) {
  const auto bound = [](const std::optional<double>& value) { return value ? number(*value) : ""; };
  return fmt::format(",{},{},{}", number(of.value), bound(of.low), bound(of.high));
}

std::string row_of(const results::StressPoint& point) {
  std::string row = figure(point.accuracy) + figure(point.accuracy_change);
  for (const results::StressedTouch* touch : {&point.press, &point.slip}) {
    row += figure(touch->within_50_ms) + figure(touch->delays.median_of_all_ms.ms) + figure(touch->delays.quantile_of_all_ms.ms) +
           figure(touch->delays.missed);
  }
  const results::FalseAlarmTable& alarms = point.false_alarms;
  return row + figure(alarms.per_min) + figure(alarms.outside_labels_per_min) + figure(alarms.outside_motion_per_min) +
         figure(alarms.wrong_class_per_min) + figure(alarms.outside_labels_share) + figure(alarms.none_in_alarm_share) +
         figure(alarms.wrong_class_share);
}

}  // namespace

std::string stress_csv(const results::Stress& stress) {
  std::string csv = "model,trainings,on,name,unit,severity";
  for (const char* column :
       {"accuracy", "accuracy_change", "press_within_50_ms", "press_median_ms", "press_p90_ms", "press_missed",
        "slip_within_50_ms", "slip_median_ms", "slip_p90_ms", "slip_missed", "false_alarms_per_min", "outside_labels_per_min",
        "outside_motion_per_min", "wrong_class_per_min", "in_alarm_outside_labels", "in_alarm_of_none", "wrong_class_share"})
    csv += fmt::format(",{0},{0}_low,{0}_high", column);
  csv += "\n";
  for (const results::StressedModel& model : stress.models) {
    for (const auto* curves : {&model.curves, &model.quiet}) {
      for (const results::StressCurve& curve : *curves) {
        const char* on = curves == &model.quiet ? "quiet" : curve.is_world ? "world" : "runs";
        for (const results::StressPoint& point : curve.points)
          csv += fmt::format("{},{},{},{},{},{:g}{}\n", model.name, model.trainings.size(), on, curve.name, csv_cell(curve.unit),
                             point.severity, row_of(point));
      }
    }
  }
  return csv;
}

}  // namespace tactile::stress
