#include "tactile/characterise/passages.hpp"

#include <gtest/gtest.h>

#include "tactile/core/random.hpp"

namespace tactile::characterise {
namespace {

/// An edge crosses 40 columns of 40 pixels in 2 s. It gives `on` events in each pixel, and half a second later another edge
/// gives `off`.
void move_edges(PassageMeter& meter, int on, int off) {
  for (std::int64_t column = 0; column < 40; ++column) {
    if (column % 5 == 0) meter.begin_part();
    for (int i = 0; i < std::max(on, off); ++i) {
      for (std::size_t row = 0; row < 40; ++row) {
        const std::size_t pixel = row * 40 + static_cast<std::size_t>(column);
        const std::int64_t t = 50'000 * column + 3'000 * i;
        if (i < on) meter.add(pixel, true, t);
        if (i < off) meter.add(pixel, false, t + 25'000);
      }
    }
  }
  meter.end_recording(2);
}

TEST(Passages, HaveTheEventsOfEachEdge) {
  PassageMeter touched({40, 40}), quiet({40, 40});
  move_edges(touched, 3, 5);
  quiet.end_recording(2);
  const Passages found = passages(touched, quiet);
  EXPECT_DOUBLE_EQ(found.on.value, 3);
  EXPECT_DOUBLE_EQ(found.off.value, 5);
  EXPECT_EQ(found.on_count, 38 * 40) << "a pixel of the first or last row has only one neighbour that fires";
}

TEST(Passages, AreNotNoise) {
  PassageMeter touched({40, 40}), quiet({40, 40});
  Random random(1);
  const auto add_noise = [&](PassageMeter& meter) {
    for (std::int64_t t = 0; t < 2'000'000; t += static_cast<std::int64_t>(600 * random.exponential()) + 1)
      meter.add(random.below(1600), random.uniform() < 0.5, t);
  };
  add_noise(quiet);
  quiet.end_recording(2);
  move_edges(touched, 4, 2);
  add_noise(touched);
  touched.end_recording(2);
  const Passages found = passages(touched, quiet);
  EXPECT_NEAR(found.on.value, 4, std::max(0.25, 3 * found.on.uncertainty));
  EXPECT_NEAR(found.off.value, 2, std::max(0.25, 3 * found.off.uncertainty));
}

TEST(Passages, NeedNeighboursThatFireToo) {
  PassageMeter touched({40, 40}), quiet({40, 40});
  touched.begin_part();
  for (std::int64_t i = 0; i < 10; ++i) touched.add(820, true, 1000 * i);  // a pixel by itself
  touched.end_recording(1);
  EXPECT_EQ(passages(touched, quiet).on_count, 0);
}

}  // namespace
}  // namespace tactile::characterise
