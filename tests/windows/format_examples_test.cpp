#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "windows/made_runs.hpp"

namespace tactile::windows {
namespace {

using test::run_tactile;

/// The ```python blocks of the pages on formats.
std::vector<std::string> examples() {
  const std::string pages = std::string(test::data_folder) + "/../../docs/format/";
  std::istringstream page(read_text(pages + "dataset.md") + read_text(pages + "recordings.md"));
  std::vector<std::string> blocks;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```")) {
      inside = line == "```python";
      if (inside) blocks.emplace_back();
    } else if (inside) {
      blocks.back() += line + "\n";
    }
  }
  return blocks;
}

/// Runs the only example that has `part`, which needs these modules; skips the test if they are missing.
class FormatExamples : public testing::Test {
 protected:
  void SetUp() override {
    test::make_three_runs(folder / "data");
    ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
    ASSERT_EQ(run_tactile("heatmaps --th 40", folder.path()).exit_code, 0);
    ASSERT_EQ(run_tactile("convert data/fan/01/events.aedat4 recording.h5", folder.path()).exit_code, 0);
    ASSERT_EQ(run_tactile("convert data/fan/01/events.aedat4 events.npz", folder.path()).exit_code, 0);
  }

  std::string printed_by(const std::string& part, const std::string& more = "") const {
    std::vector<std::string> found;
    for (const std::string& example : examples()) {
      if (example.find(part) != std::string::npos) found.push_back(example);
    }
    EXPECT_EQ(found.size(), 1U) << "examples with " << part;
    if (found.empty()) return {};
    write_whole(folder / "example.py", found.front() + more);
    const auto result = test::run_shell("/usr/bin/python3 example.py", folder.path());
    EXPECT_EQ(result.exit_code, 0) << found.front() << result.err;
    return result.out;
  }
  static bool has(const std::string& modules) {
    return test::run_shell("/usr/bin/python3 -c 'import " + modules + "'").exit_code == 0;
  }

  test::TemporaryFolder folder;
};

TEST_F(FormatExamples, ReadADatasetWithH5py) {
  if (!has("h5py")) GTEST_SKIP() << "h5py is missing (Debian's python3-h5py): the example did not run";
  EXPECT_NE(printed_by("first, count =").find("fan (90, 6, 8) 40000 "), std::string::npos);
}

TEST_F(FormatExamples, TrainOnADatasetWithPyTorch) {
  if (!has("h5py, torch"))
    GTEST_SKIP() << "h5py or PyTorch is missing (Debian's python3-h5py, python3-torch): the example did not run";
  const std::string printed = printed_by("torch.utils.data.Dataset", R"(
import numpy
assert len(train) == 180, len(train)  # run 01 of two objects
everything = Samples("data/dataset.h5", keep=lambda object, run: True)
assert len(everything) == 270
for i in (0, 100, 269):
    heatmap, label = everything[i]
    assert heatmap.dtype == torch.float32 and heatmap.shape == (1, 6, 8) and 0 <= heatmap.min() and heatmap.max() <= 1
    f = h5py.File("data/dataset.h5")
    assert numpy.array_equal((heatmap[0] * 255).round().numpy(), f["/heatmaps/th_040"][i]) and label == f["/samples/label"][i]
)");
  EXPECT_EQ(printed, "180 samples, torch.Size([20, 1, 6, 8])\n");
}

TEST_F(FormatExamples, ReadARecordingWithH5py) {
  if (!has("h5py")) GTEST_SKIP() << "h5py is missing (Debian's python3-h5py): the example did not run";
  const std::string events = std::to_string(test::random_events({}).size());
  EXPECT_EQ(printed_by("recording.h5"), events + " 40 30 DVXplorer_TEST\n");
}

TEST_F(FormatExamples, ReadEventsWithNumPy) {
  if (!has("numpy")) GTEST_SKIP() << "NumPy is missing (Debian's python3-numpy): the example did not run";
  EXPECT_EQ(printed_by("events.npz").find(std::to_string(test::random_events({}).size()) + " "), 0U);
}

}  // namespace
}  // namespace tactile::windows
