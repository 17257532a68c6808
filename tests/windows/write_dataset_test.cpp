#include "tactile/windows/write_dataset.hpp"

#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <optional>
#include <set>
#include <span>

#include "support/run_command.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/file_descriptor.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/verify_dataset.hpp"
#include "windows/made_runs.hpp"
#include "windows/written_dataset.hpp"

namespace tactile::windows {
namespace {

namespace fs = std::filesystem;
using test::mentions;
using test::message_of;
using test::WriteDataset;

TEST_F(WriteDataset, IsReadBackAsItWasDrawn) {
  test::make_three_runs(data());
  const DatasetSummary summary = write_dataset(data(), file());
  EXPECT_EQ(summary.outcome, DatasetSummary::Outcome::written);
  const Dataset dataset(file());
  EXPECT_EQ(dataset.sensor(), (events::SensorSize{40, 30}));
  EXPECT_FALSE(dataset.simulated());
  EXPECT_EQ(dataset.manifest_hash(), summary.manifest_hash);
  EXPECT_EQ(hash_of(dataset.settings()), summary.manifest_hash);
  ASSERT_EQ(dataset.runs().size(), 3U);
  EXPECT_EQ(dataset.runs()[1].object, "fan");
  EXPECT_EQ(dataset.runs()[1].run, "02");
  EXPECT_EQ(dataset.runs()[1].folder, "fan/02");
  EXPECT_EQ(dataset.runs()[1].events_sha256, sha256_of_file(data() / "fan/02/events.aedat4"));
  EXPECT_EQ(dataset.runs()[1].labels_sha256, labels::touches_sha256(labels::read_labels(data() / "fan/02/labels.json")));
  EXPECT_EQ(dataset.intervals().size(), 6U);
  EXPECT_EQ(dataset.intervals()[3].run_index, 1U);
  EXPECT_EQ(dataset.intervals()[3].interval.touch, Touch::slip);
  EXPECT_EQ(dataset.intervals()[3].interval.start, camera_time(-123));
  EXPECT_EQ(dataset.intervals()[3].interval.end, camera_time(199'878));
  EXPECT_EQ(dataset.samples().size(), summary.samples);
  EXPECT_TRUE(dataset.heatmaps().empty());
  for (const WindowedRun& run : summary.runs) {
    EXPECT_EQ(run.samples, (std::array<std::uint64_t, 3>{30, 30, 30})) << run.object;  // a press of 60 ms is the scarcest
  }
}

TEST_F(WriteDataset, HoldsTheUnionOfTheHistoriesAndNoOtherEvent) {
  test::make_three_runs(data());
  const WindowsOptions options{.sampling = {.history = 20ms}};
  const DatasetSummary summary = write_dataset(data(), file(), options);
  const Dataset dataset(file());
  std::uint64_t next = 0;
  for (std::uint32_t index = 0; index < 3; ++index) {
    const test::LabelledRun run{.seed = index + 1, .begin_us = index == 1 ? -700'123 : 1'700'000'000'000'301};
    std::vector<events::Event> expected;
    for (const events::Event& event : test::random_events(run)) {
      const bool kept = std::any_of(dataset.samples().begin(), dataset.samples().end(), [&](const Sample& sample) {
        return sample.run_index == index && event.t >= before(sample.t, 20ms) && event.t < sample.t;
      });
      if (kept) expected.push_back(event);
    }
    EXPECT_EQ(dataset.events(index), expected);
    EXPECT_LT(expected.size(), test::random_events(run).size());
    EXPECT_EQ(dataset.runs()[index].first_event, next);
    EXPECT_EQ(dataset.runs()[index].events, expected.size());
    next += expected.size();
  }
  EXPECT_EQ(summary.events, next);
}

TEST_F(WriteDataset, GivesTheSameBytesForAnyThreadsAndInAnyFolder) {
  test::make_three_runs(data());
  write_dataset(data(), file(), {}, 1);
  write_dataset(data(), folder / "other/dataset.h5", {}, 2);
  fs::create_directories(folder / "again");
  fs::copy(data() / "fan", folder / "again/fan", fs::copy_options::recursive);
  fs::copy(data() / "usb-hub", folder / "again/usb-hub", fs::copy_options::recursive);
  write_dataset(folder / "again", folder / "again/dataset.h5", {}, 2);
  EXPECT_EQ(sha256_of_file(file()), sha256_of_file(folder / "again/dataset.h5"));
  for (const char* other : {"other", "again"}) {
    EXPECT_EQ(sha256_of_file(data() / "dataset.events.h5"), sha256_of_file(folder.path() / other / "dataset.events.h5"));
  }
}

TEST_F(WriteDataset, DividesLongRunsAmongThreads) {
  const test::LabelledRun dense{.run = "01", .seed = 4, .mean_gap_us = 1}, sparse{.run = "02", .seed = 5};
  for (const test::LabelledRun& run : {dense, sparse}) test::make_run(data(), run);
  write_dataset(data(), file(), {}, 1);
  const Dataset dataset(file());
  EXPECT_GT(dataset.runs()[0].events, 1'000'000U);  // several pieces of 262 144
  for (std::uint32_t index = 0; index < 2; ++index) {
    std::vector<events::Event> expected = random_events(index == 0 ? dense : sparse);
    std::erase_if(expected, [&](const events::Event& event) {
      return std::none_of(dataset.samples().begin(), dataset.samples().end(), [&](const Sample& sample) {
        return sample.run_index == index && event.t < sample.t && event.t >= before(sample.t, dataset.sampling().history);
      });
    });
    EXPECT_EQ(dataset.events(index), expected) << index;
  }
  write_dataset(data(), folder / "other/dataset.h5", {}, 3);
  EXPECT_EQ(sha256_of_file(data() / "dataset.events.h5"), sha256_of_file(folder / "other/dataset.events.h5"));
  EXPECT_TRUE(verify_dataset(data(), file()).differences.empty());
}

TEST_F(WriteDataset, EndsAllThreadsWhereOneFails) {
  test::make_run(data(), {.run = "01", .seed = 4, .mean_gap_us = 1});
  for (const unsigned threads : {1U, 4U}) {
    std::uint64_t calls = 0;
    const auto stop_while_writing = [&](const Progress& progress) {
      if (progress.done > progress.total / 2 || ++calls > 3) throw Error("stopped");  // the first half plans
    };
    EXPECT_EQ(test::message_of([&] { write_dataset(data(), file(), {}, threads, stop_while_writing); }), "stopped");
    EXPECT_FALSE(fs::exists(file()));
  }
  write_dataset(data(), file(), {}, 4);
  EXPECT_TRUE(verify_dataset(data(), file()).differences.empty());
}

TEST_F(WriteDataset, KeepsADatasetOfTheSameManifestAndReplacesAnother) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  const auto written = fs::last_write_time(file());
  const std::string before = sha256_of_file(file());
  EXPECT_EQ(write_dataset(data(), file()).outcome, DatasetSummary::Outcome::unchanged);
  EXPECT_EQ(fs::last_write_time(file()), written);
  {
    const Dataset dataset(file());
    HeatmapsWriter heatmaps(dataset, {.name = "th_002", .settings = {{"history_us", 2000}}, .width = 1, .height = 1});
    test::append_to(heatmaps, std::vector<std::uint8_t>(dataset.samples().size(), 7));
    heatmaps.commit();
  }
  EXPECT_EQ(Dataset(file()).heatmaps().size(), 1U);
  EXPECT_EQ(write_dataset(data(), file(), {.sampling = {.seed = 2}}).outcome, DatasetSummary::Outcome::replaced);
  EXPECT_NE(sha256_of_file(file()), before);
  EXPECT_TRUE(Dataset(file()).heatmaps().empty());
  EXPECT_EQ(write_dataset(data(), file()).outcome, DatasetSummary::Outcome::replaced);
  EXPECT_EQ(sha256_of_file(file()), before);
  std::set<std::string> left;
  for (const auto& entry : fs::directory_iterator(data())) left.insert(entry.path().filename().string());
  EXPECT_EQ(left, (std::set<std::string>{"dataset.events.h5", "dataset.h5", "fan", "usb-hub"}));
}

TEST_F(WriteDataset, ReplacesADatasetWhoseEventsAreNotItsOwn) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  write_dataset(data(), folder / "other/dataset.h5", {.sampling = {.seed = 2}});
  fs::copy_file(folder / "other/dataset.events.h5", data() / "dataset.events.h5", fs::copy_options::overwrite_existing);
  EXPECT_NE(message_of([&] { const Dataset dataset(file()); }).find("belongs to another dataset"), std::string::npos);
  EXPECT_EQ(write_dataset(data(), file()).outcome, DatasetSummary::Outcome::replaced);
  EXPECT_EQ(Dataset(file()).samples().size(), 270U);
}

TEST_F(WriteDataset, LeavesAFileThatIsNoDatasetAlone) {
  test::make_three_runs(data());
  write_whole(file(), "my thesis");
  EXPECT_NE(message_of([&] { write_dataset(data(), file()); }).find("is not a dataset of tactile"), std::string::npos);
  EXPECT_EQ(read_text(file()), "my thesis");
}

TEST_F(WriteDataset, NotesWhereItsRunsHaveMovedAndKeepsItsHeatmaps) {
  test::make_three_runs(data());
  const fs::path apart = folder / "sets/dataset.h5";
  write_dataset(data(), apart);
  {
    const Dataset dataset(apart);
    HeatmapsWriter heatmaps(dataset, {.name = "th_002", .settings = {{"history_us", 2000}}, .width = 1, .height = 1});
    test::append_to(heatmaps, std::vector<std::uint8_t>(dataset.samples().size(), 7));
    heatmaps.commit();
  }
  const auto events_written = fs::last_write_time(folder / "sets/dataset.events.h5");
  fs::rename(data(), folder / "a-longer-name-of-a-folder");
  EXPECT_NE(message_of([&] { check_unchanged(Dataset(apart), 0); }).find("finds runs that have moved"), std::string::npos);
  EXPECT_EQ(write_dataset(folder / "a-longer-name-of-a-folder", apart).outcome, DatasetSummary::Outcome::moved);
  const Dataset dataset(apart);
  EXPECT_NO_THROW(check_unchanged(dataset, 0));
  EXPECT_EQ(dataset.run_folder(0), fs::canonical(folder / "a-longer-name-of-a-folder/fan/01"));
  EXPECT_EQ(dataset.heatmaps().size(), 1U);
  EXPECT_EQ(dataset.read_heatmaps("th_002", std::vector<std::uint32_t>{3}), std::vector<std::uint8_t>{7});
  EXPECT_EQ(fs::last_write_time(folder / "sets/dataset.events.h5"), events_written);
  EXPECT_EQ(write_dataset(folder / "a-longer-name-of-a-folder", apart).outcome, DatasetSummary::Outcome::unchanged);
}

TEST_F(WriteDataset, ReadsAnyPartOfARunsEvents) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  const Dataset dataset(file());
  const std::vector<events::Event> whole = dataset.events(1);
  const std::vector<events::Event> part = dataset.events(1, 100, 50);
  EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + 100, whole.begin() + 150));
  EXPECT_TRUE(dataset.events(1, whole.size(), 0).empty());
  EXPECT_THROW(dataset.events(1, 100, whole.size() - 99), Error);
  EXPECT_THROW(dataset.events(1, whole.size() + 1, 0), Error);
}

