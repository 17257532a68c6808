#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/older_dataset.hpp"
#include "tactile/windows/older_heatmaps.hpp"
#include "tactile/windows/run_samples.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"
#include "windows/written_dataset.hpp"

namespace tactile::windows {
namespace {

namespace fs = std::filesystem;
using test::LabelledRun;
using Names = std::vector<std::string>;

/// Runs with so many events that the windows of each fill more than a chunk of 65,536 rows.
class GrowingDataset : public testing::Test {
 protected:
  void SetUp() override {
    for (const LabelledRun& run : {fan_01, fan_03, mug_01}) test::make_run(data(), run);
    write_dataset(data(), file());
  }

  /// Expects the bytes of a dataset that is made at once from the same runs.
  void expect_as_made_at_once(const fs::path& dataset, const WindowsOptions& options = {}) {
    const fs::path once = folder.path() / ("once" + std::to_string(++made_at_once_));
    fs::create_directories(once);
    for (const auto& entry : fs::directory_iterator(data())) {
      if (entry.is_directory()) fs::copy(entry.path(), once / entry.path().filename(), fs::copy_options::recursive);
    }
    const DatasetSummary summary = write_dataset(once, once / "dataset.h5", options);
    EXPECT_EQ(summary.read_runs.size(), Dataset(dataset).runs().size());
    EXPECT_FALSE(summary.changes);
    EXPECT_EQ(sha256_of_file(dataset), sha256_of_file(once / "dataset.h5"));
    EXPECT_EQ(sha256_of_file(dataset.parent_path() / "dataset.events.h5"), sha256_of_file(once / "dataset.events.h5"));
  }

  static void expect_changes(const DatasetSummary& summary, const Names& added, const Names& changed, const Names& dropped,
                             const Names& kept) {
    ASSERT_TRUE(summary.changes);
    EXPECT_EQ(summary.changes->added, added);
    EXPECT_EQ(summary.changes->changed, changed);
    EXPECT_EQ(summary.changes->dropped, dropped);
    EXPECT_EQ(summary.changes->kept, kept);
  }

  /// Gives the first stored event of the older dataset's run the other polarity, as no recording has it.
  bool turn_first_event_of(std::uint32_t run_index) {
    const std::uint64_t first = Dataset(file()).runs()[run_index].first_event;
    const hdf5::Session session;
    hdf5::Id out = hdf5::open_file(data() / "dataset.events.h5", true);
    {
      const hdf5::Id table = hdf5::open_table(out, "events/on", "on");
      std::uint8_t on = 0;
      hdf5::read_rows(table, H5T_NATIVE_UINT8, &on, first, 1, "on");
      on = 1 - on;
      const hdf5::Id in_file(H5Dget_space(table), H5Sclose);
      const hsize_t at = first, one = 1;
      const hdf5::Id given(H5Screate_simple(1, &one, nullptr), H5Sclose);
      H5Sselect_hyperslab(in_file, H5S_SELECT_SET, &at, nullptr, &one, nullptr);
      EXPECT_GE(H5Dwrite(table, H5T_NATIVE_UINT8, given, in_file, H5P_DEFAULT, &on), 0);
    }
    out.close("dataset.events.h5");
    return true;
  }

  fs::path data() const { return folder.path() / "data"; }
  fs::path file() const { return data() / "dataset.h5"; }

