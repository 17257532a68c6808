#include "tactile/heatmaps/heatmap_renderer.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile {
namespace {

constexpr std::size_t small_counts = 1024;  // nearly all counts of a window lie below; larger ones are looked up
constexpr std::uint32_t no_cell = 0xFFFFFFFF;

const char* name_of(Denoise denoise) {
  switch (denoise) {
    case Denoise::mean:
      return "mean";
    case Denoise::literal:
      return "literal";
    case Denoise::none:
      return "none";
  }
  return "unknown";
}

const char* name_of(Resize resize) { return resize == Resize::area ? "area" : "linear"; }

Denoise denoise_named(const std::string& name) {
  for (const Denoise denoise : {Denoise::mean, Denoise::literal, Denoise::none}) {
    if (name == name_of(denoise)) return denoise;
  }
  throw Error("denoise '" + name + "' is unknown; expected mean, literal or none");
}

Resize resize_named(const std::string& name) {
  for (const Resize resize : {Resize::area, Resize::linear}) {
    if (name == name_of(resize)) return resize;
  }
  throw Error("resize '" + name + "' is unknown; expected area or linear");
}

int step_of(double factor) { return static_cast<int>(std::lround(1.0 / factor)); }

/// ln(D(count) / D(reference)). What the two logarithms have in common is taken away before it can cost digits: for large counts
/// the rest is a difference of whole numbers, exact where each logarithm alone would be off by more than 1.
double log_ratio(double count, double reference, double mean, Denoise denoise) {
  const double ratio = std::log(count) - std::log(reference);
  if (denoise == Denoise::none) return ratio;
  // D = E / (1 + exp(z)), and ln(1 + exp(z)) = max(z, 0) + ln(1 + exp(-|z|))
  const double shift = denoise == Denoise::mean ? -mean : mean;
  const double z = count + shift, z_of_reference = reference + shift;
  const double linear = z > 0 && z_of_reference > 0 ? count - reference : std::max(z, 0.0) - std::max(z_of_reference, 0.0);
  return ratio - linear - (std::log1p(std::exp(-std::abs(z))) - std::log1p(std::exp(-std::abs(z_of_reference))));
}

}  // namespace

void to_json(nlohmann::json& json, const HeatmapOptions& options) {
  json = {{"history_us", options.history.count()},
          {"tick_us", options.tick.count()},
          {"denoise", name_of(options.denoise)},
          {"resize", name_of(options.resize)},
          {"factor", options.factor}};
}

void from_json(const nlohmann::json& json, HeatmapOptions& options) {
  const std::string where = "heatmap settings";
  options.history = microseconds{member<std::int64_t>(json, "history_us", where)};
  options.tick = microseconds{member<std::int64_t>(json, "tick_us", where)};
  options.denoise = denoise_named(member<std::string>(json, "denoise", where));
  options.resize = resize_named(member<std::string>(json, "resize", where));
  options.factor = member<double>(json, "factor", where);
}