TEST_F(WriteDataset, ReadsTheEventsThatItCheckedThoughTheirFileIsReplaced) {
  test::make_three_runs(data());
  write_dataset(data(), file(), {});
  const Dataset dataset(file());
  const std::vector<events::Event> events = dataset.events(1);
  ASSERT_FALSE(events.empty());
  write_whole(data() / "other", "of another dataset, which 'tactile windows' may write at any moment");
  fs::rename(data() / "other", data() / "dataset.events.h5");
  EXPECT_EQ(dataset.events(1), events);
}

TEST_F(WriteDataset, LeavesNoFilesWhenItIsInterrupted) {
  test::make_three_runs(data());
  struct Enough {};
  int calls = 0;
  EXPECT_THROW(write_dataset(data(), file(), {}, 1,
                             [&](const Progress&) {
                               if (++calls == 5) throw Enough{};
                             }),
               Enough);
  std::set<std::string> left;
  for (const auto& entry : fs::directory_iterator(data())) left.insert(entry.path().filename().string());
  EXPECT_EQ(left, (std::set<std::string>{"fan", "usb-hub"}));
}

TEST_F(WriteDataset, StaysWholeIfItsReplacementStopsAtAnyStep) {
  // The steps of a replacement, undone one by one: every intermediate state opens, and the next command completes it.
  test::make_three_runs(data());
  write_dataset(data(), file());
  const std::string first = sha256_of_file(file());
  write_dataset(data(), folder / "new/dataset.h5", {.sampling = {.seed = 2}});
  // As set aside: the old dataset leads to dataset.events.old.h5, and the new events are in place already.
  const auto relinked = test::run_shell(
      "/usr/bin/python3 -c \"import h5py; f = h5py.File('dataset.h5', 'r+'); del f['events']; "
      "f['events'] = h5py.ExternalLink('dataset.events.old.h5', '/events')\"",
      data());
  if (relinked.exit_code != 0) GTEST_SKIP() << "h5py is missing: this test did not run";
  fs::rename(data() / "dataset.events.h5", data() / "dataset.events.old.h5");
  fs::copy_file(folder / "new/dataset.events.h5", data() / "dataset.events.h5");
  EXPECT_EQ(Dataset(file()).samples().size(), 270U);
  EXPECT_EQ(write_dataset(data(), file()).outcome, DatasetSummary::Outcome::replaced);
  EXPECT_EQ(sha256_of_file(file()), first);
  EXPECT_FALSE(fs::exists(data() / "dataset.events.old.h5"));
}

