#include "tactile/windows/verify_dataset.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"
#include "windows/written_dataset.hpp"

namespace tactile::windows {
namespace {

using test::mentions;

namespace fs = std::filesystem;

class VerifyDataset : public testing::Test {
 protected:
  fs::path data() const { return folder.path() / "data"; }
  fs::path file() const { return data() / "dataset.h5"; }

  /// Run fan/`run`: the events of a recording of 4 s from `begin_us` to `end_us`, with a press and a slip in it.
  void make_piece(const std::string& run, std::int64_t begin_us, std::int64_t end_us, std::int64_t press_us, std::int64_t slip_us,
                  std::size_t keep_one_in = 1) const {
    test::LabelledRun labelled{.run = run, .begin_us = 5'000'000, .length_us = 4'000'000};
    const std::vector<events::Event> recorded = test::random_events(labelled);
    labelled.intervals = {{Touch::press, camera_time(press_us), camera_time(press_us + 60'000)},
                          {Touch::slip, camera_time(slip_us), camera_time(slip_us + 60'000)}};
    const RunFolder made = test::make_run(data(), labelled);
    fs::remove(made.events());
    events::RecordingWriter writer(made.events(), {events::event_stream_declaration(labelled.sensor, "DVXplorer_TEST")});
    std::vector<events::Event> piece;
    for (std::size_t i = 0; i < recorded.size(); i += keep_one_in) {
      const std::int64_t t = us_of(recorded[i].t) - labelled.begin_us;
      if (t >= begin_us && t < end_us) piece.push_back(recorded[i]);
    }
    writer.write_events(0, piece);
    writer.close();
  }

  test::TemporaryFolder folder;
};

TEST_F(VerifyDataset, FindsAPieceOfARecordingThatTwoRunsShare) {
  make_piece("01", 0, 2'000'000, 300'000, 1'600'000);
  make_piece("02", 1'500'000, 4'000'000, 2'500'000, 3'300'000);
  write_dataset(data(), file());
  const DatasetCheck check = verify_dataset(data(), file());
  EXPECT_EQ(check.pairs_at_one_time, 1U);
  ASSERT_FALSE(check.differences.empty());
  EXPECT_TRUE(mentions(check.differences, "events in its windows during the recording of fan/")) << check.differences.front();
  EXPECT_TRUE(mentions(check.differences, "training windows share events with test windows"));
  const auto result = test::run_tactile("windows --verify", folder.path());
  EXPECT_EQ(result.exit_code, 2) << result.out << result.err;
}

TEST_F(VerifyDataset, FindsItIfOneOfThemWasFiltered) {
  make_piece("01", 0, 2'000'000, 300'000, 1'600'000);
  make_piece("02", 1'500'000, 4'000'000, 2'500'000, 3'300'000, 5);
  write_dataset(data(), file());
  EXPECT_TRUE(mentions(verify_dataset(data(), file()).differences, "events in its windows during the recording of fan/"));
}

TEST_F(VerifyDataset, LetsRecordingsOverlapWhereNoWindowLies) {
  make_piece("01", 0, 2'000'000, 300'000, 900'000);
  make_piece("02", 1'998'500, 4'000'000, 2'500'000, 3'300'000);
  write_dataset(data(), file());
  const Dataset dataset(file());
  for (const events::Event& event : dataset.events(0))
    ASSERT_LT(event.t, camera_time(6'998'500)) << "the seed put a window at the end";
  const DatasetCheck check = verify_dataset(data(), file());
  EXPECT_EQ(check.differences, std::vector<std::string>{});
  EXPECT_EQ(check.pairs_at_one_time, 1U);
}

TEST_F(VerifyDataset, TakesOtherRecordingsOfTheSameTimeForWhatTheyAre) {
  // A camera whose clock restarts with each recording: events are equal only by chance.
  for (const int run : {1, 2, 3}) {
    test::make_run(data(),
                   {.run = "0" + std::to_string(run), .seed = static_cast<std::uint64_t>(run), .begin_us = 0, .mean_gap_us = 2});
  }
  write_dataset(data(), file());
  const DatasetCheck check = verify_dataset(data(), file());
  EXPECT_EQ(check.differences, std::vector<std::string>{});
  EXPECT_EQ(check.pairs_at_one_time, 3U);
  EXPECT_GT(check.equal_by_chance, 0U);
  const auto result = test::run_tactile("windows --verify", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_NE(result.out.find("pairs, events equal by chance"), std::string::npos) << result.out;
}

TEST_F(VerifyDataset, FindsEventsThatAreNotThoseOfTheRuns) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  // Another dataset's events of the same length under this one's manifest: only their comparison shows it.
  const auto broken = test::run_shell(
      "/usr/bin/python3 -c \"import h5py; f = h5py.File('dataset.events.h5', 'r+'); f['events/y'][7] = f['events/y'][7] ^ 1\"",
      data());
  if (broken.exit_code != 0) GTEST_SKIP() << "h5py is missing: this test did not run";
  EXPECT_EQ(verify_dataset(data(), file()).differences,
            std::vector<std::string>{"fan/01: its events differ from those in the histories of its samples"});
}

TEST_F(VerifyDataset, RefusesSamplesAndIntervalsOfARunThatIsNotThere) {
  for (const std::string table : {"samples", "intervals"}) {
    fs::remove_all(data());
    test::make_three_runs(data());
    write_dataset(data(), file());
    const auto broken = test::run_shell("/usr/bin/python3 -c \"import h5py; f = h5py.File('dataset.h5', 'r+'); f['" + table +
                                            "/run'][-1] = len(f['runs/object'])\"",
                                        data());
    if (broken.exit_code != 0) GTEST_SKIP() << "h5py is missing: this test did not run";
    const std::string error = test::error_of([&] { Dataset dataset(file()); });
    EXPECT_NE(error.find(table == "samples" ? "the samples are not sorted by run and time" : "an interval belongs to no run"),
              std::string::npos)
        << error;
  }
}

TEST_F(VerifyDataset, ReportsDamageAndEndsWithTwo) {
  test::make_three_runs(data());
  EXPECT_NE(test::error_of([&] { verify_dataset(data(), file()); }).find("no such dataset"), std::string::npos);
  EXPECT_EQ(test::run_tactile("windows --verify", folder.path()).exit_code, 1);
  write_dataset(data(), file());
  const std::string whole = read_text(data() / "dataset.events.h5");
  write_whole(data() / "dataset.events.h5", whole.substr(0, whole.size() / 2));
  EXPECT_EQ(verify_dataset(data(), file()).differences.size(), 1U);
  EXPECT_EQ(test::run_tactile("windows --verify", folder.path()).exit_code, 2);
}

TEST_F(VerifyDataset, NamesWhyARunIsNoLongerAmongThoseToUse) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  const auto runs = find_runs(data());
  const std::string labels = read_text(runs.front().labels());
  fs::remove(runs.front().labels());
  const DatasetCheck unlabelled = verify_dataset(data(), file());
  ASSERT_EQ(unlabelled.differences.size(), 1U);
  EXPECT_NE(unlabelled.differences[0].find(runs.front().name() + ": is in the dataset but no longer among the runs to use: "),
            std::string::npos)
      << unlabelled.differences[0];
  EXPECT_NE(unlabelled.differences[0].find("label"), std::string::npos) << unlabelled.differences[0];
  write_whole(runs.front().labels(), labels);
  write_whole(runs.front().labels(), "{");
  const DatasetCheck broken = verify_dataset(data(), file());
  ASSERT_EQ(broken.differences.size(), 1U);
  EXPECT_NE(broken.differences[0].find("labels.json"), std::string::npos) << broken.differences[0];
}

}  // namespace
}  // namespace tactile::windows