void check(const HeatmapOptions& options) {
  if (options.tick <= microseconds{0})
    throw Error("tick of " + std::to_string(options.tick.count()) + " us; expected more than 0");
  if (options.history <= microseconds{0} || options.history % options.tick != microseconds{0}) {
    throw Error("history of " + std::to_string(options.history.count()) + " us; expected a whole number of ticks of " +
                std::to_string(options.tick.count()) + " us, at least one");
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

SensorSize heatmap_size(SensorSize sensor, double factor) {
  // OpenCV rounds halves to the even number, as lrint does.
  return {static_cast<int>(std::lrint(sensor.width * factor)), static_cast<int>(std::lrint(sensor.height * factor))};
}

HeatmapRenderer::HeatmapRenderer(SensorSize sensor, const HeatmapOptions& options) : sensor_(sensor), options_(options) {
  check(options);
  size_ = heatmap_size(sensor, options.factor);
  if (size_.width <= 0 || size_.height <= 0) {
    throw Error("a sensor of " + std::to_string(sensor.width) + "x" + std::to_string(sensor.height) +
                " px gives no heatmap of one pixel; expected a larger factor");
  }
  step_ = step_of(options.factor);
  const auto cells_along = [&](int pixels, int cells) {
    std::vector<std::uint32_t> cell_of(static_cast<std::size_t>(pixels), no_cell);
    for (int i = 0; i < pixels && i / step_ < cells; ++i)
      cell_of[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(i / step_);
    return cell_of;
  };
  cell_of_x_ = cells_along(sensor.width, size_.width);
  cell_of_y_ = cells_along(sensor.height, size_.height);
  cell_seen_.resize(static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.height));
  small_weights_.resize(small_counts);
  count_seen_.resize(small_counts);
}

/// Finds the distinct counts of the window, and D of each in units in which max D is `strongest_weight_`.
void HeatmapRenderer::weigh(const SlidingCounts& counts) {
  distinct_.clear();
  for (const std::uint32_t pixel : counts.active()) {
    const std::uint32_t count = counts.counts()[pixel];
    if (count < small_counts) {
      if (count_seen_[count] == renderings_) continue;
      count_seen_[count] = renderings_;
    }
    distinct_.push_back({count, 0.0});
  }
  std::sort(distinct_.begin(), distinct_.end(), [](const CountWeight& a, const CountWeight& b) { return a.count < b.count; });
  distinct_.erase(std::unique(distinct_.begin(), distinct_.end(),
                              [](const CountWeight& a, const CountWeight& b) { return a.count == b.count; }),
                  distinct_.end());

  const double mean = static_cast<double>(counts.events()) / static_cast<double>(counts.active().size());
  double strongest = distinct_.front().count;
  for (const CountWeight& each : distinct_) {
    if (log_ratio(each.count, strongest, mean, options_.denoise) > 0) strongest = each.count;
  }
  for (CountWeight& each : distinct_) {
    each.weight =
        options_.denoise == Denoise::none ? each.count : std::exp(log_ratio(each.count, strongest, mean, options_.denoise));
    if (each.count < small_counts) small_weights_[each.count] = each.weight;
  }
  strongest_weight_ =
      options_.denoise == Denoise::none ? strongest : 1.0;  // whole numbers stay whole until they are divided once
}

double HeatmapRenderer::weight_of(std::uint32_t count) const {
  if (count < small_counts) return small_weights_[count];  // that of 0 is 0 for ever
  return std::lower_bound(distinct_.begin(), distinct_.end(), count,
                          [](const CountWeight& each, std::uint32_t c) { return each.count < c; })
      ->weight;
}

/// 255 times the mean D / max D of the pixels that cv::resize reads for a cell, added up in the order of the pixels.
double HeatmapRenderer::cell_value(std::span<const std::uint32_t> counts, int cell_x, int cell_y) const {
  const auto weight_at = [&](int x, int y) {
    return weight_of(counts[static_cast<std::size_t>(y) * static_cast<std::size_t>(sensor_.width) + static_cast<std::size_t>(x)]);
  };
  const int left = cell_x * step_, top = cell_y * step_;
  if (options_.resize == Resize::linear) {
    // A cell's centre lies on a pixel where the step is odd, amid four where it is even; beyond the edge the last pixel is
    // repeated.
    const int x0 = std::min(left + (step_ - 1) / 2, sensor_.width - 1), x1 = std::min(left + step_ / 2, sensor_.width - 1);
    const int y0 = std::min(top + (step_ - 1) / 2, sensor_.height - 1), y1 = std::min(top + step_ / 2, sensor_.height - 1);
    return 255.0 * (weight_at(x0, y0) + weight_at(x1, y0) + weight_at(x0, y1) + weight_at(x1, y1)) / (4.0 * strongest_weight_);
  }
  const int right = std::min(left + step_, sensor_.width), bottom = std::min(top + step_, sensor_.height);
  double sum = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) sum += weight_at(x, y);
  }
  return 255.0 * sum / (static_cast<double>(right - left) * (bottom - top) * strongest_weight_);
}

template <class Store>
void HeatmapRenderer::render_cells(const SlidingCounts& counts, Store store) {
  assert(counts.size() == sensor_ && "counts and renderer are made for one sensor");
  if (counts.active().empty()) return;
  ++renderings_;
  weigh(counts);
  const auto width = static_cast<std::uint32_t>(sensor_.width);
  for (const std::uint32_t pixel : counts.active()) {
    const std::uint32_t cell_x = cell_of_x_[pixel % width], cell_y = cell_of_y_[pixel / width];
    if (cell_x == no_cell || cell_y == no_cell) continue;
    const std::size_t cell = std::size_t{cell_y} * static_cast<std::size_t>(size_.width) + cell_x;
    if (cell_seen_[cell] == renderings_) continue;
    cell_seen_[cell] = renderings_;
    store(cell, cell_value(counts.counts(), static_cast<int>(cell_x), static_cast<int>(cell_y)));
  }
}

void HeatmapRenderer::render(const SlidingCounts& counts, std::span<float> heatmap) {
  assert(heatmap.size() == cell_seen_.size() && "a heatmap has the renderer's size");
  std::fill(heatmap.begin(), heatmap.end(), 0.0F);
  render_cells(counts, [&](std::size_t cell, double value) { heatmap[cell] = static_cast<float>(value); });
}

void HeatmapRenderer::render(const SlidingCounts& counts, std::span<std::uint8_t> heatmap) {
  assert(heatmap.size() == cell_seen_.size() && "a heatmap has the renderer's size");
  std::fill(heatmap.begin(), heatmap.end(), std::uint8_t{0});
  render_cells(counts, [&](std::size_t cell, double value) { heatmap[cell] = static_cast<std::uint8_t>(value + 0.5); });
}

}  // namespace tactile
