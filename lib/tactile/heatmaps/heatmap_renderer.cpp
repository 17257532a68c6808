#include "tactile/heatmaps/heatmap_renderer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/heatmaps/byte_blocks.hpp"

namespace tactile::heatmaps {
namespace {

int step_of(double factor) { return static_cast<int>(std::lround(1.0 / factor)); }

events::SensorSize checked_size(events::SensorSize sensor, const HeatmapOptions& options) {
  check(options);
  const events::SensorSize size = heatmap_size(sensor, options.factor);
  if (size.width <= 0 || size.height <= 0) {
    throw Error("a sensor of " + std::to_string(sensor.width) + "x" + std::to_string(sensor.height) +
                " px gives no heatmap of one pixel; expected a larger factor");
  }
  return size;
}

/// The pixels that cv::resize reads. `area`: all of a cell. `linear`: those around its centre, one if the step is odd and four if
/// it is even. Outside the image it repeats the last pixel, so the result is the mean of the existing pixels.
CellGrid grid_of(events::SensorSize sensor, events::SensorSize cells, const HeatmapOptions& options) {
  const int step = step_of(options.factor);
  const bool all = options.resize == Resize::area;
  return {.sensor = sensor, .cells = cells, .step = step, .first = all ? 0 : (step - 1) / 2, .read = all ? step : 2 - step % 2};
}

/// The number of pixels of a cell along one side of a sensor with `pixels` pixels.
int pixels_read(int pixels, int cell, const CellGrid& grid) {
  return std::min(grid.read, pixels - cell * grid.step - grid.first);
}

[[maybe_unused]] std::size_t cells_of(events::SensorSize size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

}  // namespace

void to_json(nlohmann::json& json, const HeatmapOptions& options) {
  json = json_of_fields(options);
  if (!options.mask.empty()) json["mask"] = options.mask;
}

void from_json(const nlohmann::json& json, HeatmapOptions& options) {
  const std::string where = "heatmap settings";
  nlohmann::json listed = json;
  options.mask.clear();
  if (json.contains("mask")) {
    options.mask = events::ordered(member<events::MaskPixels>(json, "mask", where));
    listed.erase("mask");
  }
  read_all_fields(listed, options, where);
}

void check(const HeatmapOptions& options) {
  if (options.tick <= microseconds{0})
    throw Error("tick of " + std::to_string(options.tick.count()) + " us; expected more than 0");
  if (options.history <= microseconds{0} || options.history % options.tick != microseconds{0}) {
    const auto ms = [](microseconds time) {
      std::array<char, 32> text{};
      std::snprintf(text.data(), text.size(), "%g ms", static_cast<double>(time.count()) / 1000);
      return std::string(text.data());
    };
    throw Error("history t_h of " + ms(options.history) + "; expected a whole number of ticks of " + ms(options.tick) +
                ", at least one");
  }
  const bool in_range = options.factor > 0.0 && options.factor <= 1.0 && 1.0 / options.factor <= 32767.0;
  if (!in_range || std::abs(1.0 / options.factor - step_of(options.factor)) > 1e-9 * step_of(options.factor)) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%g", options.factor);
    throw Error("factor of " + std::string(text.data()) + "; expected 1 divided by a whole number, such as 0.2 or 0.1");
  }
}

std::string stored_name(const HeatmapOptions& options) {
  const std::int64_t whole_ms = options.history / std::chrono::milliseconds{1};
  std::string digits = std::to_string(whole_ms);
  if (digits.size() < 3) digits.insert(0, 3 - digits.size(), '0');
  const HeatmapOptions plain{.history = std::chrono::milliseconds{whole_ms}};
  return options == plain ? "th_" + digits : "th_" + digits + "-" + hash_of(nlohmann::json(options)).substr(0, 8);
}

events::SensorSize heatmap_size(events::SensorSize sensor, double factor) {
  // OpenCV rounds halves to the even number, as lrint does.
  return {static_cast<int>(std::lrint(sensor.width * factor)), static_cast<int>(std::lrint(sensor.height * factor))};
}

HeatmapRenderer::HeatmapRenderer(events::SensorSize sensor, const HeatmapOptions& options)
    : options_(options),
      size_(checked_size(sensor, options)),
      grid_(grid_of(sensor, size_, options)),
      mask_(sensor, options.mask),
      counts_(sensor, options.history, grid_),
      weights_(64),
      column_shares_(static_cast<std::size_t>(size_.width) + CellCounts<std::uint8_t>::block_cells),
      with_many_(std::visit([](const auto& cells) { return cells.blocks().size(); }, counts_.cells())) {
  for (int x = 0; x < size_.width; ++x)
    column_shares_[static_cast<std::size_t>(x)] = 1.0F / static_cast<float>(pixels_read(sensor.width, x, grid_));
  for (int y = 0; y < size_.height; ++y)
    row_scales_.push_back(255.0F / static_cast<float>(pixels_read(sensor.height, y, grid_)) / whole_weight(1.0));
}

/// D of each count in the window, relative to the largest. The exponents are differences of whole numbers, divided once, so no
/// value exceeds the range of double: docs/numerics/.
void HeatmapRenderer::weigh() {
  const CountHistogram& histogram = counts_.histogram();
  const std::uint32_t largest = histogram.largest();
  if (largest >= weights_.size()) weights_.resize(std::bit_ceil(std::size_t{largest} + 1));
  if (options_.denoise == Denoise::none) {
    histogram.for_each_count([&](std::uint32_t count) { weights_[count] = count; });
    strongest_weight_ = largest;  // exact until the only division
    return;
  }
  const auto events = static_cast<std::int64_t>(counts_.events());
  const auto active = static_cast<std::int64_t>(histogram.active_pixels());
  double strongest = 0;
  if (options_.denoise == Denoise::mean) {
    // D = E / (1 + exp(E - b)). At least one count is not above b, so max D is at least 1/2. If exp is infinite, D is 0.
    histogram.for_each_count([&](std::uint32_t count) {
      const double over_mean = static_cast<double>(count * active - events) / static_cast<double>(active);
      weights_[count] = count / (1.0 + std::exp(over_mean));
      strongest = std::max(strongest, weights_[count]);
    });
  } else {
    // D = E / (1 + exp(E + b)) decreases with E, because b >= 1. It is computed relative to that of the smallest count s,
    // E/s * exp(s - E) * (1 + exp(-s - b)) / (1 + exp(-E - b)).
    double smallest = 0, of_smallest = 0;
    histogram.for_each_count([&](std::uint32_t count) {
      const double below = 1.0 + std::exp(-static_cast<double>(count * active + events) / static_cast<double>(active));
      if (smallest == 0) smallest = count, of_smallest = below;
      weights_[count] = count / smallest * std::exp(smallest - count) * (of_smallest / below);
    });
    strongest = 1.0;
  }
  histogram.for_each_count([&](std::uint32_t count) { weights_[count] /= strongest; });
  strongest_weight_ = 1.0;
}

/// A cell's value, pixel by pixel.
double HeatmapRenderer::value_of(int cell_x, int cell_y) const {
  const int left = cell_x * grid_.step + grid_.first, across = pixels_read(grid_.sensor.width, cell_x, grid_);
  const int top = cell_y * grid_.step + grid_.first, down = pixels_read(grid_.sensor.height, cell_y, grid_);
  double sum = 0;
  for (int y = top; y < top + down; ++y) {
    const std::uint16_t* const row =
        &counts_.small_counts()[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.sensor.width)];
    for (int x = left; x < left + across; ++x) sum += weights_[row[x] < SlidingCounts::large ? row[x] : counts_.at(x, y)];
  }
  return 255.0 * sum / (static_cast<double>(across) * down * strongest_weight_);
}

