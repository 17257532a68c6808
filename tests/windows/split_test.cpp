#include "tactile/windows/split.hpp"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::windows {
namespace {

using Indexes = std::vector<std::uint32_t>;

std::vector<RunName> three_objects() {
  return {{"box", "01"}, {"box", "02"}, {"box", "03"}, {"fan", "01"}, {"fan", "02"}, {"sprayer", "01"}, {"sprayer", "02"}};
}

std::string message_of(std::span<const RunName> runs, const SplitOptions& options) {
  try {
    split_runs(runs, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing thrown";
}

TEST(SingleRunSplit, TrainsOnOneRunOfEveryObjectAndTestsOnTheOthers) {
  const Split split = split_runs(three_objects(), {});
  EXPECT_EQ(split.train_runs, (Indexes{0, 3, 5}));
  EXPECT_EQ(split.test_runs, (Indexes{1, 2, 4, 6}));
  EXPECT_EQ(split_runs(three_objects(), {.train_run = "02"}).train_runs, (Indexes{1, 4, 6}));
}

TEST(UnseenSplit, TrainsOnOneRunOfTheOthersAndTestsOnEveryRunOfTheHeldOut) {
  const Split split = split_runs(three_objects(), {.kind = SplitKind::unseen, .train_run = "02", .held_out = {"fan", "sprayer"}});
  EXPECT_EQ(split.train_runs, (Indexes{1}));
  EXPECT_EQ(split.test_runs, (Indexes{3, 4, 5, 6}));
}

TEST(Split, NamesRunsInTheOrderOfTheDatasetWhereverObjectsStand) {
  const std::vector<RunName> runs{{"fan", "02"}, {"box", "02"}, {"fan", "01"}, {"box", "01"}};
  const Split split = split_runs(runs, {});
  EXPECT_EQ(split.train_runs, (Indexes{2, 3}));
  EXPECT_EQ(split.test_runs, (Indexes{0, 1}));
}

TEST(Split, TakesTheNextWholeRunInPlaceOfATrainingRunWithoutSamples) {
  auto runs = three_objects();
  runs[0].has_samples = false;
  const Split second = split_runs(runs, {});
  EXPECT_EQ(second.train_runs, (Indexes{1, 3, 5}));
  EXPECT_EQ(second.test_runs, (Indexes{0, 2, 4, 6})) << "the run that is trained on is not tested on";
  runs[1].has_samples = false;
  EXPECT_EQ(split_runs(runs, {}).train_runs, (Indexes{2, 3, 5}));
  EXPECT_EQ(split_runs(three_objects(), {.train_run = "09"}).train_runs, (Indexes{0, 3, 5})) << "a run that no object has";
}

TEST(Split, TakesTheFirstRunAfterTheLast) {
  auto runs = three_objects();
  runs[2].has_samples = false;
  const Split split = split_runs(runs, {.train_run = "03"});
  EXPECT_EQ(split.train_runs, (Indexes{0, 3, 5})) << "box has 01 after 03; the others have no 03";
  runs[0].has_samples = false;
  EXPECT_EQ(split_runs(runs, {.train_run = "03"}).train_runs, (Indexes{1, 3, 5}));
  EXPECT_EQ(split_runs(runs, {.train_run = "02"}).train_runs, (Indexes{1, 4, 6}));
}

TEST(Split, OrdersRunsByTheirIdsNotByTheirPlaces) {
  const std::vector<RunName> runs{{"box", "03"}, {"box", "01", false}, {"box", "02"}};
  EXPECT_EQ(split_runs(runs, {}).train_runs, (Indexes{2}));
  EXPECT_EQ(split_runs(runs, {.train_run = "03"}).train_runs, (Indexes{0}));
}

TEST(Split, LeavesOutAnObjectWithoutAnyWholeRun) {
  auto runs = three_objects();
  for (const std::uint32_t fan : {3, 4}) runs[fan].has_samples = false;
  const Split split = split_runs(runs, {});
  EXPECT_EQ(split.train_runs, (Indexes{0, 5}));
  EXPECT_EQ(split.test_runs, (Indexes{1, 2, 6}));
  const Split unseen = split_runs(runs, {.kind = SplitKind::unseen, .held_out = {"sprayer"}});
  EXPECT_EQ(unseen.train_runs, (Indexes{0}));
  EXPECT_EQ(unseen.test_runs, (Indexes{5, 6}));
  EXPECT_NE(message_of(runs, {.kind = SplitKind::unseen, .held_out = {"fan"}}).find("left to test on"), std::string::npos);
  for (RunName& run : runs) run.has_samples = false;
  EXPECT_NE(message_of(runs, {}).find("no run with samples is left to train on"), std::string::npos);
}

TEST(UnseenSplit, TakesTheNextWholeRunOfWhatIsNotHeldOut) {
  auto runs = three_objects();
  runs[0].has_samples = false;
  const Split split = split_runs(runs, {.kind = SplitKind::unseen, .held_out = {"fan", "sprayer"}});
  EXPECT_EQ(split.train_runs, (Indexes{1}));
  EXPECT_EQ(split.test_runs, (Indexes{3, 4, 5, 6}));
}

TEST(Split, MindsOnlyTheRunsItTrainsOn) {
  auto runs = three_objects();
  runs[3].has_samples = false;  // fan/01, held out
  EXPECT_EQ(split_runs(runs, {.kind = SplitKind::unseen, .held_out = {"fan"}}).train_runs, (Indexes{0, 5}));
}

TEST(Split, RefusesAHeldOutObjectThatIsNotThereAndEmptySides) {
  EXPECT_NE(message_of(three_objects(), {.kind = SplitKind::unseen, .held_out = {"melon"}}).find("'melon'"), std::string::npos);
  EXPECT_THROW(split_runs(three_objects(), {.kind = SplitKind::unseen, .held_out = {"box", "fan", "sprayer"}}), Error);
  EXPECT_THROW(split_runs(three_objects(), {.kind = SplitKind::unseen, .held_out = {}}), Error);
  const std::vector<RunName> alone{{"box", "01"}};
  EXPECT_THROW(split_runs(alone, {}), Error);
  EXPECT_THROW(split_runs({}, {}), Error);
}

TEST(UnseenSplit, CanBeAnyOf252AndNeverTestsOnWhatItTrainsOn) {
  const std::vector<std::string> objects{"3d-printed-object", "fan",          "plastic-container", "small-box",
                                         "sprayer",           "textured-box", "uhu-glue-stick",    "usb-hub",
                                         "water-bottle",      "white-box"};
  std::vector<RunName> runs;
  for (const std::string& object : objects) {
    for (const char* run : {"01", "02", "03"}) runs.push_back({object, run});
  }
  std::set<std::pair<Indexes, Indexes>> splits;
  for (unsigned chosen = 0; chosen < 1U << objects.size(); ++chosen) {
    SplitOptions options{.kind = SplitKind::unseen, .train_run = "02", .held_out = {}};
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if ((chosen >> i & 1U) != 0) options.held_out.push_back(objects[i]);
    }
    if (options.held_out.size() != 5) continue;
    const Split split = split_runs(runs, options);
    ASSERT_EQ(split.train_runs.size(), 5U);
    ASSERT_EQ(split.test_runs.size(), 15U);
    for (const std::uint32_t trained : split.train_runs) {
      ASSERT_EQ(runs[trained].run, "02");
      for (const std::uint32_t tested : split.test_runs) ASSERT_NE(runs[trained].object, runs[tested].object);
    }
    splits.emplace(split.train_runs, split.test_runs);
  }
  EXPECT_EQ(splits.size(), 252U);
}

TEST(Split, HasNames) {
  for (const SplitKind kind : {SplitKind::single_run, SplitKind::unseen}) EXPECT_EQ(split_named(name_of(kind)), kind);
  EXPECT_EQ(name_of(SplitKind::single_run), "single-run");
  EXPECT_THROW(split_named("by-sample"), Error);
  EXPECT_EQ(default_held_out().size(), 5U);
}

}  // namespace
}  // namespace tactile::windows
