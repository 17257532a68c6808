#include "tactile/experiments/study/plan_study.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::study {
namespace {

TEST(StudyOptions, DrawWorldsWithSeedsThatTheirTrainingsDoNotShare) {
  StudyOptions options{.preset = "paper", .worlds = 3, .trainings = 2, .seed = 501};
  const auto worlds = worlds_of(completed(options, false));
  ASSERT_EQ(worlds.size(), 3U);
  EXPECT_EQ(worlds[0].name, "501");
  EXPECT_EQ(worlds[1].seed, 503U);
  EXPECT_EQ(worlds[2].data, "data/world-505");
  EXPECT_EQ(worlds[2].suffix(), "-505");
}

TEST(StudyOptions, OfOneWorldHaveTheirRunsInTheDataFolder) {
  const auto worlds = worlds_of(completed({.preset = "tiny", .seed = 7}, false));
  ASSERT_EQ(worlds.size(), 1U);
  EXPECT_EQ(worlds[0].data, "data");
  EXPECT_EQ(worlds[0].name, "");
  EXPECT_EQ(worlds[0].seed, 7U);
}

TEST(StudyOptions, OfRunsThatAreThereAreOneWorldOfSeveralTrainings) {
  const StudyOptions own = completed({.preset = "paper"}, true);
  EXPECT_EQ(own.worlds, 1U);
  EXPECT_EQ(own.trainings, 5U);
  EXPECT_EQ(completed({.preset = "paper"}, false).trainings, 1U);
  EXPECT_EQ(test::error_of([] { completed({.preset = "paper", .worlds = 2}, true); }),
            "data: holds runs already, and they are one world; expected no --worlds, which are simulated, or another folder");
}

TEST(StudyOptions, JudgeTheHistoryNearestToThePapers) {
  EXPECT_EQ(main_history(completed({.preset = "tiny"}, false)), 40ms);
  EXPECT_EQ(main_history(completed({.preset = "tiny", .histories = {10ms, 50ms, 2ms}}, false)), 50ms);
}

TEST(StudyOptions, AreRefusedInWords) {
  EXPECT_EQ(test::error_of([] { completed({.preset = "large"}, false); }), "'large' is no preset; expected tiny, quick or paper");
  EXPECT_EQ(test::error_of([] { completed({.preset = "tiny", .trainings = 0}, false); }),
            "no training of a setting; expected one at least");
  EXPECT_EQ(test::error_of([] { completed({.preset = "tiny", .worlds = 0}, false); }), "no world; expected one at least");
}

TEST(SettingName, HasTheHistoryAndWhetherObjectsAreHeldOut) {
  model::ModelSettings settings;
  EXPECT_EQ(setting_name(settings), "th040");
  settings.rendering.history = 2'500us;
  EXPECT_EQ(setting_name(settings), "th002.5");
  settings.kind = model::ModelKind::stream;
  settings.split.kind = windows::SplitKind::unseen;
  EXPECT_EQ(setting_name(settings), "stream-unseen");
}

}  // namespace
}  // namespace tactile::study
