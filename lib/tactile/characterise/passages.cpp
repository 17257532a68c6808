#include "tactile/characterise/passages.hpp"

#include <algorithm>

namespace tactile::characterise {

PassageMeter::PassageMeter(events::SensorSize size)
    : width_(static_cast<std::size_t>(size.width)), height_(static_cast<std::size_t>(size.height)) {
  for (auto& rows : rows_) rows.resize(width_ * height_);
}

bool PassageMeter::neighbours_fire(std::size_t pixel, std::int64_t t_us, const std::vector<Row>& rows) const {
  const std::size_t x = pixel % width_, y = pixel / width_;
  int firing = 0;
  for (std::size_t v = y - std::min<std::size_t>(y, 1); v <= std::min(height_ - 1, y + 1); ++v) {
    for (std::size_t u = x - std::min<std::size_t>(x, 1); u <= std::min(width_ - 1, x + 1); ++u) {
      if (u == x && v == y) continue;
      if (t_us - rows[v * width_ + u].latest <= together_us && ++firing == 2) return true;
    }
  }
  return false;
}

void PassageMeter::end_row(Row& row, std::size_t polarity) {
  if (row.has_neighbours) {
    if (parts_.empty()) parts_.emplace_back();
    parts_.back()[polarity].passages += 1;
    parts_.back()[polarity].events += row.events;
  }
  row.events = 0;
  row.has_neighbours = false;
}

void PassageMeter::add(std::size_t pixel, bool on, std::int64_t t_us) {
  std::vector<Row>& rows = rows_[on ? 1 : 0];
  Row& row = rows[pixel];
  if (row.events > 0 && t_us - row.latest > longest_pause_us) end_row(row, on ? 1 : 0);
  ++row.events;
  row.latest = std::max(row.latest, t_us);
  if (!row.has_neighbours) row.has_neighbours = neighbours_fire(pixel, t_us, rows);
}

void PassageMeter::end_recording(double seconds) {
  for (std::size_t polarity = 0; polarity < rows_.size(); ++polarity) {
    for (Row& row : rows_[polarity]) {
      if (row.events > 0) end_row(row, polarity);
      row = {};
    }
  }
  seconds_ += seconds;
}

Passages passages(const PassageMeter& touched, const PassageMeter& quiet) {
  Passages passages;
  const double share = quiet.seconds_ > 0 ? touched.seconds_ / quiet.seconds_ : 0;
  for (std::size_t polarity = 0; polarity < 2; ++polarity) {
    PassageMeter::Sums background;
    for (const auto& part : quiet.parts_) {
      background.passages += share * part[polarity].passages;
      background.events += share * part[polarity].events;
    }
    std::vector<CountPart> parts;
    const auto count = static_cast<double>(touched.parts_.size());
    double total = 0;
    for (const auto& part : touched.parts_) {
      parts.push_back({part[polarity].events - background.events / count, part[polarity].passages - background.passages / count});
      total += parts.back().measure;
    }
    (polarity == 1 ? passages.on : passages.off) = ratio_of(parts);
    (polarity == 1 ? passages.on_count : passages.off_count) = std::max(0.0, total);
  }
  return passages;
}

}  // namespace tactile::characterise
