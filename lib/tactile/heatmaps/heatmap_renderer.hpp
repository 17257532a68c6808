#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/heatmaps/cell_counts.hpp"
#include "tactile/heatmaps/sliding_counts.hpp"

namespace tactile {

enum class Denoise : std::uint8_t {
  mean,     ///< D = E * s(b - E): what the paper's text says; counts above b go to 0
  literal,  ///< D = E / (1 + exp(E + b)): its equation as printed
  none,     ///< D = E
};
enum class Resize : std::uint8_t { area, linear };

/// What a heatmap is made with; saved beside whatever was made from it.
struct HeatmapOptions {
  microseconds history{40'000};  ///< t_h, a whole number of ticks, > 0
  microseconds tick{2'000};      ///< between two heatmaps, > 0
  Denoise denoise = Denoise::mean;
  Resize resize = Resize::area;
  double factor =
      0.2;  ///< output size per input size, in (0, 1], one whole input pixel or more to an output pixel: 1/factor is whole

  friend bool operator==(const HeatmapOptions&, const HeatmapOptions&) = default;
};

void to_json(nlohmann::json& json, const HeatmapOptions& options);
void from_json(const nlohmann::json& json, HeatmapOptions& options);  ///< @throws Error

/// @throws Error  if an option is out of its range, or the history no whole number of ticks
void check(const HeatmapOptions& options);

/// The name its heatmaps are stored under: "th_040" for the default rendering of a whole number of ms, else that and the first 8
/// of its settings' hash.
std::string stored_name(const HeatmapOptions& options);

/// What cv::resize(M, {}, factor, factor) gives of a sensor's size.
SensorSize heatmap_size(SensorSize sensor, double factor);

/// Counts the events of a window that slides along a recording, and renders their heatmap, the paper's equations 2 to 5:
///
///   b = mean of E over pixels with E > 0;   D = denoised E;   H = resize(255 * D / max D)
///
/// Right for every input: docs/numerics.md tells where the equations as they stand are not. No events: all 0. The one renderer,
/// of recordings and live: moving on costs as much as there are events that come and go, rendering as much as there are cells
/// with events. Neither asks for memory, but for a window with more events than ever before. A heatmap depends on the counts
/// alone, to the last bit, not on how they came about.
///
/// Source: Faris et al., arXiv:2403.10120, equations 2 to 5; cv::resize for the sizes and the two ways of resizing.
class HeatmapRenderer {
 public:
  HeatmapRenderer(SensorSize sensor, const HeatmapOptions& options);  ///< @throws Error as `check` and `SlidingCounts`

  SensorSize size() const { return size_; }
  const HeatmapOptions& options() const { return options_; }

  void add(std::span<const Event> events) { counts_.add(events); }  ///< as of `SlidingCounts`, what it throws too
  void move_to(CameraTime tick) { counts_.move_to(tick); }          ///< likewise
  const SlidingCounts& counts() const { return counts_; }           ///< E of the window moved to
  std::uint64_t events() const { return counts_.events(); }         ///< in it

  /// Renders the window moved to.
  /// @param heatmap  [height, width] of `size()`, row by row; in [0, 255], not rounded
  void render(std::span<float> heatmap);

  /// The same, rounded half up: what is stored, and what the network sees as H / 255.
  void render(std::span<std::uint8_t> heatmap);

 private:
  void weigh();
  double value_of(int cell_x, int cell_y) const;
  template <class Number>
  void render_bytes(CellCounts<Number>& cells, std::span<std::uint8_t> heatmap);

  HeatmapOptions options_;
  SensorSize size_;
  CellGrid grid_;
  SlidingCounts counts_;
  std::vector<double> weights_;  // D by count, of the counts in the window, in units in which max D is `strongest_weight_`
  double strongest_weight_ = 1.0;
  std::vector<float> column_shares_;      // of a cell: 1 / its pixels across
  std::vector<float> row_scales_;         // of a whole weight: its part of 255, / a cell's pixels down
  std::vector<std::uint32_t> with_many_;  // blocks, while a heatmap is rendered
};

}  // namespace tactile
