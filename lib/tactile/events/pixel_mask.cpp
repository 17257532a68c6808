#include "tactile/events/pixel_mask.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::events {

PixelMask::PixelMask(SensorSize size, std::span<const std::pair<int, int>> pixels, const std::string& where)
    : size_(size), pixels_(pixels.begin(), pixels.end()) {
  std::sort(pixels_.begin(), pixels_.end(),
            [](const auto& a, const auto& b) { return std::pair(a.second, a.first) < std::pair(b.second, b.first); });
  pixels_.erase(std::unique(pixels_.begin(), pixels_.end()), pixels_.end());
  if (pixels_.empty()) return;
  covered_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  std::string text;
  for (const auto& [x, y] : pixels_) {
    if (x < 0 || y < 0 || x >= size.width || y >= size.height)
      throw Error(fmt::format("{}: pixel ({}, {}) lies outside the sensor; expected one of {}x{} pixels", where, x, y, size.width,
                              size.height));
    covered_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)] = true;
    text += fmt::format("{},{}\n", x, y);
  }
  sha256_ = sha256_of(text);
}

std::span<const Event> PixelMask::without(std::span<const Event> events, std::vector<Event>& kept) const {
  if (empty()) return events;
  kept.clear();
  std::copy_if(events.begin(), events.end(), std::back_inserter(kept), [&](const Event& event) { return !covers(event); });
  return kept;
}

std::vector<std::pair<int, int>> read_mask_pixels(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  CsvRows rows(text);
  const auto x = rows.column("x"), y = rows.column("y");
  if (!x || !y) throw Error(file.string() + ": has no columns x and y; expected a mask, as tactile characterise writes it");
  std::vector<std::pair<int, int>> pixels;
  while (rows.next()) {
    if (rows.row().empty()) continue;
    const auto number = [&](std::size_t column) {
      const auto value = column < rows.cells().size() ? whole_number_in(rows.cells()[column]) : std::nullopt;
      if (!value || *value < 0 || *value > most_side)
        throw Error(fmt::format("{}, line {}: '{}' is no pixel; expected x,y from 0 to {}", file.string(), rows.line(),
                                rows.row(), most_side));
      return static_cast<int>(*value);
    };
    const int px = number(*x);
    pixels.emplace_back(px, number(*y));
  }
  return pixels;
}

PixelMask read_pixel_mask(const std::filesystem::path& file, SensorSize size) {
  return {size, read_mask_pixels(file), file.string()};
}

}  // namespace tactile::events
