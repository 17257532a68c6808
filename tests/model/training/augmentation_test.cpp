#include "tactile/model/training/augmentation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace tactile::model {
namespace {

constexpr events::SensorSize size{6, 5};

std::vector<std::uint8_t> counted() {
  std::vector<std::uint8_t> cells(30);
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<std::uint8_t>(i + 1);
  return cells;
}

TEST(Augment, WithoutOptionsChangesAndDrawsNothing) {
  auto cells = counted();
  Random random(1), untouched(1);
  augment(cells, size, {}, random);
  EXPECT_EQ(cells, counted());
  EXPECT_EQ(random.bits(), untouched.bits());
}

TEST(Augment, FlipsGiveTheFourMirrorImages) {
  const auto original = counted();
  std::set<std::vector<int>> seen, expected;
  for (const bool x : {false, true}) {
    for (const bool y : {false, true}) {
      std::vector<int> image;
      for (int row = 0; row < size.height; ++row) {
        for (int column = 0; column < size.width; ++column) {
          const int from_row = y ? size.height - 1 - row : row, from_column = x ? size.width - 1 - column : column;
          image.push_back(original[static_cast<std::size_t>(from_row * size.width + from_column)]);
        }
      }
      expected.insert(image);
    }
  }
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    auto cells = original;
    augment(cells, size, {.flip = true}, random);
    seen.emplace(cells.begin(), cells.end());
  }
  EXPECT_EQ(seen, expected);
}

TEST(Augment, ShiftsMoveAllCellsAlikeAndLetEmptyOnesIn) {
  const auto original = counted();
  std::set<std::pair<int, int>> seen;
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    auto cells = original;
    augment(cells, size, {.shift = true}, random);
    // The middle cell shows the shift; every other cell must agree.
    bool explained = false;
    for (int dy = -4; dy <= 4 && !explained; ++dy) {
      for (int dx = -4; dx <= 4 && !explained; ++dx) {
        bool fits = true;
        for (int y = 0; y < size.height; ++y) {
          for (int x = 0; x < size.width; ++x) {
            const int from_x = x - dx, from_y = y - dy;
            const bool inside = from_x >= 0 && from_x < size.width && from_y >= 0 && from_y < size.height;
            const int expected = inside ? original[static_cast<std::size_t>(from_y * size.width + from_x)] : 0;
            fits = fits && cells[static_cast<std::size_t>(y * size.width + x)] == expected;
          }
        }
        if (fits) seen.emplace(dx, dy);
        explained = fits;
      }
    }
    ASSERT_TRUE(explained);
  }
  EXPECT_EQ(seen.size(), 81U);  // -4 ... 4 each way
}

}  // namespace
}  // namespace tactile::model
