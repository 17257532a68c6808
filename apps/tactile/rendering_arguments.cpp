#include "rendering_arguments.hpp"

#include <fmt/core.h>

#include <cmath>

#include "option_checks.hpp"
#include "tactile/core/error.hpp"

namespace tactile::cli {

void add_rendering_options(Command command, RenderingArguments& args) {
  command
      .add_option("--denoise", args.denoise,
                  "Noise reduction: mean (the paper's text), literal (the paper's printed equation) or none")
      .check(one_of({"mean", "literal", "none"}))
      .show_default();
  command
      .add_option("--resize", args.resize,
                  "Resizing: area (mean of each block) or linear (OpenCV's default, one pixel of each block)")
      .check(one_of({"area", "linear"}))
      .show_default();
  command.add_option("--factor", args.factor, "Heatmap size divided by sensor size; 1 divided by a whole number")
      .check(in_range(0.001, 1.0))
      .show_default();
  command.add_option("--tick-us", args.tick_us, "Time between two ticks [us]; samples of a dataset must be at ticks")
      .check(in_range(std::int64_t{1}, std::int64_t{1'000'000}))
      .show_default();
  add_mask_option(command, args.mask);
}

Option add_mask_option(Command command, std::string& mask) {
  return command.add_option("--mask", mask, "Do not count the events of these pixels: a CSV file, as characterise writes")
      .type_name("FILE.csv")
      .check(is_existing_file());
}

heatmaps::HeatmapOptions heatmap_options(double history_ms, const RenderingArguments& args) {
  nlohmann::json settings = {{"history_us", whole_us(history_ms, "--th").count()},
                             {"tick_us", args.tick_us},
                             {"denoise", args.denoise},
                             {"resize", args.resize},
                             {"factor", args.factor}};
  if (!args.mask.empty()) settings["mask"] = events::read_mask(args.mask);
  const auto options = settings.get<heatmaps::HeatmapOptions>();
  try {
    check(options);
  } catch (const Error& e) {
    const bool fits = options.history > microseconds{0} && options.history % options.tick == microseconds{0};
    throw Error(fits ? fmt::format("--factor {:g}: {}", args.factor, e.what())
                     : fmt::format("--th {:g}, --tick-us {}: {}", history_ms, args.tick_us, e.what()));
  }
  return options;
}

void check_mask(const RenderingArguments& args, const heatmaps::HeatmapOptions& options, events::SensorSize sensor) {
  static_cast<void>(events::PixelMask(sensor, options.mask, args.mask));
}

microseconds whole_us(double ms, const std::string& option) {
  const double us = ms * 1000;
  if (std::abs(us - std::round(us)) > 1e-6)
    throw Error(fmt::format("{} {}: not a whole number of us; expected at most three decimals", option, ms));
  return microseconds{std::llround(us)};
}

}  // namespace tactile::cli
