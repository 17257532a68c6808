#include "tactile/events/pixel_mask.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::events {

MaskPixels ordered(MaskPixels pixels) {
  std::sort(pixels.begin(), pixels.end(),
            [](const auto& a, const auto& b) { return std::pair(a.second, a.first) < std::pair(b.second, b.first); });
  pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
  return pixels;
}

PixelMask::PixelMask(SensorSize size, MaskPixels pixels, const std::string& where)
    : size_(size), pixels_(ordered(std::move(pixels))) {
  if (pixels_.empty()) return;
  covered_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  for (const auto& [x, y] : pixels_) {
    if (x < 0 || y < 0 || x >= size.width || y >= size.height) {
      throw Error(fmt::format("{}: pixel ({}, {}) lies outside the sensor; expected one of {}x{} pixels", where, x, y, size.width,
                              size.height));
    }
    covered_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)] = true;
  }
}

std::span<const Event> PixelMask::without(std::span<const Event> events, std::vector<Event>& kept) const {
  if (empty()) return events;
  kept.clear();
  std::copy_if(events.begin(), events.end(), std::back_inserter(kept), [&](const Event& event) { return !covers(event); });
  return kept;
}

MaskPixels read_mask(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  CsvRows rows(text);
  if (!rows.column("x") || !rows.column("y"))
    throw Error(file.string() + ": has no columns x and y; expected a mask, as tactile characterise writes it");
  MaskPixels pixels;
  while (rows.next_filled()) {
    const auto number = [&](std::string_view column) {
      const auto value = whole_number_in(rows[column].value_or(""));
      if (!value || *value < 0 || *value > most_side)
        throw Error(fmt::format("{}, line {}: '{}' is no pixel; expected x,y from 0 to {}", file.string(), rows.line(),
                                rows.row(), most_side));
      return static_cast<int>(*value);
    };
    const int px = number("x");
    pixels.emplace_back(px, number("y"));
  }
  return ordered(std::move(pixels));
}

}  // namespace tactile::events
