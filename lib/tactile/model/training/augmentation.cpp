#include "tactile/model/training/augmentation.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>

namespace tactile::model {
namespace {

constexpr int farthest = 4;  // largest shift of a heatmap [cells]

/// Moves the cells by `by` towards higher indexes (lower ones if negative); new cells are 0.
void move_cells(std::span<std::uint8_t> cells, std::ptrdiff_t by) {
  const auto gap = std::min(static_cast<std::ptrdiff_t>(cells.size()), std::abs(by));
  if (by > 0) {
    std::move_backward(cells.begin(), cells.end() - gap, cells.end());
    std::fill(cells.begin(), cells.begin() + gap, std::uint8_t{0});
  } else if (by < 0) {
    std::move(cells.begin() + gap, cells.end(), cells.begin());
    std::fill(cells.end() - gap, cells.end(), std::uint8_t{0});
  }
}

int drawn_shift(Random& random) { return static_cast<int>(random.below(2 * farthest + 1)) - farthest; }

}  // namespace

void augment(std::span<std::uint8_t> heatmap, events::SensorSize size, const Augmentation& augmentation, Random& random) {
  const auto width = static_cast<std::size_t>(size.width), height = static_cast<std::size_t>(size.height);
  assert(heatmap.size() == width * height);
  const auto row = [&](std::size_t y) { return heatmap.subspan(y * width, width); };
  if (augmentation.flip) {
    if (random.below(2) == 1) {
      for (std::size_t y = 0; y < height; ++y) std::reverse(row(y).begin(), row(y).end());
    }
    if (random.below(2) == 1) {
      for (std::size_t y = 0; y < height / 2; ++y) std::swap_ranges(row(y).begin(), row(y).end(), row(height - 1 - y).begin());
    }
  }
  if (augmentation.shift) {
    const int right = drawn_shift(random), down = drawn_shift(random);
    move_cells(heatmap, static_cast<std::ptrdiff_t>(down) * size.width);
    for (std::size_t y = 0; y < height; ++y) move_cells(row(y), right);
  }
}

}  // namespace tactile::model
