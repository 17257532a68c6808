// Which runs a dataset takes, which it leaves out, and what it warns of.
#include <gtest/gtest.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"
#include "windows/written_dataset.hpp"

namespace tactile::windows {
namespace {

namespace fs = std::filesystem;
using test::mentions;
using test::message_of;
using test::WriteDataset;

TEST_F(WriteDataset, LeavesFlaggedRunsOutByDefault) {
  test::make_three_runs(data());
  test::make_run(data(), {.object = "box", .seed = 9, .flags = {{std::nullopt, "weak peak", false}}});
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(Dataset(file()).runs().size(), 3U);
  EXPECT_FALSE(summary.runs.front().in_dataset);
  EXPECT_EQ(summary.runs.front().remark, "flagged: weak peak");
  EXPECT_TRUE(mentions(summary.warnings, "box/01"));
  write_dataset(data(), file(), {.include_flagged = true});
  EXPECT_EQ(Dataset(file()).runs().size(), 4U);
}

TEST_F(WriteDataset, TakesNoSamplesFromAFlaggedIntervalAndNamesIt) {
  test::LabelledRun run;
  run.intervals.insert(run.intervals.begin() + 1, {Touch::press, camera_time(400'000), camera_time(500'000)});
  run.flags = {{1, "sources disagree", false}};
  test::make_run(data(), run);
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(summary.runs.front().samples, (std::array<std::uint64_t, 3>{30, 30, 30}));
  EXPECT_EQ(summary.runs.front().remark, "flagged and left out: press-2");
  EXPECT_TRUE(mentions(summary.warnings, "fan/01: flagged and left out: press-2"));
  EXPECT_FALSE(mentions(summary.warnings, "no samples")) << "the other press is enough";
  const Dataset dataset(file());
  EXPECT_EQ(dataset.intervals().size(), 2U);
  for (const Sample& sample : dataset.samples()) {
    const auto since_begin = between(camera_time(run.begin_us), sample.t);
    EXPECT_FALSE(since_begin > 300ms && since_begin <= 600ms) << since_begin.count();
  }
  run.flags[0].confirmed = true;
  labels::write_labels(data() / "fan/01/labels.json", test::labels_of(run));
  write_dataset(data(), file());
  EXPECT_EQ(Dataset(file()).intervals().size(), 3U);
}

TEST_F(WriteDataset, NamesARunThatLacksAClassAndGivesItNoSamples) {
  test::make_three_runs(data());
  test::make_run(data(), {.object = "box", .seed = 9, .intervals = {{Touch::press, camera_time(200'000), camera_time(260'000)}}});
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(summary.runs.front().remark, "no samples: no slip");
  EXPECT_TRUE(mentions(summary.warnings, "1 of 4 runs has no samples: no slip in box/01."));
  EXPECT_TRUE(mentions(summary.warnings, "box: left out, none of its runs has samples: no slip in box/01"));
  EXPECT_FALSE(mentions(summary.warnings, "--include-flagged")) << "no flag is the reason";
  const Dataset dataset(file());
  ASSERT_EQ(dataset.runs().size(), 4U);
  EXPECT_EQ(dataset.runs()[0].events, 0U);
  EXPECT_TRUE(dataset.events(0).empty());
  EXPECT_TRUE(std::none_of(dataset.samples().begin(), dataset.samples().end(),
                           [](const Sample& sample) { return sample.run_index == 0; }));
}

TEST_F(WriteDataset, NamesEachFlagWithItsRunsAndHowToLiftIt) {
  const std::vector<labels::LabelFlag> on_slip{{1, "its end is only known to within 232 ms", false}};
  for (const char* run : {"01", "02", "03"}) test::make_run(data(), {.object = "mug", .run = run, .seed = 1, .flags = on_slip});
  test::make_run(data(), {.object = "mug", .run = "04", .seed = 4});
  test::make_run(data(), {.object = "jar", .seed = 5, .flags = {{0, "it rings", false}, {1, "it slides", false}}});
  test::make_run(data(), {.object = "jar", .run = "02", .seed = 6, .flags = {{std::nullopt, "weak peak", false}}});
  test::make_run(data(), {.object = "jar", .run = "03", .seed = 7, .labelled = false});
  const DatasetSummary summary = write_dataset(data(), file());
  const std::string view = "'tactile view " + (data() / "jar/01").string() + "'";
  EXPECT_TRUE(mentions(summary.warnings,
                       "6 of 7 runs have no samples: press-1 and slip-1 are flagged in jar/01; the whole run is flagged in "
                       "jar/02; no labels in jar/03; slip-1 is flagged in mug/01, mug/02, mug/03. Look at it with " +
                           view));
  EXPECT_TRUE(mentions(summary.warnings, "If a flagged label is right, confirm it by 'tactile label --confirm "));
  EXPECT_TRUE(mentions(summary.warnings, "jar: left out, none of its runs has samples: "));
  EXPECT_FALSE(mentions(summary.warnings, "mug: left out"));
  EXPECT_EQ(summary.runs[3].remark, "no samples: slip-1 is flagged (its end is only known to within 232 ms)");
}

TEST_F(WriteDataset, StrictRefusesAnObjectWithoutAnyWholeRun) {
  test::make_three_runs(data());
  test::make_run(data(), {.object = "mug", .seed = 8, .flags = {{1, "it slides", false}}});
  const WindowsOptions strict{.strict = true};
  EXPECT_EQ(message_of([&] { write_dataset(data(), file(), strict); }),
            "mug: left out, none of its runs has samples: slip-1 is flagged in mug/01; expected a run with samples of every "
            "object, as --strict asks for");
  EXPECT_FALSE(fs::exists(file()));
  test::make_run(data(), {.object = "mug", .run = "02", .seed = 9});
  EXPECT_EQ(write_dataset(data(), file(), strict).outcome, DatasetSummary::Outcome::written) << "one whole run is enough";
  fs::remove_all(data() / "mug/02");
  EXPECT_NO_THROW(write_dataset(data(), file(), {.include_flagged = true, .strict = true}));
}

TEST_F(WriteDataset, LeavesARunOutThatSeemsToLastAYear) {
  test::make_three_runs(data());
  const test::LabelledRun one{.object = "box", .seed = 9};
  const RunFolder run = test::make_run(data(), one);
  fs::remove(run.events());
  std::vector<events::Event> events = test::random_events(one);
  events.push_back(events.back());
  events.back().t += std::chrono::hours(24 * 365);  // a damaged time
  {
    events::RecordingWriter writer(run.events(), {events::event_stream_declaration(one.sensor, "DVXplorer_TEST")});
    writer.write_events(0, events);
    writer.close();
  }
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_TRUE(mentions(summary.warnings, "box/01: left out, 1576800")) << "ticks, of which each would be kept";
  EXPECT_EQ(Dataset(file()).runs().size(), 3U);
}

TEST_F(WriteDataset, WithoutSamplesIsAnErrorThatNamesWhatIsMissing) {
  test::make_run(data(), {.intervals = {{Touch::press, camera_time(200'000), camera_time(260'000)}}});
  EXPECT_NE(message_of([&] {
              write_dataset(data(), file());
            }).find("expected a run with press and slip that are not flagged; 1 of 1 run has no samples: no slip in fan/01."),
            std::string::npos);
  EXPECT_FALSE(fs::exists(file()));
}

TEST_F(WriteDataset, WithoutLabelsIsAnErrorThatNamesTheCommand) {
  test::make_run(data(), {.labelled = false});
  EXPECT_NE(message_of([&] { write_dataset(data(), file()); }).find("tactile label"), std::string::npos);
  test::make_run(data(), {.run = "02", .seed = 2});
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_TRUE(mentions(summary.warnings, "fan/01"));
  EXPECT_EQ(summary.runs[0].remark, "no labels.json");
  EXPECT_EQ(Dataset(file()).runs().size(), 1U);
}

TEST_F(WriteDataset, TakesARunWithoutRunJsonFromItsFolderAndItsRecording) {
  test::make_three_runs(data());
  const std::string hash = write_dataset(data(), folder / "with/dataset.h5").manifest_hash;
  fs::remove(data() / "fan/02/run.json");
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_TRUE(mentions(summary.warnings, "runs without run.json"));
  EXPECT_TRUE(mentions(summary.warnings, "simulated if they have truth.json, or if their camera is the simulator's"));
  EXPECT_TRUE(mentions(summary.warnings, "fan/02"));
  EXPECT_EQ(summary.runs[1].samples, (std::array<std::uint64_t, 3>{30, 30, 30}));
  EXPECT_EQ(summary.manifest_hash, hash);
  EXPECT_FALSE(summary.simulated);
  write_whole(data() / "fan/02/truth.json", "{}");
  EXPECT_EQ(write_dataset(data(), file()).runs[1].remark, "simulated, and there are real runs");
}

TEST_F(WriteDataset, LeavesARunOutWhoseRunJsonIsBroken) {
  test::make_three_runs(data());
  write_whole(data() / "fan/02/run.json", "{\"object\": \"fan\"");
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_FALSE(summary.runs[1].in_dataset);
  EXPECT_EQ(summary.runs[1].remark, "its run.json cannot be read");
  EXPECT_TRUE(mentions(summary.errors, "fan/02/run.json: line 1 is no JSON"));
  EXPECT_TRUE(mentions(summary.errors, "; fan/02 is left out"));
  EXPECT_EQ(Dataset(file()).runs().size(), 2U);
  for (const char* run : {"fan/01", "usb-hub/01"}) write_whole(data() / run / "run.json", "");
  EXPECT_NE(message_of([&] { write_dataset(data(), folder / "other.h5"); }).find("no run can be used"), std::string::npos);
}

TEST_F(WriteDataset, LeavesRunsOutWhoseFilesCannotBeUsedAndTakesTheOthers) {
  test::make_three_runs(data());
  const auto break_json = [&](const char* file, const auto& change) {
    nlohmann::json json = read_json(data() / file);
    change(json);
    write_json(data() / file, json);
  };
  test::make_run(data(), {.object = "box", .run = "01", .seed = 7});
  test::make_run(data(), {.object = "box", .run = "02", .seed = 8});
  test::make_run(data(), {.object = "box", .run = "03", .seed = 9});
  break_json("box/01/labels.json", [](nlohmann::json& json) { json.at("intervals").at(0).at("class") = 5; });
  break_json("box/02/run.json", [](nlohmann::json& json) { json = nullptr; });
  fs::remove(data() / "box/03/labels.json");
  fs::create_symlink("labels.json", data() / "box/03/labels.json");
  fs::create_symlink("04", data() / "box/04");
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(Dataset(file()).runs().size(), 3U);
  EXPECT_EQ(summary.errors.size(), 4U);
  EXPECT_TRUE(mentions(summary.errors, "box/01/labels.json: 'class' is a number; expected a text; box/01 is left out"));
  EXPECT_TRUE(
      mentions(summary.errors, "box/02/run.json: is null; expected an object with the run's members; box/02 is left out"));
  EXPECT_TRUE(mentions(summary.errors, "box/03/labels.json: cannot be read (Too many levels of symbolic links)"));
  EXPECT_TRUE(mentions(summary.errors, "box/04: cannot be read (Too many levels of symbolic links)"));
}

TEST_F(WriteDataset, WarnsOfMisnamedRuns) {
  test::make_three_runs(data());
  fs::rename(data() / "usb-hub", data() / "USB hub");
  fs::rename(data() / "fan/02", data() / "fan/2");
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(Dataset(file()).runs().size(), 1U);
  EXPECT_TRUE(mentions(summary.warnings, "rename it to usb-hub"));
  EXPECT_TRUE(mentions(summary.warnings, "rename it to 02"));
  fs::rename(data() / "fan", data() / "Fan");
  EXPECT_NE(message_of([&] { write_dataset(data(), file()); }).find("rename it to fan"), std::string::npos);
}

TEST_F(WriteDataset, WarnsOfARunWhoseFolderHasAnotherName) {
  test::make_three_runs(data());
  fs::rename(data() / "usb-hub/01", data() / "usb-hub/02");
  EXPECT_TRUE(mentions(write_dataset(data(), file()).warnings, "usb-hub/02: run.json names it usb-hub/01"));
  EXPECT_EQ(Dataset(file()).runs()[2].run, "02");
}

TEST_F(WriteDataset, WithoutRunsIsAnError) {
  fs::create_directories(data());
  EXPECT_NE(message_of([&] { write_dataset(data(), file()); }).find("no runs"), std::string::npos);
  EXPECT_THROW(write_dataset(folder / "nowhere", file()), Error);
}

TEST_F(WriteDataset, TakesRealRunsIfThereAreSimulatedOnesToo) {
  test::make_three_runs(data());
  test::make_run(data(), {.object = "box", .simulated = true, .seed = 9});
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_FALSE(summary.simulated);
  EXPECT_TRUE(mentions(summary.warnings, "box/01"));
  EXPECT_EQ(Dataset(file()).runs().size(), 3U);
  EXPECT_TRUE(write_dataset(data(), file(), {.mix = true}).simulated);
  EXPECT_EQ(Dataset(file()).runs().size(), 4U);
  EXPECT_TRUE(Dataset(file()).simulated());
}

TEST_F(WriteDataset, NamesTheRunWhoseSensorIsTheOddOne) {
  test::make_three_runs(data());
  test::make_run(data(), {.object = "box", .sensor = {60, 30}, .seed = 9});
  const std::string message = message_of([&] { write_dataset(data(), file()); });
  EXPECT_EQ(message, "box/01: of a sensor of 60x30 px; expected the 40x30 px of the other runs");
}

TEST_F(WriteDataset, WarnsOfOneRecordingInTwoRuns) {
  test::make_three_runs(data());
  test::make_run(data(), {.object = "usb-hub", .run = "02", .seed = 3});
  EXPECT_TRUE(mentions(write_dataset(data(), file()).warnings, "usb-hub/02: has the same recording as usb-hub/01"));
}

}  // namespace
}  // namespace tactile::windows
