#include "tactile/experiments/stress/stress_table.hpp"

#include <fmt/core.h>

#include <vector>

#include "tactile/core/csv_table.hpp"
#include "tactile/results/figure_cells.hpp"

namespace tactile::stress {
namespace {

std::vector<std::string> cells_of(const results::StressPoint& point) {
  const results::OperatingPoint& whole = point.whole;
  const auto figures = {&point.accuracy,          &point.accuracy_change,    &whole.alarms_per_min,
                        &whole.within_50_ms,      &whole.press_median_ms.ms, &whole.press_p90_ms.ms,
                        &whole.slip_median_ms.ms, &whole.slip_p90_ms.ms,     &whole.missed,
                        &whole.wrong_class,       &whole.false_slips};
  std::vector<std::string> cells;
  for (const results::Figure* figure : figures) {
    for (std::string& cell : results::figure_cells(*figure)) cells.push_back(std::move(cell));
  }
  for (const results::CensoredQuantile* quantile :
       {&whole.press_median_ms, &whole.press_p90_ms, &whole.slip_median_ms, &whole.slip_p90_ms})
    cells.emplace_back(quantile->is_lower_bound ? "1" : "0");
  return cells;
}

std::string columns() {
  std::string columns = "model,trainings,on,name,unit,severity";
  for (const char* column : {"accuracy", "accuracy_change", "alarms_per_min", "within_50_ms", "press_median_ms", "press_p90_ms",
                             "slip_median_ms", "slip_p90_ms", "missed", "wrong_class", "false_slips"})
    columns += fmt::format(",{0},{0}_low,{0}_high", column);
  for (const char* quantile : {"press_median", "press_p90", "slip_median", "slip_p90"})
    columns += fmt::format(",{}_is_lower_bound", quantile);
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
