#include <gtest/gtest.h>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "windows/made_runs.hpp"

namespace tactile::windows {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;

/// A dataset and its runs before a reader that shares no code with what made it: check_dataset.py.
class DatasetDefinition : public testing::Test {
 protected:
  void SetUp() override {
    if (test::run_shell("/usr/bin/python3 -c 'import h5py, numpy'").exit_code != 0)
      GTEST_SKIP() << "h5py or NumPy is missing: the dataset was not checked against its definition";
  }

  /// Runs of every kind: times on both sides of 0, an onset before the first full tick and one after the last event, intervals
  /// that touch, a flagged one among others, a flagged run, one without labels, one that lacks a class.
  void make_runs_of_every_kind() const {
    const auto at = [](std::int64_t us) { return camera_time(us); };
    const auto press = [&](std::int64_t start, std::int64_t end) { return TouchInterval{Touch::press, at(start), at(end)}; };
    const auto slip = [&](std::int64_t start, std::int64_t end) { return TouchInterval{Touch::slip, at(start), at(end)}; };
    test::make_three_runs(data());
    test::make_run(data(), {.object = "box",
                            .run = "01",
                            .seed = 11,
                            .begin_us = -900'001,
                            .length_us = 3'000'000,
                            .intervals = {press(-20'000, 90'000), slip(900'000, 2'100'000), slip(2'900'000, 3'400'000)}});
    test::make_run(data(), {.object = "box",
                            .run = "02",
                            .seed = 12,
                            .begin_us = 77'000'000,
                            .length_us = 2'500'000,
                            .intervals = {press(300'000, 400'000), press(400'000, 430'000), press(800'000, 1'000'000),
                                          slip(1'500'000, 1'502'000), slip(1'600'000, 1'750'001)},
                            .flags = {{2, "sources disagree", false}, {1, "weak peak", true}}});
    test::make_run(data(),
                   {.object = "box", .run = "03", .seed = 13, .begin_us = 90'000'000, .flags = {{std::nullopt, "gap", false}}});
    test::make_run(data(), {.object = "box", .run = "04", .seed = 14, .labelled = false});
    test::make_run(data(),
                   {.object = "box", .run = "05", .seed = 15, .begin_us = 99'000'000, .intervals = {press(200'000, 260'000)}});
  }

  void check(const std::string& windows_options) const {
    const auto made = run_tactile("windows data " + windows_options, folder.path());
    ASSERT_EQ(made.exit_code, 0) << made.err;
    fs::create_directories(folder / "events");
    for (const RunFolder& run : find_runs(data())) {
      const auto npz = folder.path() / "events" / (run.object + "-" + run.run + ".npz");
      const auto converted = run_tactile("convert '" + run.events().string() + "' '" + npz.string() + "' --force", folder.path());
      ASSERT_EQ(converted.exit_code, 0) << converted.err;
    }
    const auto checked = checked_by_python();
    EXPECT_EQ(checked.exit_code, 0) << checked.out << checked.err;
  }

  test::CommandResult checked_by_python() const {
    return test::run_shell(
        "/usr/bin/python3 '" + std::string(test::data_folder) + "/../windows/check_dataset.py' data/dataset.h5 data events",
        folder.path());
  }

  fs::path data() const { return folder.path() / "data"; }
  test::TemporaryFolder folder;
};

TEST_F(DatasetDefinition, HoldsForRunsOfEveryKind) {
  make_runs_of_every_kind();
  check("");
}

TEST_F(DatasetDefinition, HoldsForOtherOptions) {
  make_runs_of_every_kind();
  check("--window-ms 40 --guard-ms 0 --history-ms 6 --seed 7 --include-flagged");
}

TEST_F(DatasetDefinition, HoldsForOtherTicks) {
  make_runs_of_every_kind();
  check("--tick-us 700 --guard-ms 33.3 --history-ms 21 --seed 18446744073709551615");
}

TEST_F(DatasetDefinition, HoldsForSimulatedRuns) {
  ASSERT_EQ(run_tactile("simulate data --preset tiny --objects fan,usb-hub --seed 3", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("label data", folder.path()).exit_code, 0);
  check("--include-flagged");
}

TEST_F(DatasetDefinition, IsSeenToBeBrokenWhereItIs) {
  make_runs_of_every_kind();
  check("");
  const auto broken = [&](const std::string& lines) {
    fs::copy_file(data() / "dataset.h5", folder / "whole.h5", fs::copy_options::overwrite_existing);
    fs::copy_file(data() / "dataset.events.h5", folder / "whole.events.h5", fs::copy_options::overwrite_existing);
    write_whole(folder / "break.py",
                "import h5py, numpy as np\nf = h5py.File('data/dataset.h5', 'r+')\ne = h5py.File('data/dataset.events.h5', "
                "'r+')\n" +
                    lines + "\n");
    EXPECT_EQ(test::run_shell("/usr/bin/python3 break.py", folder.path()).exit_code, 0);
    const auto checked = checked_by_python();
    fs::rename(folder / "whole.h5", data() / "dataset.h5");
    fs::rename(folder / "whole.events.h5", data() / "dataset.events.h5");
    return checked.exit_code == 1;
  };
  EXPECT_TRUE(broken("t = f['/samples/t_us']; t[5] = t[5] + 1"));
  EXPECT_TRUE(broken("l = f['/samples/label']; i = np.flatnonzero(l[:] == 1)[0]; l[i] = 2"));
  EXPECT_TRUE(broken("s = f['/intervals/start_us']; s[0] = s[0] - 1"));
  EXPECT_TRUE(broken("x = e['/events/x']; x[100] = x[100] ^ 1"));
  EXPECT_TRUE(broken("s = f['/runs/labels_sha256']; s[0] = s[1]"));
  EXPECT_FALSE(broken("pass"));
}

}  // namespace
}  // namespace tactile::windows
