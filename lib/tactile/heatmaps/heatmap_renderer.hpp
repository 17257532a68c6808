#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/fields.hpp"
#include "tactile/events/pixel_mask.hpp"
#include "tactile/heatmaps/cell_counts.hpp"
#include "tactile/heatmaps/sliding_counts.hpp"

namespace tactile::heatmaps {

enum class Denoise : std::uint8_t {
  mean,     ///< D = E * s(b - E), as the paper's text describes it; counts above b go to 0
  literal,  ///< D = E / (1 + exp(E + b)): its equation as printed
  none,     ///< D = E
};
enum class Resize : std::uint8_t { area, linear };
inline constexpr std::array<std::string_view, 3> denoise_names{"mean", "literal", "none"};
inline constexpr std::array<std::string_view, 2> resize_names{"area", "linear"};

/// The settings of a heatmap; saved with everything that is made from it.
struct HeatmapOptions {
  microseconds history{40'000};  ///< t_h, a whole number of ticks, > 0
  microseconds tick{2'000};      ///< between two heatmaps, > 0
  Denoise denoise = Denoise::mean;
  Resize resize = Resize::area;
  double factor = 0.2;        ///< output size / input size, in (0, 1]; 1/factor must be a whole number
  events::MaskPixels mask{};  ///< pixels whose events do not count; in the JSON only if there are any

  friend bool operator==(const HeatmapOptions&, const HeatmapOptions&) = default;
};

template <class Fields>
void list_fields(Fields& fields, HeatmapOptions& o) {
  fields("history_us", o.history, 1, 100'000'000,
         {.name = "th", .meaning = "History t_h [ms], a whole number of ticks", .us = 1000});
  fields("denoise", o.denoise, denoise_names,
         {"denoise", "Noise reduction: mean (the paper's text), literal (the paper's printed equation) or none"});
  fields("resize", o.resize, resize_names,
         {"resize", "Resizing: area (mean of each block) or linear (OpenCV's default, one pixel of each block)"});
  fields("factor", o.factor, 0.001, 1, {"factor", "Heatmap size divided by sensor size; 1 divided by a whole number"});
  fields("tick_us", o.tick, 1, 1'000'000, {"tick-us", "Time between two ticks [us]; samples of a dataset must be at ticks"});
}

void to_json(nlohmann::json& json, const HeatmapOptions& options);
void from_json(const nlohmann::json& json, HeatmapOptions& options);  ///< @throws Error

/// @throws Error  if an option is out of its range, or the history is not a whole number of ticks
void check(const HeatmapOptions& options);

/// The name of stored heatmaps: "th_040" for the default rendering of a whole number of ms, otherwise with the first 8 characters
/// of the settings' hash appended.
std::string stored_name(const HeatmapOptions& options);

/// The size that cv::resize(M, {}, factor, factor) gives for a sensor's size.
events::SensorSize heatmap_size(events::SensorSize sensor, double factor);

/// Counts the events of a window that slides along a recording, and renders their heatmap, the paper's equations 2 to 5:
///
///   b = mean of E over pixels with E > 0;   D = denoised E;   H = resize(255 * D / max D)
///
/// Valid for every input; docs/numerics/ lists where the plain equations are not. Without events all values are 0. Recordings
/// and live detection use the same renderer. Advancing costs time in proportion to the events that enter and leave the window,
/// rendering in proportion to the cells with events. Neither allocates memory, except for a window with more events than ever
/// before. A heatmap depends only on the counts, to the last bit.
///
/// Source: Faris et al., arXiv:2403.10120, equations 2 to 5; cv::resize for the sizes and the two resize modes.
class HeatmapRenderer {
 public:
  HeatmapRenderer(events::SensorSize sensor, const HeatmapOptions& options);  ///< @throws Error as `check` and `SlidingCounts`

  events::SensorSize size() const { return size_; }
  const HeatmapOptions& options() const { return options_; }

  /// As `SlidingCounts::add`, without the events of masked pixels.
  void add(std::span<const events::Event> events) { counts_.add(mask_.without(events, unmasked_)); }
  void move_to(CameraTime tick) { counts_.move_to(tick); }   ///< as `SlidingCounts::move_to`
  const SlidingCounts& counts() const { return counts_; }    ///< E of the current window
  std::uint64_t events() const { return counts_.events(); }  ///< in the current window

  /// Renders the current window.
  /// @param heatmap  [height, width] of `size()`, row by row; in [0, 255], not rounded
  void render(std::span<float> heatmap);

  /// The same, rounded half up. These values are stored, and the network's input is H / 255.
  void render(std::span<std::uint8_t> heatmap);

 private:
  void weigh();
  double value_of(int cell_x, int cell_y) const;
  template <class Number>
  void render_bytes(CellCounts<Number>& cells, std::span<std::uint8_t> heatmap);

  HeatmapOptions options_;
  events::SensorSize size_;
  CellGrid grid_;
  events::PixelMask mask_;
  std::vector<events::Event> unmasked_;
  SlidingCounts counts_;
  std::vector<double> weights_;  // D by count, of the counts in the window, in units in which max D is `strongest_weight_`
  double strongest_weight_ = 1.0;
  std::vector<float> column_shares_;      // of a cell: 1 / its pixels across
  std::vector<float> row_scales_;         // of a whole weight: its part of 255, / a cell's pixels down
  std::vector<std::uint32_t> with_many_;  // blocks, while a heatmap is rendered
};

}  // namespace tactile::heatmaps
