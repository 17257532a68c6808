#include "tactile/live/minute.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::live {

void Minute::add(double t_s, std::span<const double> values) {
  nlohmann::json row = nlohmann::json::array({t_s});
  for (const double value : values) row.push_back(std::isfinite(value) ? nlohmann::json(value) : nlohmann::json());
  rows_.push_back(std::move(row));
  if (rows_.size() <= most_steps) return;
  rows_.pop_front();
  ++first_;
}

nlohmann::json Minute::since(std::uint64_t number) const {
  const std::uint64_t from = std::clamp(number, first_, next()) - first_;
  nlohmann::json rows = nlohmann::json::array();
  for (auto row = rows_.begin() + static_cast<std::ptrdiff_t>(from); row != rows_.end(); ++row) rows.push_back(*row);
  return rows;
}

}  // namespace tactile::live