TEST_F(WriteDataset, OpensInH5pyAsTheFormatDocuments) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  write_whole(folder / "read.py", R"(import h5py, sys, hashlib
f = h5py.File(sys.argv[1], "r")
kinds = {p: (f[p].dtype.str, f[p].ndim) for p in
         ["/events/t_us", "/events/x", "/events/y", "/events/on", "/runs/first_event", "/runs/events", "/intervals/run", "/intervals/class",
          "/intervals/start_us", "/intervals/end_us", "/samples/run", "/samples/t_us", "/samples/label"]}
assert kinds == {"/events/t_us": ("<i8", 1), "/events/x": ("<u2", 1), "/events/y": ("<u2", 1), "/events/on": ("|u1", 1),
                 "/runs/first_event": ("<u8", 1), "/runs/events": ("<u8", 1), "/intervals/run": ("<u4", 1), "/intervals/class": ("|u1", 1),
                 "/intervals/start_us": ("<i8", 1), "/intervals/end_us": ("<i8", 1), "/samples/run": ("<u4", 1), "/samples/t_us": ("<i8", 1),
                 "/samples/label": ("|u1", 1)}, kinds
for p in ["object", "run", "folder", "events_sha256", "labels_sha256"]:
    info = h5py.check_string_dtype(f["/runs/" + p].dtype)
    assert info.encoding == "utf-8" and info.length is not None, p
assert list(f["/runs/object"].asstr()) == ["fan", "fan", "usb-hub"]
assert list(f["/runs/run"].asstr()) == ["01", "02", "01"]
events = f["/runs/events"][:]
assert f["/events/t_us"].shape == (events.sum(),) and (f["/runs/first_event"][:] == events.cumsum() - events).all()
for run, sha in zip(f["/runs/folder"].asstr(), f["/runs/events_sha256"].asstr()):
    assert hashlib.sha256(open(sys.argv[2] + "/" + run + "/events.aedat4", "rb").read()).hexdigest() == sha
assert isinstance(f.get("/events", getlink=True), h5py.ExternalLink) and f.get("/events", getlink=True).filename == "dataset.events.h5"
assert len(f["/heatmaps"]) == 0 and f["/samples/label"].shape == (270,)
assert f.attrs["simulated"] == 0 and f.attrs["sensor_width"] == 40 and f.attrs["sensor_height"] == 30
print(f.attrs["manifest_sha256"].decode())
)");
  if (test::run_shell("/usr/bin/python3 -c 'import h5py'").exit_code != 0)
    GTEST_SKIP() << "h5py is missing: the format was not read by it";
  const auto read = test::run_shell(
      "/usr/bin/python3 '" + (folder / "read.py").string() + "' '" + file().string() + "' '" + data().string() + "'", "/");
  EXPECT_EQ(read.exit_code, 0) << read.err;
  EXPECT_EQ(read.out, Dataset(file()).manifest_hash() + "\n");
}

