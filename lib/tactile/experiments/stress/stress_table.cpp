#include "tactile/experiments/stress/stress_table.hpp"

#include <fmt/core.h>

#include <vector>

#include "tactile/core/csv_table.hpp"
#include "tactile/results/figure_cells.hpp"

namespace tactile::stress {
namespace {

std::vector<std::string> cells_of(const results::StressPoint& point) {
  std::vector<const results::Figure*> figures{&point.accuracy, &point.accuracy_change};
  for (const results::StressedTouch* touch : {&point.press, &point.slip}) {
    figures.insert(figures.end(), {&touch->within_50_ms, &touch->delays.median_of_all_ms.ms, &touch->delays.quantile_of_all_ms.ms,
                                   &touch->delays.missed});
  }
  const results::FalseAlarmTable& alarms = point.false_alarms;
  figures.insert(figures.end(),
                 {&alarms.per_min, &alarms.outside_labels_per_min, &alarms.outside_motion_per_min, &alarms.wrong_class_per_min,
                  &alarms.outside_labels_share, &alarms.none_in_alarm_share, &alarms.wrong_class_share});
  std::vector<std::string> cells;
  for (const results::Figure* figure : figures) {
    for (std::string& cell : results::figure_cells(*figure)) cells.push_back(std::move(cell));
  }
  return cells;
}

std::string columns() {
  std::string columns = "model,trainings,on,name,unit,severity";
  for (const char* column :
       {"accuracy", "accuracy_change", "press_within_50_ms", "press_median_ms", "press_p90_ms", "press_missed",
        "slip_within_50_ms", "slip_median_ms", "slip_p90_ms", "slip_missed", "false_alarms_per_min", "outside_labels_per_min",
        "outside_motion_per_min", "wrong_class_per_min", "in_alarm_outside_labels", "in_alarm_of_none", "wrong_class_share"})
    columns += fmt::format(",{0},{0}_low,{0}_high", column);
  return columns;
}

}  // namespace

std::string stress_csv(const results::Stress& stress) {
  CsvTable table(columns());
  for (const results::StressedModel& model : stress.models) {
    for (const auto* curves : {&model.curves, &model.quiet}) {
      for (const results::StressCurve& curve : *curves) {
        const char* on = curves == &model.quiet ? "quiet" : curve.is_world ? "world" : "runs";
        for (const results::StressPoint& point : curve.points)
          table.add_row(model.name, model.trainings.size(), on, curve.name, curve.unit, fmt::format("{:g}", point.severity),
                        cells_of(point));
      }
    }
  }
  return table.text();
}

}  // namespace tactile::stress
