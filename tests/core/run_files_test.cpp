#include "tactile/core/run_files.hpp"

#include <gtest/gtest.h>

#include <array>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

using Names = std::vector<std::string>;

/// A run of three files, listed as they are.
class RunFilesTest : public testing::Test {
 protected:
  RunFilesTest() {
    write_whole(run.events(), "events");
    write_whole(run.robot(), "timestamp\n");
    write_whole(run.labels(), "{}");
    info.extra["files"] = files_json(std::array{run.events(), run.robot()});
  }
  RunFiles check(FileComparison comparison = FileComparison::contents) const { return check_files(run, info, comparison); }

  test::TemporaryFolder folder;
  RunFolder run{folder / "fan" / std::string("03"), "fan", "03"};
  RunInfo info;
};

TEST_F(RunFilesTest, AreListedByNameWithDigestAndSize) {
  EXPECT_EQ(info.extra["files"]["events.aedat4"]["bytes"], 6);
  EXPECT_EQ(info.extra["files"]["events.aedat4"]["sha256"], "862417b9e7c3720bcb3263cd873b09892d787823b6f9a0f453e42824c5a4d4b6");
  EXPECT_THROW(files_json(std::array{run.truth()}), Error);
}

TEST_F(RunFilesTest, AreAsListedUntilOneChanges) {
  EXPECT_EQ(check().as_listed, (Names{"events.aedat4", "robot.csv"}));
  EXPECT_TRUE(check().is_listed);
  EXPECT_TRUE(check().reasons.empty());
  write_whole(run.events(), "EVENTS");
  EXPECT_EQ(check().changed, Names{"events.aedat4"});
  ASSERT_EQ(check().reasons.size(), 1U);
  EXPECT_NE(check().reasons[0].find("events.aedat4: has changed"), std::string::npos) << check().reasons[0];
  EXPECT_TRUE(check(FileComparison::size).reasons.empty()) << "the size is the same";
  write_whole(run.events(), "more events");
  EXPECT_EQ(check(FileComparison::size).changed, Names{"events.aedat4"});
}

TEST_F(RunFilesTest, ReportWhatIsMissingAndWhatIsNotListed) {
  std::filesystem::remove(run.robot());
  write_whole(run.video(), "film");
  EXPECT_EQ(check().missing, Names{"robot.csv"});
  EXPECT_EQ(check().not_listed, Names{"video.mp4"});
  EXPECT_EQ(check().reasons.size(), 1U) << "what is not listed is no fault";
}

TEST_F(RunFilesTest, LabelsMayChange) {
  info.extra["files"].update(files_json(std::array{run.labels()}));
  write_whole(run.labels(), "{\"intervals\": []}");
  EXPECT_TRUE(check().reasons.empty());
}

TEST_F(RunFilesTest, NeverLeadOutOfTheRun) {
  write_whole(folder / "secret", "secret");
  info.extra["files"] = {{"../../secret", {{"bytes", 6}, {"sha256", ""}}}, {"", {{"bytes", 6}, {"sha256", ""}}}};
  EXPECT_EQ(check().changed.size(), 2U);
  EXPECT_EQ(check().reasons.size(), 2U);
}

TEST_F(RunFilesTest, ReportAListThatIsNone) {
  info.extra["files"] = 5;
  EXPECT_EQ(check().reasons.size(), 1U);
  info.extra["files"] = {{"events.aedat4", {{"bytes", -6}, {"sha256", 7}}}};
  EXPECT_EQ(check().changed, Names{"events.aedat4"});
  info.extra.erase("files");
  EXPECT_FALSE(check().is_listed);
  EXPECT_TRUE(check().reasons.empty());
}

TEST_F(RunFilesTest, CountTheBytesRead) {
  std::uint64_t done = 0, total = 0;
  check_files(run, info, FileComparison::contents, [&](const Progress& p) { done = p.done, total = p.total; });
  EXPECT_EQ(done, 16U);
  EXPECT_EQ(total, 16U);
}

}  // namespace
}  // namespace tactile
