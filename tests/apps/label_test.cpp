#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

using test::run_tactile;

class LabelCommand : public testing::Test {
 protected:
  void SetUp() override {
    const auto made = run_tactile("simulate --preset tiny --objects fan,usb-hub --runs 1", folder.path());
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  test::TemporaryFolder folder;
};

TEST_F(LabelCommand, GivesTheSameBytesWithoutTheTruthAndForAnyThreads) {
  ASSERT_EQ(run_tactile("label --threads 1", folder.path()).exit_code, 0);
  const std::string first = read_text(folder.path() / "data/fan/01/labels.json");
  std::filesystem::remove(folder.path() / "data/fan/01/truth.json");
  ASSERT_EQ(run_tactile("label --threads 2", folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder.path() / "data/fan/01/labels.json"), first);
}

TEST_F(LabelCommand, ComparesWithTheTruthToMilliseconds) {
  const auto result = run_tactile("label --compare-truth --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto truth = nlohmann::json::parse(result.out).at("truth");
  EXPECT_EQ(truth.at("runs"), 2);
  EXPECT_EQ(truth.at("missed"), 0);
  EXPECT_EQ(truth.at("spurious"), 0);
  EXPECT_LE(truth.at("errors_ms").at("press_onset").at("max"), 10.0);
  EXPECT_LE(truth.at("errors_ms").at("slip_onset").at("max"), 20.0);
}

TEST_F(LabelCommand, KeepsLabelsThatAPersonConfirmedUnlessForced) {
  ASSERT_EQ(run_tactile("label", folder.path()).exit_code, 0);
  const auto file = folder.path() / "data/fan/01/labels.json";
  auto labels = nlohmann::json::parse(read_text(file));
  labels.at("intervals").at(0).at("confirmed") = true;
  write_whole(file, labels.dump());
  const auto again = run_tactile("label", folder.path());
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.err.find("fan/01"), std::string::npos) << again.err;
  EXPECT_EQ(read_text(file), labels.dump());
  EXPECT_EQ(run_tactile("label --force", folder.path()).exit_code, 0);
  EXPECT_NE(read_text(file), labels.dump());
}

TEST_F(LabelCommand, NamesARunThatCannotBeReadAndLabelsTheOthers) {
  write_whole(folder.path() / "data/fan/01/robot.csv", "");
  const auto result = run_tactile("label", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("fan/01/robot.csv"), std::string::npos) << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "data/usb-hub/01/labels.json"));
}

TEST_F(LabelCommand, FlagsARecordingThatWasCutOff) {
  std::filesystem::resize_file(folder.path() / "data/fan/01/events.aedat4", 900'000);
  const auto result = run_tactile("label data/fan/01 --json", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("cut off"), std::string::npos) << result.out;
}

TEST_F(LabelCommand, OfEventsThatChangedSinceAreNotUsed) {
  ASSERT_EQ(run_tactile("label", folder.path()).exit_code, 0);
  std::filesystem::copy_file(folder.path() / "data/usb-hub/01/events.aedat4", folder.path() / "data/fan/01/events.aedat4",
                             std::filesystem::copy_options::overwrite_existing);
  const auto result = run_tactile("windows", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("fan/01: left out"), std::string::npos) << result.err;
}

TEST_F(LabelCommand, IsNotUndoneByMakingTheSameRunAgain) {
  ASSERT_EQ(run_tactile("label", folder.path()).exit_code, 0);
  const std::string before = read_text(folder.path() / "data/fan/01/labels.json");
  std::filesystem::remove(folder.path() / "data/fan/01/truth.json");
  ASSERT_EQ(run_tactile("simulate --preset tiny --objects fan,usb-hub --runs 1", folder.path()).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "data/fan/01/truth.json"));
  EXPECT_EQ(read_text(folder.path() / "data/fan/01/labels.json"), before);
}

TEST_F(LabelCommand, WithoutTruthToCompareWithIsAnError) {
  for (const char* run : {"data/fan/01", "data/usb-hub/01"}) std::filesystem::remove(folder.path() / run / "truth.json");
  EXPECT_EQ(run_tactile("label --compare-truth", folder.path()).exit_code, 1);
}

}  // namespace
}  // namespace tactile
