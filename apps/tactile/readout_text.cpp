#include "readout_text.hpp"

#include <fmt/core.h>

#include <cmath>

#include "quantity_text.hpp"

namespace tactile::cli {

std::string readout_text(const events::Readout& readout) {
  using Kind = events::Readout::Kind;
  if (readout.events < 50) return "too few timestamps";
  if (readout.kind == Kind::none) return "no common period: events have individual times";
  if (readout.kind == Kind::unsteady) return fmt::format("unsteady; the shortest period is {:.0f} us", readout.period_us.value);
  std::string text = fmt::format("every {} us", measured_text(readout.period_us));
  if (readout.scan == events::Scan::none) return text + ", all pixels at once";
  const bool by_column = readout.scan == events::Scan::columns;
  const bool ascending = readout.step_us.value > 0;
  text += by_column ? fmt::format(", columns from {}", ascending ? "left to right" : "right to left")
                    : fmt::format(", rows from {}", ascending ? "top to bottom" : "bottom to top");
  return text + fmt::format(", {} us each", measured_text({std::abs(readout.step_us.value), readout.step_us.uncertainty}));
}

std::string precision_text(const events::Readout& readout) {
  if (readout.stamp_step_us == 0) return "unknown";
  if (readout.kind == events::Readout::Kind::none) return fmt::format("in steps of {} us", readout.stamp_step_us);
  return fmt::format("up to {:.0f} us after the change{}", readout.precision_us(),
                     readout.scan == events::Scan::none      ? ""
                     : readout.scan == events::Scan::columns ? "; the digits below depend only on the column"
                                                             : "; the digits below depend only on the row");
}

}  // namespace tactile::cli
