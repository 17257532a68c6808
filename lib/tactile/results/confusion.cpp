#include "tactile/results/confusion.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"

namespace tactile::results {

Confusion& Confusion::operator+=(const Confusion& other) {
  for (std::size_t i = 0; i < touch_count; ++i) {
    for (std::size_t j = 0; j < touch_count; ++j) counts[i][j] += other.counts[i][j];
  }
  return *this;
}

std::uint64_t Confusion::samples() const {
  std::uint64_t sum = 0;
  for (const auto& row : counts) {
    for (const std::uint64_t count : row) sum += count;
  }
  return sum;
}

std::uint64_t Confusion::correct() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < touch_count; ++i) sum += counts[i][i];
  return sum;
}

std::optional<double> Confusion::accuracy() const {
  if (samples() == 0) return std::nullopt;
  return static_cast<double>(correct()) / static_cast<double>(samples());
}

void to_json(nlohmann::json& json, const Confusion& confusion) { json = confusion.counts; }

void from_json(const JsonView& json, Confusion& confusion) {
  const auto refuse = [&] { throw Error(json.where() + " does not have three rows of three counts"); };
  const std::vector<JsonView> rows = json.items();
  if (rows.size() != touch_count) refuse();
  for (std::size_t i = 0; i < touch_count; ++i) {
    const std::vector<std::uint64_t> row = rows[i].counts();
    if (row.size() != touch_count) refuse();
    std::copy(row.begin(), row.end(), confusion.counts[i].begin());
  }
}

}  // namespace tactile::results
