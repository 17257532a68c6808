#include "tactile/model/training/seen_in_runs.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>
#include <vector>

#include "model/small_data.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

windows::Dataset dataset_of(const fs::path& data) {
  windows::write_dataset(data, data / "dataset.h5", {}, 1);
  return windows::Dataset(data / "dataset.h5");
}

std::vector<std::uint32_t> all_runs(const windows::Dataset& dataset) {
  std::vector<std::uint32_t> runs(dataset.runs().size());
  std::iota(runs.begin(), runs.end(), 0U);
  return runs;
}

TEST(SeenInRuns, IsTheSameWithAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "sprayer", "usb-hub"}, 2);
  const windows::Dataset dataset = dataset_of(folder / "data");
  const std::vector<std::uint32_t> runs = all_runs(dataset);
  ASSERT_EQ(runs.size(), 6U);
  const SeenInRuns by_one = seen_in(dataset, runs, {}, 1);
  EXPECT_GT(by_one.gate.ticks, 0U);
  EXPECT_GE(by_one.gate.ratios.size(), 6U);
  ASSERT_TRUE(by_one.scene);
  EXPECT_EQ(by_one.scene->runs, 6U);
  for (const unsigned threads : {2U, 7U}) {
    const SeenInRuns by_more = seen_in(dataset, runs, {}, threads);
    EXPECT_EQ(by_more.gate, by_one.gate) << threads;
    EXPECT_EQ(by_more.scene, by_one.scene) << threads;
  }
}

TEST(SeenInRuns, NamesTheFirstRecordingThatHasChanged) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "sprayer", "usb-hub"}, 2);
  const windows::Dataset dataset = dataset_of(folder / "data");
  for (const char* run : {"sprayer/02", "usb-hub/01"}) {
    fs::remove_all(folder / "data" / run);
    test::make_run(folder / "data" / run, 7);  // with another seed
  }
  for (const unsigned threads : {1U, 4U}) {
    const std::string error = test::error_of([&] { seen_in(dataset, all_runs(dataset), {}, threads); });
    EXPECT_NE(error.find("sprayer/02/events.aedat4: differs from the recording that"), std::string::npos) << error;
  }
}

TEST(SeenInRuns, HasNeitherScenesNorRatiosWhereARecordingIsMissing) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 1);
  const windows::Dataset dataset = dataset_of(folder / "data");
  const SeenInRuns whole = seen_in(dataset, all_runs(dataset), {}, 2);
  fs::remove(folder / "data/usb-hub/01/events.aedat4");
  const SeenInRuns seen = seen_in(dataset, all_runs(dataset), {}, 2);
  EXPECT_FALSE(seen.scene);
  EXPECT_TRUE(seen.gate.ratios.empty());
  EXPECT_EQ(seen.gate.limit, whole.gate.limit);
  EXPECT_EQ(seen.gate.ticks, whole.gate.ticks);
}

}  // namespace
}  // namespace tactile::model