TEST_F(WriteDataset, IsRefusedWhenItWasTamperedWithOrCut) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  const std::string whole = read_text(file());
  for (const std::size_t kept : {std::size_t{0}, std::size_t{100}, whole.size() / 2, whole.size() - 1}) {
    write_whole(file(), whole.substr(0, kept));
    EXPECT_THROW(const Dataset dataset(file()), Error) << kept;
  }
  EXPECT_THROW(const Dataset dataset(folder / "nowhere.h5"), Error);
  std::string changed = whole;
  const std::size_t place = changed.find("\"history_us\":50000");
  ASSERT_NE(place, std::string::npos);
  changed.replace(place, 18, "\"history_us\":60000");
  write_whole(file(), changed);
  EXPECT_NE(message_of([&] { const Dataset dataset(file()); }).find("damaged"), std::string::npos);
  write_whole(file(), whole);
  {
    const hdf5::Session session;
    const hdf5::Id out = hdf5::open_file(file(), true);
    H5Adelete(out, "simulated");
    hdf5::write_attribute(out, "simulated", std::int64_t{1}, "");  // which does not fit the manifest hash
  }
  EXPECT_NE(message_of([&] { const Dataset dataset(file()); }).find("manifest hash"), std::string::npos);
}

TEST_F(WriteDataset, IsVerifiedAgainstItsRuns) {
  test::make_three_runs(data());
  write_dataset(data(), file(), {.sampling = {.window = 300ms, .seed = 5}});
  EXPECT_EQ(verify_dataset(data(), file()).differences, std::vector<std::string>{});

  test::make_run(data(), {.object = "box", .seed = 9});
  EXPECT_TRUE(mentions(verify_dataset(data(), file()).differences, "box/01: is among the runs but not in the dataset"));
  fs::remove_all(data() / "box");

  test::LabelledRun moved{.run = "01", .seed = 1};
  moved.intervals[0].start = camera_time(204'000);
  labels::write_labels(data() / "fan/01/labels.json", test::labels_of(moved));
  const auto differences = verify_dataset(data(), file()).differences;
  EXPECT_TRUE(mentions(differences, "fan/01: labels.json has changed"));
  EXPECT_TRUE(mentions(differences, "fan/01: its intervals differ from its labels"));
  EXPECT_TRUE(mentions(differences, "fan/01: sample 0 is none at"));
  EXPECT_FALSE(mentions(differences, "usb-hub"));
}

TEST_F(WriteDataset, IsVerifiedToHoldNoRecordingTwice) {
  test::make_three_runs(data());
  fs::copy(data() / "fan/01", data() / "fan/03", fs::copy_options::recursive);
  write_dataset(data(), file());
  EXPECT_TRUE(mentions(verify_dataset(data(), file()).differences, "fan/03: has the same recording as fan/01"));
}

TEST_F(WriteDataset, FindsARunThatHasChanged) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  const Dataset dataset(file());
  EXPECT_NO_THROW(check_unchanged(dataset, 2));
  labels::write_labels(data() / "usb-hub/01/labels.json", {});
  EXPECT_NE(message_of([&] { check_unchanged(dataset, 2); }).find("usb-hub/01"), std::string::npos);
  fs::remove(data() / "usb-hub/01/labels.json");
  EXPECT_NE(message_of([&] { check_unchanged(dataset, 2); }).find("is missing"), std::string::npos);
}