template <class Number>
void HeatmapRenderer::render_bytes(CellCounts<Number>& cells, std::span<std::uint8_t> heatmap) {
  WholeWeights weights{};
  for (std::size_t count = 1; count < cells.many; ++count)
    weights[count] = whole_weight(std::min(weights_[count] / strongest_weight_, 1.0));  // arbitrary for counts that do not occur
  const std::size_t blocks_with_many = byte_blocks(
      cells, {.weights = weights, .row = row_scales_.data(), .column = column_shares_.data()}, size_.width, heatmap, with_many_);
  for (const std::uint32_t index : std::span(with_many_).first(blocks_with_many)) {
    const auto& block = cells.blocks()[index];
    for (std::uint32_t lane = 0; lane < cells.block_cells; ++lane) {
      if (cells.number(index, lane, cells.many) == 0) continue;
      const double value = value_of(static_cast<int>(block.column + lane), static_cast<int>(block.row));
      heatmap[block.heatmap_index + lane] = static_cast<std::uint8_t>(value + byte_half);
    }
  }
}

void HeatmapRenderer::render(std::span<float> heatmap) {
  assert(heatmap.size() == cells_of(size_) && "a heatmap has the renderer's size");
  std::fill(heatmap.begin(), heatmap.end(), 0.0F);
  if (counts_.events() == 0) return;
  weigh();
  const auto render_floats = [&](auto& cells) {
    for (std::uint32_t first = 0; first < cells.blocks().size(); first += cells.together) {
      const auto [low, high] = cells.active_blocks(first);
      for (std::uint64_t active = low | high; active != 0; active &= active - 1) {
        const auto& block = cells.blocks()[first + static_cast<std::uint32_t>(std::countr_zero(active))];
        const std::uint32_t lanes = std::min(cells.block_cells, static_cast<std::uint32_t>(size_.width) - block.column);
        for (std::uint32_t lane = 0; lane < lanes; ++lane)
          heatmap[block.heatmap_index + lane] =
              static_cast<float>(value_of(static_cast<int>(block.column + lane), static_cast<int>(block.row)));
      }
    }
  };
  std::visit(render_floats, counts_.cells());
}

void HeatmapRenderer::render(std::span<std::uint8_t> heatmap) {
  assert(heatmap.size() == cells_of(size_) && "a heatmap has the renderer's size");
  std::fill(heatmap.begin(), heatmap.end(), std::uint8_t{0});
  if (counts_.events() == 0) return;
  weigh();
  std::visit([&](auto& cells) { render_bytes(cells, heatmap); }, counts_.cells());
}

}  // namespace tactile::heatmaps
