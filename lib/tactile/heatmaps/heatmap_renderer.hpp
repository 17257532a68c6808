#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

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

/// Renders the counts of a window as a heatmap, the paper's equations 2 to 5:
///
///   b = mean of E over pixels with E > 0;   D = denoised E;   H = resize(255 * D / max D)
///
/// Computed in the log domain, so that D / max D is right where D itself underflows. No events: all 0.
/// Its cost follows the pixels with events and the output, not the sensor; its result depends on the counts alone, not on the
/// order in which they came about.
///
/// Source: Faris et al., arXiv:2403.10120, equations 2 to 5; cv::resize for the sizes and the two ways of resizing.
class HeatmapRenderer {
 public:
  HeatmapRenderer(SensorSize sensor, const HeatmapOptions& options);  ///< @throws Error as `check`

  SensorSize size() const { return size_; }
  const HeatmapOptions& options() const { return options_; }

  /// @param counts  of this renderer's sensor
  /// @param heatmap [height, width] of `size()`, row by row; in [0, 255], not rounded
  void render(const SlidingCounts& counts, std::span<float> heatmap);

  /// The same, rounded half up: what is stored, and what the network sees as H / 255.
  void render(const SlidingCounts& counts, std::span<std::uint8_t> heatmap);

 private:
  struct CountWeight {
    std::uint32_t count;
    double weight;
  };

  void weigh(const SlidingCounts& counts);
  double weight_of(std::uint32_t count) const;
  double cell_value(std::span<const std::uint32_t> counts, int cell_x, int cell_y) const;
  template <class Store>
  void render_cells(const SlidingCounts& counts, Store store);

  SensorSize sensor_;
  HeatmapOptions options_;
  SensorSize size_;
  int step_ = 5;                       // sensor pixels to a heatmap pixel, each way
  std::vector<double> small_weights_;  // of counts below `small_weights_.size()`; only those in `distinct_` are of this window
  std::vector<CountWeight> distinct_;  // the counts of this window, ascending, each once
  double strongest_weight_ = 1.0;
  std::vector<std::uint32_t> cell_of_x_, cell_of_y_;
  std::vector<std::uint64_t> cell_seen_;  // the last rendering that a cell was part of
  std::vector<std::uint64_t> count_seen_;
  std::uint64_t renderings_ = 0;
};

}  // namespace tactile