TEST_F(WriteDataset, RefusesARecordingThatGoesBackInTime) {
  const RunFolder run = test::make_run(data(), {});
  fs::remove(run.events());
  const std::vector<events::Event> events = test::random_events({});
  {
    events::RecordingWriter writer(run.events(), {events::event_stream_declaration({40, 30}, "DVXplorer_TEST")},
                                   {.compression = events::Compression::none});
    writer.write_events(0, events);
    writer.close();
  }
  std::string bytes = read_text(run.events());
  const auto bytes_of = [](std::int64_t t) { return std::string(reinterpret_cast<const char*>(&t), sizeof t); };
  const std::size_t place = bytes.find(bytes_of(us_of(events[20].t)));
  ASSERT_NE(place, std::string::npos);
  bytes.replace(place, 8, bytes_of(us_of(events[19].t) - 1));
  write_whole(run.events(), bytes);
  EXPECT_NE(message_of([&] { write_dataset(data(), file()); }).find("go back in time"), std::string::npos);
}

TEST(HeatmapsWriter, RefusesTooFewHeatmapsAndAnotherDataset) {
  const test::TemporaryFolder folder;
  test::make_three_runs(folder.path());
  write_dataset(folder.path(), folder / "dataset.h5");
  const Dataset dataset(folder / "dataset.h5");
  const StoredHeatmaps description{.name = "th_002", .settings = nlohmann::json::object(), .width = 2, .height = 1};
  {
    HeatmapsWriter writer(dataset, description);
    test::append_to(writer, std::vector<std::uint8_t>(std::size_t{2} * 269));
    EXPECT_THROW(writer.commit(), Error);
  }
  {
    HeatmapsWriter writer(dataset, description);
    test::append_to(writer, std::vector<std::uint8_t>(std::size_t{2} * 270));
    write_dataset(folder.path(), folder / "dataset.h5", {.sampling = {.seed = 2}});
    EXPECT_NE(message_of([&] { writer.commit(); }).find("replaced by another dataset"), std::string::npos);
  }
  EXPECT_TRUE(Dataset(folder / "dataset.h5").heatmaps().empty());
}

