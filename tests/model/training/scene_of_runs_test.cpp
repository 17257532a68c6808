#include "tactile/model/training/scene_of_runs.hpp"

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

TEST(SceneOfRuns, IsTheSameWithAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "sprayer", "usb-hub"}, 2);
  const windows::Dataset dataset = dataset_of(folder / "data");
  const std::vector<std::uint32_t> runs = all_runs(dataset);
  ASSERT_EQ(runs.size(), 6U);
  const auto by_one = scene_of_runs(dataset, runs, {}, 1);
  ASSERT_TRUE(by_one);
  EXPECT_EQ(by_one->runs, 6U);
  for (const unsigned threads : {2U, 7U}) EXPECT_EQ(scene_of_runs(dataset, runs, {}, threads), by_one) << threads;
}

TEST(SceneOfRuns, NamesTheFirstRecordingThatHasChanged) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "sprayer", "usb-hub"}, 2);
  const windows::Dataset dataset = dataset_of(folder / "data");
  for (const char* run : {"sprayer/02", "usb-hub/01"}) {
    fs::remove_all(folder / "data" / run);
    test::make_run(folder / "data" / run, 7);  // with another seed
  }
  for (const unsigned threads : {1U, 4U}) {
    const std::string error = test::error_of([&] { scene_of_runs(dataset, all_runs(dataset), {}, threads); });
    EXPECT_NE(error.find("sprayer/02/events.aedat4: differs from the recording that"), std::string::npos) << error;
  }
}

TEST(SceneOfRuns, IsUnknownWhereARecordingIsMissing) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 1);
  const windows::Dataset dataset = dataset_of(folder / "data");
  EXPECT_TRUE(scene_of_runs(dataset, all_runs(dataset), {}, 2));
  fs::remove(folder / "data/usb-hub/01/events.aedat4");
  EXPECT_FALSE(scene_of_runs(dataset, all_runs(dataset), {}, 2));
}

}  // namespace
}  // namespace tactile::model
