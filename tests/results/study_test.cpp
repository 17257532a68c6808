#include "tactile/results/study.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::results {
namespace {

/// Every list has an entry.
Study a_study() {
  const SeenAndHeldOut fan{{.value = 0.75}, {.value = 0.5}, {.value = -0.25}};
  StudiedSetting setting{.setting = "th040-unseen", .text = "LeNet", .is_unseen = true, .history_ms = 40};
  setting.accuracy = {{.value = 0.875, .low = 0.75, .high = 0.9375, .n = 3}, {{"fan", {.value = 0.5}}}};
  setting.whole_runs.runs = {"501/fan/03"};
  setting.whole_runs.causes["release"] = 2;
  Claim claim{.id = "history-2-worst", .limit = 1, .written = 2, .replicates = 7, .outcome = Outcome::does_not};
  return {.title = "A study",
          .simulated = true,
          .settings = {{"data", "data"}},
          .software = {{"name", "tactile"}},
          .machine = {{"cores", 2}},
          .bootstrap = {.draws = 100, .confidence = 0.9, .seed = 3},
          .intervals = "7 worlds.",
          .steps = {{.name = "train", .command = "tactile train", .seconds = 1.5, .finished_at = "2026-01-02T03:04:05Z"}},
          .worlds = {{.name = "501",
                      .data = "data/world-501",
                      .manifest_hash = "ab",
                      .runs = 3,
                      .samples = 12,
                      .held_out = {"fan"},
                      .left_out = {{"fan/04", "press-1", "flagged"}}}},
          .models = {{.world = 0, .training = 1, .setting = "stream", .name = "m", .folder = "models/m", .seed = 2}},
          .cells = "cells.csv",
          .results = {setting},
          .unseen = {{"stream", "stream", {{}, {"fan/02"}, fan, {{"fan", fan}}}}},
          .full_runs = {{.run = "fan/02", .model = "m", .history_ms = 2, .csv = "runs/fan-02.csv"}},
          .claims = {claim},
          .found = {"It was found."},
          .remarks = {"A remark."}};
}

class StudyFile : public testing::Test {
 protected:
  Study read(const nlohmann::json& json) const {
    std::ofstream(folder_ / "study.json") << json;
    return read_study(folder_.path());
  }

  test::TemporaryFolder folder_;
};

TEST_F(StudyFile, IsReadAsWritten) {
  const nlohmann::json json = a_study();
  const Study study = read(json);
  EXPECT_EQ(nlohmann::json(study), json);
  EXPECT_EQ(study.bootstrap.draws, 100U);
  EXPECT_EQ(study.worlds.at(0).left_out.at(0).what, "press-1");
  EXPECT_EQ(study.results.at(0).accuracy.mean.low, 0.75);
  EXPECT_EQ(study.unseen.at(0).accuracy.objects.at("fan").difference.value, -0.25);
  EXPECT_EQ(study.claims.at(0).outcome, Outcome::does_not);
  ASSERT_NE(study.find("th040-unseen"), nullptr);
  EXPECT_EQ(study.find("th040-unseen")->whole_runs.causes.at("release"), 2U);
  EXPECT_EQ(study.find("th040"), nullptr);
}

TEST_F(StudyFile, OfAnotherFormatOrTypeIsNamed) {
  nlohmann::json json = a_study();
  const std::string file = (folder_ / "study.json").string();
  json["worlds"][0]["samples"] = "many";
  EXPECT_EQ(test::error_of([&] { read(json); }), file + ": 'worlds': 'samples' is string; expected a whole number from 0");
  json = a_study();
  json["claims"][0]["outcome"] = "maybe";
  EXPECT_EQ(test::error_of([&] { read(json); }),
            file + ": 'claims': 'outcome' is 'maybe'; expected holds, does not or cannot tell");
  json["format"] = "tactile-study-1";
  EXPECT_EQ(
      test::error_of([&] { read(json); }),
      file + ": 'format' is 'tactile-study-1'; expected tactile-study-2, as 'tactile reproduce' writes it into another folder");
}

}  // namespace
}  // namespace tactile::results