  const LabelledRun fan_01{.object = "fan", .run = "01", .seed = 1, .mean_gap_us = 5},
      fan_03{.object = "fan", .run = "03", .seed = 2, .mean_gap_us = 5},
      mug_01{.object = "mug", .run = "01", .seed = 3, .begin_us = -700'123, .mean_gap_us = 5};
  test::TemporaryFolder folder;

 private:
  int made_at_once_ = 0;
};

TEST_F(GrowingDataset, ReadsOnlyAnAddedRunWhereverItStands) {
  ASSERT_GT(Dataset(file()).runs()[0].events, 70'000U);
  for (const LabelledRun& added : {LabelledRun{.object = "mug", .run = "02", .seed = 5, .mean_gap_us = 7},
                                   LabelledRun{.object = "fan", .run = "02", .seed = 4, .mean_gap_us = 6},
                                   LabelledRun{.object = "box", .run = "01", .seed = 6, .mean_gap_us = 8}}) {
    const std::string name = added.object + "/" + added.run;
    SCOPED_TRACE(name);
    Names before;
    {
      const Dataset dataset(file());
      for (const DatasetRun& run : dataset.runs()) before.push_back(name_of(run));
    }
    test::make_run(data(), added);
    const DatasetSummary summary = write_dataset(data(), file());
    EXPECT_EQ(summary.outcome, DatasetSummary::Outcome::replaced);
    expect_changes(summary, {name}, {}, {}, before);
    EXPECT_EQ(summary.read_runs, Names{name});
    EXPECT_EQ(summary.warnings, Names{});
    expect_as_made_at_once(file());
  }
}

TEST_F(GrowingDataset, TakesALongRunInPiecesAfterAChangedOne) {
  test::make_run(data(), {.object = "mug", .run = "02", .seed = 5, .mean_gap_us = 1});
  write_dataset(data(), file());
  ASSERT_GT(Dataset(file()).runs().back().events, 1'000'000U);  // pieces of 262 144, of which none is in a copied chunk
  LabelledRun changed = fan_01;
  changed.seed = 9;
  fs::remove_all(data() / "fan/01");
  test::make_run(data(), changed);
  const DatasetSummary summary = write_dataset(data(), file(), {}, 3);
  expect_changes(summary, {}, {"fan/01"}, {}, {"fan/03", "mug/01", "mug/02"});
  EXPECT_EQ(summary.read_runs, Names{"fan/01"});
  expect_as_made_at_once(file());
}

TEST_F(GrowingDataset, ReadsNothingToDropARun) {
  fs::rename(data() / "fan/01", folder / "fan-01");
  const DatasetSummary summary = write_dataset(data(), file());
  expect_changes(summary, {}, {}, {"fan/01"}, {"fan/03", "mug/01"});
  EXPECT_EQ(summary.read_runs, Names{});
  expect_as_made_at_once(file());
  fs::rename(folder / "fan-01", data() / "fan/01");
  EXPECT_EQ(write_dataset(data(), file()).read_runs, Names{"fan/01"});
  expect_as_made_at_once(file());
}

TEST_F(GrowingDataset, ReadsOnlyARelabelledRun) {
  LabelledRun relabelled = fan_03;
  relabelled.intervals[0].end = camera_time(250'000);
  labels::write_labels(data() / "fan/03/labels.json", test::labels_of(relabelled));
  const DatasetSummary summary = write_dataset(data(), file());
  expect_changes(summary, {}, {"fan/03"}, {}, {"fan/01", "mug/01"});
  EXPECT_EQ(summary.read_runs, Names{"fan/03"});
  expect_as_made_at_once(file());
}

TEST_F(GrowingDataset, IsTheSameAfterALabelWasConfirmedOrAnEditUndone) {
  const std::string before = Dataset(file()).manifest_hash();
  const fs::path labelled = data() / "fan/03/labels.json";
  labels::Labels labels = labels::read_labels(labelled);
  labels.intervals[0].confirmed = true;
  labels.history.entries.push_back(
      {.who = "ada", .when = "2026-01-01T00:00:00Z", .what = "moved and moved back", .why = {}, .change = {}});
  labels::write_labels(labelled, labels);
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(summary.outcome, DatasetSummary::Outcome::unchanged);
  EXPECT_EQ(summary.manifest_hash, before);
}

TEST_F(GrowingDataset, KnowsTheLabelsOfADatasetOfVersion01ByTheFile) {
  const Dataset dataset(file());
  DatasetRun run = dataset.runs()[0];
  const RunFolder folder = run_folder_at(data() / name_of(run));
  EXPECT_TRUE(has_labels(run, folder));
  run.labels_sha256 = sha256_of_file(folder.labels());
  EXPECT_TRUE(has_labels(run, folder)) << "as version 0.1 stored it";
  run.labels_sha256 = dataset.runs()[2].labels_sha256;
  EXPECT_FALSE(has_labels(run, folder));
  const OlderDataset older(dataset);
  ASSERT_NE(older.run_of(folder, run.events_sha256), nullptr);
  EXPECT_EQ(name_of(*older.run_of(folder, run.events_sha256)), name_of(run));
  EXPECT_EQ(older.run_of(folder, dataset.runs()[1].events_sha256), nullptr) << "another recording";
}

TEST_F(GrowingDataset, ReadsOnlyAnotherRecordingOfARun) {
  LabelledRun recorded = fan_01;
  recorded.seed = 77;
  fs::remove_all(data() / "fan/01");
  test::make_run(data(), recorded);
  const DatasetSummary summary = write_dataset(data(), file());
  expect_changes(summary, {}, {"fan/01"}, {}, {"fan/03", "mug/01"});
  EXPECT_EQ(summary.read_runs, Names{"fan/01"});
  expect_as_made_at_once(file());
}

TEST_F(GrowingDataset, ReadsARunAgainWhoseSamplesAreOthers) {
  const WindowsOptions options{.sampling = {.seed = 2}};
  const DatasetSummary summary = write_dataset(data(), file(), options);
  expect_changes(summary, {}, {"fan/01", "fan/03", "mug/01"}, {}, {});
  EXPECT_EQ(summary.read_runs, (Names{"fan/01", "fan/03", "mug/01"}));
  expect_as_made_at_once(file(), options);
  const WindowsOptions longer{.sampling = {.history = 60ms, .seed = 2}};
  EXPECT_EQ(write_dataset(data(), file(), longer).read_runs.size(), 3U);
  expect_as_made_at_once(file(), longer);
}

TEST_F(GrowingDataset, ReadsNothingIfNothingHasChanged) {
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(summary.outcome, DatasetSummary::Outcome::unchanged);
  EXPECT_EQ(summary.read_runs, Names{});
}

TEST_F(GrowingDataset, TakesTheEventsOfKeptRunsFromTheOlderDataset) {
  // Run 0 begins with chunks that are copied as they are; run 1 is read and stored again in other chunks.
  ASSERT_TRUE(turn_first_event_of(0) && turn_first_event_of(1));
  const Dataset older(file());
  const auto first_of = [](const Dataset& dataset, std::uint32_t run) { return dataset.events(run, 0, 1).at(0); };
  const events::Event of_fan = first_of(older, 0), of_mug = first_of(older, 1);
  test::make_run(data(), {.object = "fan", .run = "02", .seed = 4, .mean_gap_us = 6});
  EXPECT_EQ(write_dataset(data(), file()).read_runs, Names{"fan/02"});
  const Dataset grown(file());
  EXPECT_EQ(first_of(grown, 0), of_fan);
  EXPECT_EQ(first_of(grown, 2), of_mug);
}

TEST_F(GrowingDataset, IsMadeInFullOfADamagedOlderOne) {
  test::make_run(data(), {.object = "mug", .run = "02", .seed = 5, .mean_gap_us = 7});
  const std::string events = read_text(data() / "dataset.events.h5");
  const auto chunk_at = [&](std::uint64_t row) {
    const hdf5::Session session;
    const hdf5::Id in = hdf5::open_file(data() / "dataset.events.h5", false);
    const auto chunk = hdf5::read_packed_chunk(hdf5::open_table(in, "events/t_us", "t"), row - row % 65'536, "t");
    return events.find(std::string(chunk.begin(), chunk.end()));
  };
  const std::uint64_t last = [&] {
    const Dataset dataset(file());
    return dataset.runs().back().first_event + dataset.runs().back().events - 1;
  }();
  // A chunk that is copied as it is, and one that is read.
  for (const auto& [place, which] : {std::pair(chunk_at(0), "the first"), std::pair(chunk_at(last), "the last")}) {
    SCOPED_TRACE(which);
    ASSERT_NE(place, std::string::npos);
    std::string damaged = events;
    damaged.replace(place + 100, 6, "damage");
    write_whole(data() / "dataset.events.h5", damaged);
    const DatasetSummary summary = write_dataset(data(), file());
    EXPECT_EQ(summary.read_runs.size(), 4U);
    EXPECT_FALSE(summary.changes);
    ASSERT_EQ(summary.warnings.size(), 1U);
    EXPECT_NE(summary.warnings[0].find("runs of the previous dataset cannot be kept"), std::string::npos) << summary.warnings[0];
    EXPECT_NE(summary.warnings[0].find("the checksum of a chunk differs"), std::string::npos) << summary.warnings[0];
    EXPECT_EQ(summary.warnings[0].find("Remove"), std::string::npos) << summary.warnings[0];
    expect_as_made_at_once(file());
    fs::remove(file());
    fs::rename(data() / "mug/02", folder / "mug-02");
    write_dataset(data(), file());
    fs::rename(folder / "mug-02", data() / "mug/02");
  }
}

TEST_F(GrowingDataset, IsMadeInFullOfOneFromAnEarlierVersion) {
  const auto make_older = [&] {
    const hdf5::Session session;
    hdf5::Id out = hdf5::open_file(file(), true);
    for (const char* name : {"runs/first_us", "runs/last_us", "runs/event_digest"}) H5Ldelete(out, name, H5P_DEFAULT);
    out.close("dataset.h5");
  };
  make_older();
  EXPECT_FALSE(Dataset(file()).runs()[0].recording);
  EXPECT_EQ(write_dataset(data(), file()).read_runs.size(), 3U) << "although no run has changed";
  EXPECT_TRUE(Dataset(file()).runs()[0].recording);
  make_older();
  test::make_run(data(), {.object = "mug", .run = "02", .seed = 5, .mean_gap_us = 7});
  EXPECT_EQ(write_dataset(data(), file()).read_runs.size(), 4U);
  expect_as_made_at_once(file());
}

TEST_F(GrowingDataset, ChecksTheSensorOfRunsWithoutReadingThem) {
  test::make_run(data(), {.object = "mug", .run = "02", .seed = 5, .mean_gap_us = 7});
  fs::remove(data() / "fan/01/run.json");  // the recording has the size too
  EXPECT_EQ(write_dataset(data(), file()).read_runs, Names{"mug/02"});
  write_run_info(run_folder_at(data() / "fan/01"),
                 {.object = "fan", .run = "01", .session = "", .complete = true, .width = 50, .height = 30});
  const DatasetSummary summary = write_dataset(data(), file());
  ASSERT_EQ(summary.errors.size(), 1U);
  EXPECT_NE(summary.errors[0].find("fan/01/events.aedat4: of a sensor of 40x30 px"), std::string::npos) << summary.errors[0];
  expect_changes(summary, {}, {}, {"fan/01"}, {"fan/03", "mug/01", "mug/02"});
}

TEST_F(GrowingDataset, KeepsHistoriesFromWhichARunCanBeTaken) {
  const auto history_of = [](int us, int height) {
    return StoredHeatmaps{.name = "th_002", .settings = {{"history_us", us}}, .width = 2, .height = height};
  };
  std::string source;
  {
    const Dataset dataset(file());
    const RunSamples mug = samples_by_run(dataset).at(2);
    source = source_sha256_of(dataset, mug);
    HeatmapsWriter writer(dataset, history_of(2000, 1));
    std::vector<std::uint8_t> heatmaps(2 * dataset.samples().size(), 7);
    heatmaps[std::size_t{2} * mug.first] = 9;
    test::append_to(writer, heatmaps);
    writer.commit();
  }
  fs::rename(data() / "fan", folder / "fan");
  EXPECT_EQ(write_dataset(data(), file()).changes->kept, Names{"mug/01"});
  EXPECT_TRUE(Dataset(file()).heatmap_names().empty());
  {
    const auto older = OlderHeatmaps::find(file(), history_of(2000, 1));
    ASSERT_TRUE(older);
    const auto chunks = older->chunks_of(source);
    EXPECT_EQ(chunks.size(), Dataset(file()).samples().size());
    EXPECT_EQ(hdf5::unpacked_chunk(chunks.at(0), 2, "first"), (std::vector<std::uint8_t>{9, 7}));
    EXPECT_TRUE(older->chunks_of(std::string(64, 'a')).empty());
    EXPECT_FALSE(OlderHeatmaps::find(file(), history_of(4000, 1)));
    EXPECT_FALSE(OlderHeatmaps::find(file(), history_of(2000, 2)));
  }
  EXPECT_EQ(write_dataset(data(), file()).outcome, DatasetSummary::Outcome::unchanged);
  EXPECT_TRUE(fs::exists(data() / "dataset.th_002.h5"));
  write_dataset(data(), file(), {.sampling = {.seed = 2}});  // no run has the same samples
  EXPECT_FALSE(fs::exists(data() / "dataset.th_002.h5"));
}

TEST_F(GrowingDataset, IsPrintedInOneLine) {
  test::make_run(data(), {.object = "mug", .run = "02", .seed = 5});
  fs::remove_all(data() / "fan/01");
  const auto grown = test::run_tactile("windows", folder.path());
  ASSERT_EQ(grown.exit_code, 0) << grown.err;
  EXPECT_NE(grown.out.find("\n1 run added, 1 dropped, 2 kept\n"), std::string::npos) << grown.out;
  EXPECT_EQ(grown.out.find("lost"), std::string::npos) << grown.out;
  fs::remove_all(data() / "mug/02");
  const auto json = nlohmann::json::parse(test::run_tactile("windows --json", folder.path()).out);
  EXPECT_EQ(json.at("read_runs"), nlohmann::json::array());
  EXPECT_EQ(json.at("changes"), nlohmann::json({{"added", nlohmann::json::array()},
                                                {"changed", nlohmann::json::array()},
                                                {"dropped", {"mug/02"}},
                                                {"kept", {"fan/03", "mug/01"}}}));
  const auto other_seed = test::run_tactile("windows --seed 2", folder.path());
  EXPECT_NE(other_seed.out.find("other settings: seed 2 instead of 1."), std::string::npos) << other_seed.out;
  EXPECT_NE(other_seed.out.find("\n2 runs changed\n"), std::string::npos) << other_seed.out;
  EXPECT_EQ(nlohmann::json::parse(test::run_tactile("windows --seed 2 --json", folder.path()).out).at("changes"), nullptr);
}

}  // namespace
}  // namespace tactile::windows
