#include "tactile/video/shown_times.hpp"

#include <gtest/gtest.h>

namespace tactile::video {
namespace {

using Frames = std::vector<std::optional<std::int64_t>>;
using Shown = std::vector<std::optional<VideoTime>>;

VideoTime at(std::int64_t us) { return VideoTime{microseconds{us}}; }

const std::vector<std::int64_t> in_file{0, 33, 66, 99};

TEST(ShownTimes, WithoutRowsAreTheContainersFromTheFirstDecodedFrameOn) {
  EXPECT_EQ(shown_times(Frames{33, 66, 99}, in_file, {}), (Shown{at(0), at(33), at(66)}));
}

TEST(ShownTimes, OfRowsSkipThoseOfFramesThatCannotBeDecoded) {
  const std::vector<VideoTime> rows{at(1000), at(2000), at(3000), at(4000)};
  EXPECT_EQ(frame_indices(Frames{0, 66, 99}, in_file), (std::vector<std::size_t>{0, 2, 3}));
  EXPECT_EQ(shown_times(Frames{0, 66, 99}, in_file, rows), (Shown{at(1000), at(3000), at(4000)}));
}

TEST(ShownTimes, AfterTheLastRowFollowTheContainer) {
  const std::vector<VideoTime> rows{at(1000), at(2000)};
  EXPECT_EQ(shown_times(Frames{0, 33, 66, 99}, in_file, rows), (Shown{at(1000), at(2000), at(2033), at(2066)}));
}

TEST(ShownTimes, OfAFileWithoutTimesAreTheRowsInOrder) {
  const std::vector<VideoTime> rows{at(1000), at(2000)};
  EXPECT_EQ(shown_times(Frames{std::nullopt, std::nullopt, std::nullopt}, {}, rows), (Shown{at(1000), at(2000), std::nullopt}));
}

TEST(ShownTimes, AFrameWithoutATimeHasNone) {
  EXPECT_EQ(shown_times(Frames{0, std::nullopt, 66}, in_file, {}), (Shown{at(0), std::nullopt, at(66)}));
  EXPECT_TRUE(shown_times(Frames{}, in_file, {}).empty());
}

}  // namespace
}  // namespace tactile::video