struct RenamedFiles {
  std::set<std::string> all, changed_later;
};

/// The files that `work` renames into a folder, and those of them that it changes after that. Nothing if this machine cannot
/// watch folders.
std::optional<RenamedFiles> renamed_files(const fs::path& folder, const std::function<void()>& work) {
  const events::FileDescriptor watch(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  if (!watch.is_open() || ::inotify_add_watch(watch.number(), folder.c_str(), IN_MOVED_TO | IN_MODIFY) < 0) return std::nullopt;
  work();
  std::array<char, 65'536> bytes{};
  const ssize_t count = ::read(watch.number(), bytes.data(), bytes.size());
  RenamedFiles renamed;
  for (std::size_t at = 0; count > 0 && at < static_cast<std::size_t>(count);) {
    inotify_event event;
    std::memcpy(&event, &bytes[at], sizeof event);
    const std::string name(event.len > 0 ? &bytes[at + sizeof event] : "");
    if ((event.mask & IN_MOVED_TO) != 0) renamed.all.insert(name);
    if ((event.mask & IN_MODIFY) != 0 && renamed.all.contains(name)) renamed.changed_later.insert(name);
    at += sizeof event + event.len;
  }
  return renamed;
}

TEST(HeatmapsWriter, ChangesNoFileOnceItHasItsName) {
  const test::TemporaryFolder folder;
  test::make_three_runs(folder.path());
  write_dataset(folder.path(), folder / "dataset.h5");
  const Dataset dataset(folder / "dataset.h5");
  HeatmapsWriter writer(dataset, {.name = "th_002", .settings = {{"history_us", 2000}}, .width = 1, .height = 1});
  test::append_to(writer, std::vector<std::uint8_t>(dataset.samples().size(), 7));
  const auto renamed = renamed_files(folder.path(), [&] { writer.commit(); });
  if (!renamed) GTEST_SKIP() << "this machine cannot watch folders";
  EXPECT_EQ(renamed->all, (std::set<std::string>{"dataset.h5", "dataset.th_002.h5"}));
  EXPECT_TRUE(renamed->changed_later.empty()) << "a kill leaves half of " << *renamed->changed_later.begin();
}

TEST(Heatmaps, AreReadInAnyOrder) {
  const test::TemporaryFolder folder;
  test::make_three_runs(folder.path());
  write_dataset(folder.path(), folder / "dataset.h5");
  {
    const Dataset dataset(folder / "dataset.h5");
    HeatmapsWriter writer(dataset, {.name = "th_002", .settings = {{"history_us", 2000}}, .width = 2, .height = 1});
    std::vector<std::uint8_t> heatmaps;
    for (int i = 0; i < 270; ++i)
      heatmaps.insert(heatmaps.end(), {static_cast<std::uint8_t>(i % 251), static_cast<std::uint8_t>(i / 251)});
    test::append_to(writer, {heatmaps.begin(), heatmaps.begin() + 200});
    test::append_to(writer, {heatmaps.begin() + 200, heatmaps.end()});
    writer.commit();
  }
  const Dataset dataset(folder / "dataset.h5");
  ASSERT_EQ(dataset.heatmaps().size(), 1U);
  EXPECT_EQ(dataset.heatmaps()[0].name, "th_002");
  EXPECT_EQ(dataset.heatmaps()[0].settings.at("history_us"), 2000);
  EXPECT_EQ(dataset.heatmaps()[0].width, 2);
  EXPECT_EQ(dataset.read_heatmaps("th_002", std::vector<std::uint32_t>{269, 0, 1, 2, 2}),
            (std::vector<std::uint8_t>{18, 1, 0, 0, 1, 0, 2, 0, 2, 0}));
  const std::vector<std::uint32_t> last_and_none{268, 269, 270};
  EXPECT_EQ(dataset.read_heatmaps("th_002", std::span(last_and_none).first(2)), (std::vector<std::uint8_t>{17, 1, 18, 1}));
  EXPECT_THROW(dataset.read_heatmaps("th_002", last_and_none), Error);
  EXPECT_THROW(dataset.read_heatmaps("th_002", std::vector<std::uint32_t>{270}), Error);
  EXPECT_THROW(dataset.read_heatmaps("th_004", std::vector<std::uint32_t>{0}), Error);
  std::filesystem::remove(folder / "dataset.th_002.h5");
  EXPECT_FALSE(dataset.find_heatmaps("th_002"));
}

TEST_F(WriteDataset, ReadsNoHistoryWiderOrHigherThanTheLargestSensor) {
  test::make_three_runs(data());
  write_dataset(data(), file());
  const auto is_read = [&](int width, int height) {
    {
      const Dataset dataset(file());
      HeatmapsWriter writer(dataset, {.name = "th_002", .settings = {{"history_us", 2000}}, .width = width, .height = height});
      const std::size_t values = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * dataset.samples().size();
      test::append_to(writer, std::vector<std::uint8_t>(values, 7));
      writer.commit();
    }
    return Dataset(file()).find_heatmaps("th_002").has_value();
  };
  EXPECT_TRUE(is_read(32767, 1));
  EXPECT_TRUE(is_read(1, 32767));
  EXPECT_FALSE(is_read(32768, 1));
  EXPECT_FALSE(is_read(1, 32768));
}

}  // namespace
}  // namespace tactile::windows
