#include "tactile/heatmaps/byte_blocks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "tactile/core/random.hpp"

namespace tactile::heatmaps {
namespace {

/// Counts of pixels of a sensor, changed by one again and again.
template <class Number>
struct RandomCells {
  RandomCells(const CellGrid& grid_, std::uint32_t largest, Random& random) : grid(grid_), cells(grid_) {
    const typename CellCounts<Number>::Change change(cells);
    counts.resize(static_cast<std::size_t>(grid.sensor.width * grid.sensor.height));
    for (std::size_t i = 0; i < counts.size() * 6; ++i) {
      const auto pixel = static_cast<std::size_t>(random.below(counts.size()));
      const int x = static_cast<int>(pixel) % grid.sensor.width, y = static_cast<int>(pixel) / grid.sensor.width;
      const std::uint32_t from = counts[pixel], to = from == largest || (from > 0 && random.below(3) == 0) ? from - 1 : from + 1;
      change(cells.place_of(x, y), from, to);
      counts[pixel] = to;
    }
  }
  CellGrid grid;
  CellCounts<Number> cells;
  std::vector<std::uint32_t> counts;
};

template <class Number>
void expect_true_bytes(const CellGrid& grid, std::uint32_t largest, Random& random) {
  RandomCells<Number> random_cells(grid, largest, random);
  CellCounts<Number>& cells = random_cells.cells;
  WholeWeights weights{};
  for (std::int32_t& weight : weights)
    weight = whole_weight(random.below(4) == 0 ? std::round(random.uniform()) : random.uniform());
  weights.front() = weights.back() = 0;
  const std::vector<float> row(static_cast<std::size_t>(grid.cells.height),
                               255.0F / static_cast<float>(grid.read * whole_weight(1.0)));
  const std::vector<float> column(static_cast<std::size_t>(grid.cells.width) + CellCounts<Number>::block_cells,
                                  1.0F / static_cast<float>(grid.read));
  const ByteScales scales{.weights = weights, .row = row.data(), .column = column.data()};
  const auto size = static_cast<std::size_t>(grid.cells.width * grid.cells.height);
  std::vector<std::uint8_t> bytes(size + 1, 0), plain_bytes(size + 1, 0);
  std::vector<std::uint32_t> with_many(cells.blocks().size()), plain_with_many(cells.blocks().size());
  CellCounts<Number> plain_cells = cells;
  const std::size_t plain_count =
      byte_blocks_plainly(plain_cells, scales, grid.cells.width, std::span(plain_bytes).first(size), plain_with_many);
  const std::size_t count = byte_blocks(cells, scales, grid.cells.width, std::span(bytes).first(size), with_many);
  EXPECT_EQ(bytes, plain_bytes);
  EXPECT_EQ(std::vector(with_many.begin(), with_many.begin() + static_cast<std::ptrdiff_t>(count)),
            std::vector(plain_with_many.begin(), plain_with_many.begin() + static_cast<std::ptrdiff_t>(plain_count)));
  // Both versions marked the blocks that have lost events: a repetition changes nothing.
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  byte_blocks(cells, scales, grid.cells.width, std::span(bytes).first(size), with_many);
  EXPECT_EQ(bytes, plain_bytes);

  std::vector<std::uint32_t> expected_with_many;
  for (std::uint32_t index = 0; index < cells.blocks().size(); ++index) {
    const auto& block = cells.blocks()[index];
    bool any_many = false;
    for (std::uint32_t lane = 0; lane < cells.block_cells && static_cast<int>(block.column + lane) < grid.cells.width; ++lane) {
      double sum = 0;
      for (int y = 0; y < grid.read; ++y) {
        for (int x = 0; x < grid.read; ++x) {
          const int pixel_x = static_cast<int>(block.column + lane) * grid.step + grid.first + x;
          const int pixel_y = static_cast<int>(block.row) * grid.step + grid.first + y;
          if (pixel_x >= grid.sensor.width || pixel_y >= grid.sensor.height) continue;
          const std::uint32_t pixel_count = random_cells.counts[static_cast<std::size_t>(pixel_y * grid.sensor.width + pixel_x)];
          if (pixel_count > 0 && pixel_count < cells.many) sum += weights[pixel_count];
          any_many = any_many || pixel_count >= cells.many;
        }
      }
      const double value = 255.0 * sum / (whole_weight(1.0) * static_cast<double>(grid.read * grid.read));
      EXPECT_NEAR(bytes[block.heatmap_index + lane], value, 0.5004) << index << ' ' << lane;
    }
    if (any_many) expected_with_many.push_back(index);
  }
  with_many.resize(count);
  EXPECT_EQ(with_many, expected_with_many);
}

TEST(ByteBlocks, AreTheSameOnEveryProcessorAndTheSumsOfTheirWeights) {
  Random random(3);
  for (int round = 0; round < 6; ++round) {
    const events::SensorSize sensor{static_cast<int>(40 + random.below(300)), static_cast<int>(30 + random.below(60))};
    for (const int step : {1, 2, 5, 10, 15}) {
      const CellGrid all{
          .sensor = sensor, .cells = {sensor.width / step, sensor.height / step}, .step = step, .first = 0, .read = step};
      CellGrid central = all;
      central.first = (step - 1) / 2, central.read = 2 - step % 2;
      for (const std::uint32_t largest : {1U, 4U, 14U, 20U}) {
        expect_true_bytes<std::uint8_t>(all, largest, random);
        expect_true_bytes<std::uint8_t>(central, largest, random);
        expect_true_bytes<std::uint32_t>(all, largest, random);
      }
    }
  }
}

TEST(ByteBlocks, HoldAllPixelsOfTheLargestCellsAtOneCount) {
  for (const std::uint32_t count : {1U, 7U, 14U}) {
    CellCounts<std::uint8_t> cells({.sensor = {15, 15}, .cells = {1, 1}, .step = 15, .first = 0, .read = 15});
    const CellCounts<std::uint8_t>::Change change(cells);
    for (int pixel = 0; pixel < 225; ++pixel) {
      for (std::uint32_t from = 0; from < count; ++from) change(cells.place_of(pixel % 15, pixel / 15), from, from + 1);
    }
    WholeWeights weights{};
    weights[count] = whole_weight(1.0);
    const float row = 255.0F / 15 / static_cast<float>(whole_weight(1.0));
    const std::vector<float> column(17, 1.0F / 15);
    std::uint8_t byte = 0;
    std::uint32_t with_many = 0;
    EXPECT_EQ(byte_blocks(cells, {.weights = weights, .row = &row, .column = column.data()}, 1, {&byte, 1}, {&with_many, 1}), 0U);
    EXPECT_EQ(byte, 255);
  }
}

TEST(CellCounts, TakeABlockForWhatItWasUntilItIsSeenToBeLess) {
  using Indexes = std::vector<std::uint32_t>;
  // Blocks beyond the first 64, each different.
  CellCounts<std::uint8_t> cells({.sensor = {200, 120}, .cells = {40, 24}, .step = 5, .first = 0, .read = 5});
  ASSERT_EQ(cells.blocks().size(), 72U);
  const auto indexes = [&](bool of_high) {
    Indexes found;
    for (std::uint32_t i = 0; i < cells.blocks().size(); ++i) {
      const auto [low, high] = cells.active_blocks(i / 64 * 64);
      if (((of_high ? high : low) >> i % 64 & 1) != 0) found.push_back(i);
    }
    return found;
  };
  const auto low = [&] { return indexes(false); };
  const auto high = [&] { return indexes(true); };
  EXPECT_TRUE(low().empty() && high().empty());
  const CellCounts<std::uint8_t>::Change change(cells);
  for (std::uint32_t from = 0; from < 200; ++from) change(cells.place_of(100, 5), from, from + 1);
  for (std::uint32_t from = 0; from < 4; ++from) change(cells.place_of(199, 119), from, from + 1);
  for (std::uint32_t from = 0; from < 3; ++from) change(cells.place_of(0, 0), from, from + 1);
  EXPECT_EQ(low(), (Indexes{0}));
  EXPECT_EQ(high(), (Indexes{4, 71}));
  change(cells.place_of(199, 119), 4, 3);
  for (std::uint32_t from = 3; from > 0; --from) change(cells.place_of(0, 0), from, from - 1);
  const WholeWeights weights{};  // what weighs nothing is there all the same
  const std::vector<float> row(24, 1.0F), column(56, 1.0F);
  std::vector<std::uint8_t> bytes(960);
  Indexes with_many(72);
  EXPECT_EQ(byte_blocks(cells, {.weights = weights, .row = row.data(), .column = column.data()}, 40, bytes, with_many), 1U);
  EXPECT_EQ(with_many[0], 4U);
  EXPECT_EQ(low(), (Indexes{71}));
  EXPECT_EQ(high(), (Indexes{4}));
}

}  // namespace
}  // namespace tactile::heatmaps
