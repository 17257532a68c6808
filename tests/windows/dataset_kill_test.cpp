#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "support/kill_moments.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "support/traced_command.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/dataset_contents.hpp"
#include "windows/made_runs.hpp"

namespace tactile::windows {
namespace {

namespace fs = std::filesystem;
using Contents = test::DatasetContents;
using test::run_tactile;

Contents contents_of(const fs::path& file) { return test::dataset_contents(file); }

/// The same by plain h5py, of every dataset whose file is on a line of `list`: a line of JSON each.
constexpr const char* read_with_h5py = R"(import h5py, hashlib, json, sys
for file in open(sys.argv[1]).read().splitlines():
    with h5py.File(file, "r") as f:
        contents = {"manifest": f.attrs["manifest_sha256"].decode()}
        contents["events"] = hashlib.sha256(b"".join(f["/events/" + c][:].tobytes() for c in ("t_us", "x", "y", "on"))).hexdigest()
        for name in f["/heatmaps"]:
            contents[name] = hashlib.sha256(f["/heatmaps/" + name][:].tobytes()).hexdigest()
        print(json.dumps(contents))
)";

bool h5py_is_there() { return test::run_shell("/usr/bin/python3 -c 'import h5py'").exit_code == 0; }

/// dataset.h5 and its temporary copies; other files of a dataset by name.
bool touches_dataset(const test::TouchedFile& file) {
  if (file.name == "dataset.h5" || file.name == "data") return true;
  return file.by_name && (file.name.starts_with("dataset.") || file.name.starts_with(".dataset."));
}

class KilledDataset : public testing::Test {
 protected:
  void SetUp() override {
    test::make_run(data(), {.object = "fan", .run = "01", .seed = 1});
    test::make_run(data(), {.object = "fan", .run = "02", .seed = 2, .begin_us = -700'123});
    write_dataset(data(), file());
    ASSERT_EQ(run_tactile("heatmaps --th 2", folder.path()).exit_code, 0);
  }

  fs::path data() const { return folder.path() / "data"; }
  fs::path file() const { return data() / "dataset.h5"; }

  /// Copies a dataset with all that belongs to it, hidden leftovers too.
  static void copy_dataset(const fs::path& from, const fs::path& to) {
    fs::create_directories(to);
    for (const auto& entry : fs::directory_iterator(from)) {
      if (entry.is_regular_file()) fs::copy_file(entry.path(), to / entry.path().filename());
    }
  }
  static void remove_dataset(const fs::path& in) {
    for (const auto& entry : fs::directory_iterator(in)) {
      const bool is_leftover = entry.path().filename().string().starts_with('.');
      if (is_leftover || entry.is_regular_file()) fs::remove_all(entry.path());
    }
  }

  /// Runs the command again and again, each time killed one call later, and hands the number of each kill to `look` once it is
  /// dead, until it ends by itself. How many kills there were.
  std::size_t kill_at_every_call(const std::vector<std::string>& arguments, const std::function<void(std::size_t)>& look) {
    const fs::path before = folder / "before";
    copy_dataset(data(), before);
    for (std::size_t call = 0;; ++call) {
      remove_dataset(data());
      copy_dataset(before, data());
      const auto end = test::TracedCommand::run(arguments, folder.path(), touches_dataset, call);
      if (!end) return 0;
      if (!end->killed) {
        EXPECT_EQ(end->exit_code, 0);
        EXPECT_EQ(end->calls, call);
        return call;
      }
      look(call);
    }
  }

  /// Keeps what is there now to be read by h5py.
  void keep_state() {
    const fs::path kept = folder / ("state" + std::to_string(expected_.size()));
    copy_dataset(data(), kept);
    write_list_ += (kept / "dataset.h5").string() + "\n";
    expected_.push_back(contents_of(file()));
  }

  /// Whether h5py finds in every state that was kept what our own reader found; false where there is no h5py.
  bool h5py_agrees() {
    if (!h5py_is_there()) return false;
    write_whole(folder / "read.py", read_with_h5py);
    write_whole(folder / "list", write_list_);
    const auto read = test::run_shell("/usr/bin/python3 read.py list", folder.path());
    EXPECT_EQ(read.exit_code, 0) << read.err;
    std::istringstream lines(read.out);
    std::string line;
    for (const Contents& contents : expected_) {
      EXPECT_TRUE(std::getline(lines, line));
      EXPECT_EQ(nlohmann::json::parse(line), nlohmann::json(contents));
    }
    return true;
  }

  /// Kills the command, which replaces the dataset, at every call. @param files  in the folder after it
  void expect_old_or_new(const std::string& command, const std::set<std::string>& files) {
    const Contents old = contents_of(file());
    fs::create_directories(folder / "whole");
    fs::copy(data(), folder / "whole/data", fs::copy_options::recursive);
    ASSERT_EQ(run_tactile(command, folder / "whole").exit_code, 0);
    const Contents replaced = contents_of(folder / "whole/data/dataset.h5");
    ASSERT_NE(replaced.at("manifest"), old.at("manifest"));
    ASSERT_EQ(replaced.size(), 2U);

    std::vector<std::string> arguments;
    std::istringstream words(command + " --threads 1");
    for (std::string word; words >> word;) arguments.push_back(word);
    std::set<bool> seen;
    const std::size_t kills = kill_at_every_call(arguments, [&](std::size_t call) {
      const Contents contents = contents_of(file());
      const bool is_new = contents.at("manifest") == replaced.at("manifest");
      EXPECT_EQ(contents, is_new ? replaced : old) << "at call " << call;
      seen.insert(is_new);
      keep_state();
      if (call % 4 != 0) return;
      EXPECT_EQ(run_tactile(command, folder.path()).exit_code, 0) << "after call " << call;
      EXPECT_EQ(contents_of(file()), replaced) << "after call " << call;
      std::set<std::string> left;
      for (const auto& entry : fs::directory_iterator(data())) left.insert(entry.path().filename().string());
      EXPECT_EQ(left, files) << "after call " << call;
    });
    if (kills == 0) GTEST_SKIP() << "tracing is not allowed on this machine: windows was not killed call by call";
    EXPECT_GT(kills, 20U);
    EXPECT_EQ(seen.size(), 2U) << "no kill came before the change, or none after it";
    if (!h5py_agrees()) GTEST_SKIP() << "h5py is missing: only tactile's own reader read what the kills left";
  }

  std::ptrdiff_t leftovers() const {
    return std::count_if(fs::directory_iterator(data()), {},
                         [](const auto& entry) { return entry.path().filename().string().starts_with("."); });
  }

  test::TemporaryFolder folder;

 private:
  std::string write_list_;
  std::vector<Contents> expected_;
};

TEST_F(KilledDataset, OpensAfterHeatmapsWasKilledBeforeAnyCallThatTouchesIt) {
  const std::vector<std::string> command{"heatmaps", "--th", "4", "--threads", "1"};
  fs::create_directories(folder / "whole");
  fs::copy(data(), folder / "whole/data", fs::copy_options::recursive);
  ASSERT_EQ(run_tactile("heatmaps --th 4", folder / "whole").exit_code, 0);
  const Contents whole = contents_of(folder / "whole/data/dataset.h5");
  ASSERT_EQ(whole.size(), 4U);

  std::set<std::size_t> listed;
  const std::size_t kills = kill_at_every_call(command, [&](std::size_t call) {
    const Contents contents = contents_of(file());
    for (const auto& [name, hash] : contents) EXPECT_EQ(hash, whole.at(name)) << name << " at call " << call;
    EXPECT_TRUE(contents.contains("th_002")) << "at call " << call;
    listed.insert(contents.size());
    keep_state();
    if (call % 4 != 0) return;
    EXPECT_EQ(run_tactile("heatmaps --th 4", folder.path()).exit_code, 0) << "after call " << call;
    EXPECT_EQ(contents_of(file()), whole) << "after call " << call;
    EXPECT_EQ(leftovers(), 0) << "after call " << call;
  });
  if (kills == 0) GTEST_SKIP() << "tracing is not allowed on this machine: heatmaps was not killed call by call";
  EXPECT_GT(kills, 20U);
  EXPECT_EQ(listed, (std::set<std::size_t>{3, 4})) << "the kills did not lie around the link";
  if (!h5py_agrees()) GTEST_SKIP() << "h5py is missing: only tactile's own reader read what the kills left";
}

TEST_F(KilledDataset, OpensAfterHeatmapsWasKilledAtTwentyRandomMoments) {
  const auto seed = static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
  SCOPED_TRACE("seed " + std::to_string(seed));
  const std::string histories = "2,4,6,8,10,12,14,16,18,20,22,24,26,28,30,32,34,36,38,40,42,44,46,48,50";
  fs::create_directories(folder / "whole");
  fs::copy(data(), folder / "whole/data", fs::copy_options::recursive);
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run_tactile("heatmaps --th " + histories, folder / "whole").exit_code, 0);
  test::KillMoments moments(std::chrono::steady_clock::now() - begin, seed);
  const Contents whole = contents_of(folder / "whole/data/dataset.h5");
  copy_dataset(data(), folder / "before");
  int killed = 0;
  for (int i = 0; i < 20; ++i) {
    remove_dataset(data());
    copy_dataset(folder / "before", data());
    {
      const test::RunningCommand command("heatmaps --threads 2 --th " + histories, folder.path());
      moments.sleep(0.0, 0.9);
    }  // killed here
    const Contents contents = contents_of(file());
    for (const auto& [name, hash] : contents) EXPECT_EQ(hash, whole.at(name)) << name;
    EXPECT_TRUE(contents.contains("th_002"));
    if (contents.size() < whole.size()) {
      ++killed;
    } else {
      moments.were_too_late();
    }
    keep_state();
  }
  EXPECT_GT(killed, 5);
  if (!h5py_agrees()) GTEST_SKIP() << "h5py is missing: only tactile's own reader read what the kills left";
}

TEST_F(KilledDataset, IsTheOldOneOrTheNewOneAfterWindowsWasKilledBeforeAnyCallThatTouchesIt) {
  expect_old_or_new("windows --seed 2", {"dataset.events.h5", "dataset.h5", "fan"});
}

TEST_F(KilledDataset, IsTheOldOneOrTheGrownOneAfterWindowsWasKilledBeforeAnyCallThatTouchesIt) {
  test::make_run(data(), {.object = "fan", .run = "03", .seed = 3});
  expect_old_or_new("windows", {"dataset.events.h5", "dataset.h5", "dataset.th_002.h5", "fan"});
}

TEST_F(KilledDataset, IsWholeOrNotThereAfterWindowsWasKilledMakingIt) {
  const Contents whole = [&] {
    fs::create_directories(folder / "whole");
    fs::copy(data(), folder / "whole/data", fs::copy_options::recursive);
    remove_dataset(folder / "whole/data");
    EXPECT_EQ(run_tactile("windows", folder / "whole").exit_code, 0);
    return contents_of(folder / "whole/data/dataset.h5");
  }();
  remove_dataset(data());
  std::set<bool> seen;
  const std::size_t kills = kill_at_every_call({"windows", "--threads", "1"}, [&](std::size_t call) {
    seen.insert(fs::exists(file()));
    if (fs::exists(file())) {
      EXPECT_EQ(contents_of(file()), whole) << "at call " << call;
    }
  });
  if (kills == 0) GTEST_SKIP() << "tracing is not allowed on this machine: windows was not killed call by call";
  EXPECT_GT(kills, 20U);
  EXPECT_EQ(seen.size(), 2U) << "no kill came before it was there, or none after it";
}

}  // namespace
}  // namespace tactile::windows
