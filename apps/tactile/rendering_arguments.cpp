#include "rendering_arguments.hpp"

#include <fmt/core.h>

#include "option_checks.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"

namespace tactile::cli {

Option add_mask_option(Command command, std::string& mask) {
  return command.add_option("--mask", mask, "Do not count the events of these pixels: a CSV file, as characterise writes")
      .type_name("FILE.csv")
      .check(is_existing_file());
}

heatmaps::HeatmapOptions with_mask(heatmaps::HeatmapOptions options, const std::string& mask) {
  if (!mask.empty()) options.mask = events::read_mask(mask);
  try {
    check(options);
  } catch (const Error& e) {
    const bool fits = options.history > microseconds{0} && options.history % options.tick == microseconds{0};
    throw Error(fits ? fmt::format("--factor {:g}: {}", options.factor, e.what())
                     : fmt::format("--th {:g}, --tick-us {}: {}", in_ms(options.history), options.tick.count(), e.what()));
  }
  return options;
}

void check_mask(const std::string& mask, const heatmaps::HeatmapOptions& options, events::SensorSize sensor) {
  static_cast<void>(events::PixelMask(sensor, options.mask, mask));
}

}  // namespace tactile::cli
