#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "support/kill_moments.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"
#include "windows/written_dataset.hpp"

namespace tactile::heatmaps {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;

class HeatmapsCommand : public testing::Test {
 protected:
  void SetUp() override {
    test::make_three_runs(folder.path() / "data");
    windows::write_dataset(folder / "data", folder / "data/dataset.h5");
  }
  test::TemporaryFolder folder;
};

TEST_F(HeatmapsCommand, RendersTheHistoriesItIsGivenAndKeepsThemTheNextTime) {
  const auto result = run_tactile("heatmaps --th 2,40 --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json.at("histories").size(), 2U);
  EXPECT_EQ(json.at("histories").at(1).at("name"), "th_040");
  EXPECT_EQ(json.at("histories").at(1).at("outcome"), "written");
  EXPECT_EQ(json.at("histories").at(1).at("settings").at("history_us"), 40'000);
  const auto written = fs::last_write_time(folder / "data/dataset.th_040.h5");
  const auto again = run_tactile("heatmaps data --th 40", folder.path());
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.out.find("unchanged"), std::string::npos) << again.out;
  EXPECT_EQ(fs::last_write_time(folder / "data/dataset.th_040.h5"), written);
  EXPECT_EQ(windows::Dataset(folder / "data/dataset.h5").heatmaps().size(), 2U);
}

TEST_F(HeatmapsCommand, DamagedHistoriesAreFoundByVerifying) {
  ASSERT_EQ(run_tactile("heatmaps --th 2,40", folder.path()).exit_code, 0);
  const auto whole_one = run_tactile("windows --verify --json", folder.path());
  ASSERT_EQ(whole_one.exit_code, 0) << whole_one.out;
  EXPECT_EQ(nlohmann::json::parse(whole_one.out).at("histories"), nlohmann::json::parse(R"(["th_002", "th_040"])"));
  const fs::path file = folder / "data/dataset.th_040.h5";
  const std::string whole = read_text(file);
  std::string flipped = whole;
  for (std::size_t i = 0; i < 64; ++i) flipped[whole.size() / 2 + i] = static_cast<char>(flipped[whole.size() / 2 + i] ^ 0x55);
  for (const std::string& damaged : {flipped, whole.substr(0, whole.size() / 2)}) {
    write_whole(file, damaged);
    const auto verified = run_tactile("windows --verify", folder.path());
    EXPECT_EQ(verified.exit_code, 2);
    EXPECT_NE(verified.out.find("dataset.th_040.h5"), std::string::npos) << verified.out;
    EXPECT_EQ(verified.out.find("dataset.th_002.h5"), std::string::npos) << verified.out;
  }
  fs::remove(file);
  ASSERT_EQ(run_tactile("heatmaps --th 40", folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(file), whole);
  EXPECT_EQ(run_tactile("windows --verify", folder.path()).exit_code, 0);
}

TEST_F(HeatmapsCommand, RendersEveryHistoryOfThePaperWithoutArguments) {
  ASSERT_EQ(run_tactile("heatmaps", folder.path()).exit_code, 0);
  std::vector<std::string> names;
  for (const windows::StoredHeatmaps& stored : windows::Dataset(folder / "data/dataset.h5").heatmaps())
    names.push_back(stored.name);
  EXPECT_EQ(names, (std::vector<std::string>{"th_002", "th_010", "th_020", "th_030", "th_040", "th_050"}));
}

TEST_F(HeatmapsCommand, NamesOtherRenderingsByTheirSettings) {
  ASSERT_EQ(run_tactile("heatmaps --th 40 --denoise literal --resize linear --factor 0.1", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("heatmaps --th 2.5 --tick-us 500", folder.path()).exit_code, 0);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  ASSERT_EQ(dataset.heatmaps().size(), 2U);
  EXPECT_EQ(dataset.heatmaps()[0].name.substr(0, 7), "th_002-");
  EXPECT_EQ(dataset.heatmaps()[0].settings.at("history_us"), 2'500);
  EXPECT_EQ(dataset.heatmaps()[1].settings.at("denoise"), "literal");
  EXPECT_EQ(dataset.heatmaps()[1].width, 4);
}

TEST_F(HeatmapsCommand, LeavesOutMaskedPixels) {
  write_whole(folder / "mask.csv", "x,y,kind\n3,4,hot\n1,1,hot\n");
  const test::CommandResult masked = run_tactile("heatmaps --th 40 --mask mask.csv", folder.path());
  ASSERT_EQ(masked.exit_code, 0) << masked.err;
  ASSERT_EQ(run_tactile("heatmaps --th 40", folder.path()).exit_code, 0);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  ASSERT_EQ(dataset.heatmaps().size(), 2U);
  EXPECT_FALSE(dataset.heatmaps()[0].settings.contains("mask"));
  EXPECT_EQ(dataset.heatmaps()[1].settings.at("mask"), nlohmann::json({{1, 1}, {3, 4}}));
  write_whole(folder / "far.csv", "x,y\n30000,4\n");
  const test::CommandResult far = run_tactile("heatmaps --th 40 --mask far.csv", folder.path());
  EXPECT_EQ(far.exit_code, 1);
  EXPECT_NE(far.err.find("tactile: far.csv: pixel (30000, 4) lies outside the sensor"), std::string::npos) << far.err;
}

TEST_F(HeatmapsCommand, GivesTheSameBytesForAnyThreads) {
  fs::copy(folder / "data", folder / "other", fs::copy_options::recursive);
  ASSERT_EQ(run_tactile("heatmaps data --th 10,40 --threads 1", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("heatmaps other --th 10,40 --threads 2", folder.path()).exit_code, 0);
  for (const char* name : {"dataset.h5", "dataset.th_010.h5", "dataset.th_040.h5"}) {
    EXPECT_EQ(sha256_of_file(folder.path() / "data" / name), sha256_of_file(folder.path() / "other" / name)) << name;
  }
}

/// The files of a dataset that is made at once from the runs in `data`, by name.
std::map<std::string, std::string> made_at_once(const fs::path& data, const fs::path& parent, const std::string& histories) {
  const fs::path once = parent / "data";
  fs::create_directories(once);
  for (const auto& entry : fs::directory_iterator(data)) {
    if (entry.is_directory()) fs::copy(entry.path(), once / entry.path().filename(), fs::copy_options::recursive);
  }
  EXPECT_EQ(run_tactile("windows", parent).exit_code, 0);
  const auto json = nlohmann::json::parse(run_tactile("heatmaps --json --th " + histories, parent).out);
  EXPECT_EQ(json.at("histories").at(0).at("runs_kept"), 0);
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(once)) {
    if (entry.is_regular_file()) files[entry.path().filename().string()] = sha256_of_file(entry.path());
  }
  return files;
}

TEST_F(HeatmapsCommand, RendersOnlyTheRunsThatAreNew) {
  ASSERT_EQ(run_tactile("heatmaps --th 2,40", folder.path()).exit_code, 0);
  test::make_run(folder / "data", {.object = "fan", .run = "03", .seed = 8});
  fs::remove_all(folder / "data/usb-hub");
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto result = run_tactile("heatmaps --th 2,40 --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("warnings"), nlohmann::json::array());
  for (const auto& history : json.at("histories")) {
    EXPECT_EQ(history.at("runs_rendered"), 1) << history;
    EXPECT_EQ(history.at("runs_kept"), 2) << history;
  }
  for (const auto& [name, hash] : made_at_once(folder / "data", folder / "once", "2,40"))
    EXPECT_EQ(sha256_of_file(folder / "data" / name), hash) << name;

  // Dropping a run renders nothing, and another rendering renders everything.
  fs::remove_all(folder / "data/fan/03");
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const auto dropped = run_tactile("heatmaps --th 2,10", folder.path());
  EXPECT_NE(dropped.out.find("0 runs rendered, 2 kept"), std::string::npos) << dropped.out;
  EXPECT_NE(dropped.out.find("written"), std::string::npos) << dropped.out;
  for (const auto& [name, hash] : made_at_once(folder / "data", folder / "twice", "2,10"))
    EXPECT_EQ(sha256_of_file(folder / "data" / name), hash) << name;
}

TEST_F(HeatmapsCommand, TakesKeptRunsFromTheFileOfTheOlderDataset) {
  const fs::path file = folder / "data/dataset.h5";
  ASSERT_EQ(run_tactile("heatmaps --th 2", folder.path()).exit_code, 0);
  const windows::StoredHeatmaps history = windows::Dataset(file).heatmaps().at(0);
  fs::remove(folder / "data/dataset.th_002.h5");
  const std::size_t size = static_cast<std::size_t>(history.width) * static_cast<std::size_t>(history.height);
  {
    const windows::Dataset dataset(file);  // heatmaps that no rendering gives
    windows::HeatmapsWriter writer(dataset, history);
    test::append_to(writer, std::vector<std::uint8_t>(size * dataset.samples().size(), 77));
    writer.commit();
  }
  test::make_run(folder / "data", {.object = "fan", .run = "03", .seed = 8});
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("heatmaps --th 2", folder.path()).exit_code, 0);
  const windows::Dataset grown(file);
  for (std::uint32_t i = 0; i < grown.samples().size(); ++i) {
    const bool is_kept = grown.runs()[grown.samples()[i].run_index].run != "03";
    const auto heatmap = grown.read_heatmaps("th_002", std::vector<std::uint32_t>{i});
    ASSERT_EQ(heatmap == std::vector<std::uint8_t>(size, 77), is_kept) << i;
  }
}

/// The longest packed heatmap of a history, as its file has it.
std::string longest_chunk_of(const windows::Dataset& dataset, const windows::StoredHeatmaps& history) {
  const windows::HeatmapsWriter writer(dataset, history);  // never committed
  std::vector<std::uint32_t> every(dataset.samples().size());
  std::iota(every.begin(), every.end(), 0U);
  const auto packed = writer.packed(dataset.read_heatmaps(history.name, every));
  const auto longest = std::max_element(packed.chunks.begin(), packed.chunks.end(),
                                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return {longest->begin(), longest->end()};
}

TEST_F(HeatmapsCommand, RendersARunAgainWhoseOlderHeatmapsAreDamaged) {
  // So large that HDF5's check of a whole file does not read the values.
  fs::remove_all(folder / "data");
  for (const char* number : {"01", "02", "03"})
    test::make_run(folder / "data", {.object = "fan", .run = number, .sensor = {160, 120}, .seed = std::stoul(number)});
  const std::string heatmaps = "heatmaps --th 2 --factor 1 --json";
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile(heatmaps, folder.path()).exit_code, 0);
  const auto [chunk, stored] = [&] {
    const windows::Dataset dataset(folder / "data/dataset.h5");
    const windows::StoredHeatmaps history = dataset.heatmaps().at(0);
    return std::pair(longest_chunk_of(dataset, history), folder / "data" / ("dataset." + history.name + ".h5"));
  }();
  test::make_run(folder / "data", {.object = "fan", .run = "04", .sensor = {160, 120}, .seed = 8});
  ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  const std::string whole = read_text(stored);
  const auto expected = made_at_once(folder / "data", folder / "once", "2 --factor 1");
  ASSERT_NE(whole.find(chunk), std::string::npos);
  for (const std::size_t place : {whole.find(chunk) + 3, std::size_t{0}}) {  // one heatmap, and the whole file
    std::string damaged = whole;
    damaged.replace(place, 3, "???");
    write_whole(stored, damaged);
    const auto result = run_tactile(heatmaps, folder.path());
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("histories").at(0).at("runs_rendered"), place > 0 ? 2 : 4) << result.out;
    ASSERT_EQ(json.at("warnings").size(), 1U);
    const std::string warning = json.at("warnings").at(0);
    EXPECT_NE(warning.find(place > 0 ? "a run is rendered again: " : "all runs of this file are rendered again: "),
              std::string::npos)
        << warning;
    EXPECT_NE(warning.find(stored.filename().string() + ": "), std::string::npos) << warning;
    EXPECT_EQ(sha256_of_file(stored), expected.at(stored.filename().string()));
    fs::remove(folder / "data/dataset.h5");
    ASSERT_EQ(run_tactile("windows", folder.path()).exit_code, 0);
  }
}

TEST_F(HeatmapsCommand, RefusesInWordsWhatItCannotRender) {
  const auto too_long = run_tactile("heatmaps --th 40,60", folder.path());
  EXPECT_EQ(too_long.exit_code, 1);
  EXPECT_NE(too_long.err.find("history of 60000 us; expected at most the 50000 us"), std::string::npos) << too_long.err;
  EXPECT_TRUE(windows::Dataset(folder / "data/dataset.h5").heatmaps().empty());
  const auto no_ticks = run_tactile("heatmaps --th 41", folder.path());
  EXPECT_EQ(no_ticks.exit_code, 1);
  EXPECT_NE(no_ticks.err.find("whole number of ticks"), std::string::npos) << no_ticks.err;
  EXPECT_GE(run_tactile("heatmaps --th 0", folder.path()).exit_code, 100);
  EXPECT_GE(run_tactile("heatmaps --denoise mild", folder.path()).exit_code, 100);
  EXPECT_EQ(run_tactile("heatmaps --factor 0.3", folder.path()).exit_code, 1);
}

TEST_F(HeatmapsCommand, NamesTheCommandForAMissingDataset) {
  fs::create_directories(folder / "empty");
  const auto result = run_tactile("heatmaps empty --th 40", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("tactile windows empty"), std::string::npos) << result.err;
}

TEST_F(HeatmapsCommand, WritesPicturesWhosePixelsAreTheHeatmaps) {
  const auto result = run_tactile("heatmaps --th 40 --png pictures", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const windows::Dataset dataset(folder / "data/dataset.h5");
  for (const std::uint32_t index : {0U, 100U, 269U}) {
    const windows::Sample& sample = dataset.samples()[index];
    const windows::DatasetRun& run = dataset.runs()[sample.run_index];
    const std::string name =
        run.object + "-" + run.run + "-" + std::to_string(us_of(sample.t)) + "-" + std::string(name_of(sample.touch)) + ".png";
    const fs::path file = folder.path() / "pictures/th_040" / run.object / run.run / name;
    const cv::Mat picture = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(picture.total(), 8U * 6U) << file;
    const auto heatmap = dataset.read_heatmaps("th_040", std::span(&index, 1));
    EXPECT_TRUE(std::equal(heatmap.begin(), heatmap.end(), picture.begin<std::uint8_t>()));
  }
}

TEST_F(HeatmapsCommand, ListsItsPicturesAndReplacesNoOtherFiles) {
  ASSERT_EQ(run_tactile("heatmaps --th 40 --png pictures", folder.path()).exit_code, 0);
  const fs::path pictures = folder.path() / "pictures/th_040";
  std::istringstream list(read_text(pictures / "pictures.csv"));
  std::string line;
  std::getline(list, line);
  EXPECT_EQ(line, "file,object,run,t_us,label");
  const windows::Dataset dataset(folder / "data/dataset.h5");
  std::string before;
  for (const windows::Sample& sample : dataset.samples()) {
    const windows::DatasetRun& run = dataset.runs()[sample.run_index];
    ASSERT_TRUE(std::getline(list, line));
    const std::string file = line.substr(0, line.find(','));
    EXPECT_EQ(line, file + "," + run.object + "," + run.run + "," + std::to_string(us_of(sample.t)) + "," +
                        std::string(name_of(sample.touch)));
    EXPECT_TRUE(fs::exists(pictures / file)) << file;
    const bool same_run = before.starts_with(run.object + "/" + run.run);
    if (same_run && us_of(sample.t) > 0) {
      EXPECT_LT(before, file) << "names sort by time";
    }
    before = file;
  }
  EXPECT_FALSE(std::getline(list, line));

  write_whole(pictures / "fan/01/old.png", "no picture of theirs");
  const auto refused = run_tactile("heatmaps --th 20,40 --png pictures", folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("holds fan/01/old.png"), std::string::npos) << refused.err;
  EXPECT_FALSE(fs::exists(folder.path() / "pictures/th_020")) << "refused ahead of the work";
  fs::remove(pictures / "fan/01/old.png");
  EXPECT_EQ(run_tactile("heatmaps --th 20,40 --png pictures", folder.path()).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "pictures/th_020/pictures.csv"));
}

TEST_F(HeatmapsCommand, LeaveADatasetThatH5pyReads) {
  if (test::run_shell("/usr/bin/python3 -c 'import h5py'").exit_code != 0)
    GTEST_SKIP() << "h5py is missing: the format was not read by it";
  ASSERT_EQ(run_tactile("heatmaps --th 40", folder.path()).exit_code, 0);
  write_whole(folder / "read.py", R"(import h5py
f = h5py.File("data/dataset.h5", "r")
h = f["/heatmaps/th_040"]
assert h.shape == (270, 6, 8) and h.dtype.str == "|u1" and h[:].max() > 0
assert dict((k, h.attrs[k]) for k in ("history_us", "tick_us", "denoise", "resize", "factor")) == {
    "history_us": 40000, "tick_us": 2000, "denoise": b"mean", "resize": b"area", "factor": 0.2}
assert f.get("/heatmaps/th_040", getlink=True).filename == "dataset.th_040.h5"
# The first sample again, from the file of events.
import numpy as np
t, run = f["/samples/t_us"][0], f["/samples/run"][0]
n, k = f["/runs/first_event"][run], f["/runs/events"][run]
e = {c: f["/events/" + c][n:n + k].astype(np.int64) for c in ("t_us", "x", "y")}
inside = (e["t_us"] >= t - 40000) & (e["t_us"] < t)
E = np.zeros((30, 40)); np.add.at(E, (e["y"][inside], e["x"][inside]), 1)
b = E[E > 0].mean(); D = E / (1 + np.exp(E - b)); H = (255 * D / D.max()).reshape(6, 5, 8, 5).mean(axis=(1, 3))
assert (np.abs(h[0] - H) < 0.501).all(), np.abs(h[0] - H).max()
)");
  const auto read = test::run_shell("/usr/bin/python3 read.py", folder.path());
  EXPECT_EQ(read.exit_code, 0) << read.err;
}

TEST_F(HeatmapsCommand, LeavesNoHalfFolderOfPicturesWhereItIsEnded) {
  const fs::path pictures = folder / "pictures";
  const auto hidden = [&] {
    if (!fs::exists(pictures)) return false;
    const fs::directory_iterator entries(pictures);
    return std::any_of(begin(entries), end(entries),
                       [](const auto& entry) { return entry.path().filename().string().front() == '.'; });
  };
  ASSERT_EQ(run_tactile("heatmaps data --th 2,4,6,8,10,12,14,16,18,20", folder.path()).exit_code, 0);
  int ended = 0;
  for (int i = 0; i < 100 && ended < 3; ++i) {
    fs::remove_all(pictures);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const int nowhere = ::open("/dev/null", O_WRONLY);
      ::dup2(nowhere, STDOUT_FILENO);
      ::dup2(nowhere, STDERR_FILENO);
      ::execl(test::tactile_binary, test::tactile_binary, "heatmaps", (folder.path() / "data").c_str(), "--threads", "1", "--th",
              "2,4,6,8,10,12,14,16,18,20", "--png", pictures.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    int status = 0;
    bool is_over = false;
    while (!is_over && !hidden()) is_over = ::waitpid(child, &status, WNOHANG) == child;
    if (!is_over) {
      ::kill(child, SIGTERM);
      ::waitpid(child, &status, 0);
    }
    ASSERT_TRUE(WIFEXITED(status)) << "it is not killed, it ends";
    ended += WEXITSTATUS(status) == 128 + SIGTERM ? 1 : 0;
    EXPECT_FALSE(hidden());
  }
  EXPECT_GT(ended, 0);
}

TEST_F(HeatmapsCommand, KilledAtAnyMomentHarmsNoExistingFile) {
  const fs::path file = folder / "data/dataset.h5";
  const std::string histories = "2,4,6,8,10,12,14,16,18,20,30,40,50";
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run_tactile("heatmaps data --threads 2 --th " + histories, folder.path()).exit_code, 0);
  const auto end = std::chrono::steady_clock::now();
  test::KillMoments moments(end - begin, static_cast<std::uint64_t>(end.time_since_epoch().count()));
  const auto make_dataset = [&] {
    fs::remove(file);
    windows::write_dataset(folder / "data", file);
  };
  make_dataset();
  int killed = 0;
  for (int i = 0; i < 20; ++i) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const int nowhere = ::open("/dev/null", O_WRONLY);
      ::dup2(nowhere, STDOUT_FILENO);
      ::dup2(nowhere, STDERR_FILENO);
      const std::string data = folder.path() / "data";
      ::execl(test::tactile_binary, test::tactile_binary, "heatmaps", data.c_str(), "--threads", "2", "--th", histories.c_str(),
              static_cast<char*>(nullptr));
      ::_exit(127);
    }
    moments.sleep(0, 1);
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    WIFSIGNALED(status) ? void(++killed) : moments.were_too_late();

    const windows::Dataset dataset(file);
    std::vector<std::uint32_t> every(dataset.samples().size());
    std::iota(every.begin(), every.end(), 0U);
    for (const windows::StoredHeatmaps& stored : dataset.heatmaps())
      EXPECT_EQ(dataset.read_heatmaps(stored.name, every).size(), every.size() * 48) << stored.name;
    if (dataset.heatmaps().size() == 13) make_dataset();  // all done: begin again
  }
  EXPECT_GT(killed, 5);
  EXPECT_EQ(run_tactile("heatmaps", folder.path()).exit_code, 0);
}

}  // namespace
}  // namespace tactile::heatmaps
