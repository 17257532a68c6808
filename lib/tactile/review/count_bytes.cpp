#include "tactile/review/count_bytes.hpp"

#include <algorithm>

namespace tactile::review {
namespace {

void append_u32(std::string& bytes, std::uint64_t value) {
  const std::uint64_t held = std::min<std::uint64_t>(value, UINT32_MAX);
  for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(held >> shift & 0xFFU));
}

void append_header(std::string& bytes, events::SensorSize size, std::uint64_t third, std::uint64_t fourth) {
  append_u32(bytes, static_cast<std::uint64_t>(size.width));
  append_u32(bytes, static_cast<std::uint64_t>(size.height));
  append_u32(bytes, third);
  append_u32(bytes, fourth);
}

std::size_t pixels_of(events::SensorSize size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

}  // namespace

CountBytes::CountBytes(events::SensorSize size) : size_(size), planes_(2 * pixels_of(size), '\0') {}

void CountBytes::add(std::span<const events::Event> events) {
  const std::size_t pixels = pixels_of(size_);
  for (const events::Event& event : events) {
    if (event.x < 0 || event.y < 0 || event.x >= size_.width || event.y >= size_.height) continue;
    const std::size_t pixel =
        static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(event.x);
    (event.on != 0 ? on_ : off_) += 1;
    char& count = planes_[event.on != 0 ? pixel : pixels + pixel];
    if (static_cast<unsigned char>(count) < 255) ++count;
  }
}

std::string CountBytes::bytes() const {
  std::string bytes;
  bytes.reserve(16 + planes_.size());
  append_header(bytes, size_, on_, off_);
  return bytes + planes_;
}

std::string heatmap_bytes(events::SensorSize size, std::uint64_t events, std::span<const std::uint8_t> heatmap) {
  std::string bytes;
  append_header(bytes, size, events, 0);
  bytes.append(reinterpret_cast<const char*>(heatmap.data()), heatmap.size());
  return bytes;
}

}  // namespace tactile::review
