#include "tactile/capture/new_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;

TEST(MakeRunFolder, TakesTheNumberAfterTheHighest) {
  const test::TemporaryFolder data;
  EXPECT_EQ(make_run_folder(data.path(), "fan").run, "01");
  const RunFolder second = make_run_folder(data.path(), "fan");
  EXPECT_EQ(second.name(), "fan/02");
  EXPECT_EQ(second.folder, data / "fan" / "02");
  EXPECT_TRUE(fs::is_directory(second.folder));
  fs::create_directories(data / "fan" / "07");
  fs::create_directories(data / "fan" / "notes");
  fs::create_directories(data / "fan" / "09.discarded-1");
  EXPECT_EQ(make_run_folder(data.path(), "fan").run, "08");
  EXPECT_EQ(make_run_folder(data.path(), "usb-hub").run, "01");
}

TEST(MakeRunFolder, FillsGapsOnceNumber99IsTaken) {
  const test::TemporaryFolder data;
  fs::create_directories(data / "fan" / "99");
  EXPECT_EQ(make_run_folder(data.path(), "fan").run, "01");
  for (int i = 2; i < 99; ++i) make_run_folder(data.path(), "fan");
  EXPECT_THROW(make_run_folder(data.path(), "fan"), Error);
}

TEST(MakeRunFolder, NeverTakesARunThatIsThere) {
  const test::TemporaryFolder data;
  EXPECT_EQ(make_run_folder(data.path(), "fan", "05").run, "05");
  write_whole(data / "fan/05/notes.txt", "precious");
  EXPECT_THROW(make_run_folder(data.path(), "fan", "05"), Error);
  EXPECT_EQ(read_text(data / "fan/05/notes.txt"), "precious");
}

TEST(MakeRunFolder, RefusesNamesThatAreNone) {
  const test::TemporaryFolder data;
  for (const char* object : {"", "Fan", "../fan", "fan_1", "-fan"})
    EXPECT_THROW(make_run_folder(data.path(), object), Error) << object;
  for (const char* run : {"0", "00", "100", "1a", "../01"}) EXPECT_THROW(make_run_folder(data.path(), "fan", run), Error) << run;
  write_whole(data / "file", "");
  EXPECT_THROW(make_run_folder(data / "file", "fan"), Error);
}

TEST(MakeRunFolder, GivesTwoNumbersToTwoWhoAskAtOnce) {
  const test::TemporaryFolder data;
  std::vector<std::string> runs(40);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < 4; ++k) {
    threads.emplace_back([&, k] {
      for (std::size_t i = k; i < runs.size(); i += 4) runs[i] = make_run_folder(data.path(), "fan").run;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(std::set<std::string>(runs.begin(), runs.end()).size(), runs.size());
}

TEST(DiscardRun, ReplacesNoFolderThatAppearsMeanwhile) {
  const test::TemporaryFolder data;
  std::vector<RunFolder> runs;
  for (int i = 0; i < 40; ++i) runs.push_back(make_run_folder(data.path(), "fan"));
  // All want the same names, and an empty folder can be replaced by a plain rename.
  std::vector<fs::path> discarded(runs.size());
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < 4; ++k) {
    threads.emplace_back([&, k] {
      for (std::size_t i = k; i < runs.size(); i += 4) discarded[i] = discard_run({runs[i].folder, "fan", "01"});
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(std::set<fs::path>(discarded.begin(), discarded.end()).size(), runs.size());
}

TEST(DiscardRun, RenamesItToWhatNoCommandReads) {
  const test::TemporaryFolder data;
  for (int k = 1; k <= 2; ++k) {
    const RunFolder run = make_run_folder(data.path(), "fan");
    EXPECT_EQ(run.run, "01");
    write_whole(run.events(), "events");
    EXPECT_EQ(find_runs(data.path()).size(), 1U);
    const fs::path discarded = discard_run(run);
    EXPECT_EQ(discarded.filename(), "01.discarded-" + std::to_string(k));
    EXPECT_EQ(read_text(discarded / "events.aedat4"), "events");
    EXPECT_TRUE(find_runs(data.path()).empty());
  }
}

}  // namespace
}  // namespace tactile::capture
