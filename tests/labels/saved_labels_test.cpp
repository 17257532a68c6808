#include "tactile/labels/saved_labels.hpp"

#include <gtest/gtest.h>

#include <future>

#include "alignment/made_run.hpp"
#include "labels/press_and_slip.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/label_runs.hpp"

namespace tactile::labels {
namespace {

const EditNote ada{.who = "ada", .why = ""};

class SavedLabels : public testing::Test {
 protected:
  void SetUp() override {
    run = test::write_made_run(data.path(), test::press_and_slip, test::lift_after_press);
    const std::vector<RunOutcome> labelled = label_runs({run});
    ASSERT_EQ(labelled.at(0).error, "");
    ASSERT_EQ(labelled.at(0).labels.intervals.size(), 2U);
    machines = read_versioned_labels(run);
  }

  std::string text() const { return read_text(run.labels()); }

  static const VersionedLabels& saved(const SaveOutcome& outcome) { return std::get<VersionedLabels>(outcome); }

  /// A press of one millisecond, where no other is.
  static AddInterval short_press(int number) {
    const CameraTime start = camera_time(test::made_camera_begin_us + 2'200'000 + std::int64_t{10'000} * number);
    return {.start = start, .end = after(start, 1ms)};
  }

  test::TemporaryFolder data;
  RunFolder run;
  VersionedLabels machines;
};

TEST_F(SavedLabels, AnEditOfTheLabelsThatThePersonSawIsSaved) {
  const VersionedLabels after = saved(save_edit(run, machines.version, RejectInterval{"press-1"}, ada));
  EXPECT_NE(after.version, machines.version);
  const VersionedLabels read = read_versioned_labels(run);
  EXPECT_EQ(read.version, after.version);
  ASSERT_EQ(read.labels.intervals.size(), 1U);
  EXPECT_EQ(read.labels.intervals[0].id, "slip-1");
  ASSERT_EQ(read.labels.history.entries.size(), 1U);
  EXPECT_EQ(read.labels.history.entries[0].who, "ada");
}

TEST_F(SavedLabels, WhatShowsThemIsKeptOnlyWhileTheyAreUnchanged) {
  const std::string version = read_versioned_labels(run).version;
  int used = 0;
  EXPECT_TRUE(while_unchanged(run, version, [&] { ++used; }));
  save_edit(run, std::nullopt, ConfirmRun{}, ada);
  EXPECT_FALSE(while_unchanged(run, version, [&] { ++used; }));
  EXPECT_EQ(used, 1);
  EXPECT_THROW(while_unchanged(run, read_versioned_labels(run).version, [] { throw Error("no room"); }), Error);
}

TEST_F(SavedLabels, AnEditOfOlderLabelsIsAConflictThatChangesNothing) {
  const std::string now = saved(save_edit(run, machines.version, ConfirmInterval{"slip-1"}, ada)).version;
  const std::string before = text();
  for (const SaveOutcome& outcome : {save_edit(run, machines.version, RejectInterval{"press-1"}, ada),
                                     save_undo(run, machines.version), save_redo(run, machines.version)}) {
    const auto* conflict = std::get_if<EditConflict>(&outcome);
    ASSERT_NE(conflict, nullptr);
    EXPECT_EQ(conflict->current.version, now);
    EXPECT_TRUE(conflict->current.labels.intervals.at(1).confirmed);
    EXPECT_EQ(conflict->current.labels.history.entries.size(), 1U);
  }
  EXPECT_EQ(text(), before);
}

TEST_F(SavedLabels, AnEditThatCannotBeMadeChangesNothing) {
  const std::string before = text();
  EXPECT_THROW(save_edit(run, std::nullopt, RejectInterval{"press-9"}, ada), Error);
  EXPECT_THROW(save_undo(run, std::nullopt), Error);
  EXPECT_EQ(text(), before);
  std::filesystem::remove(run.labels());
  EXPECT_THROW(save_edit(run, std::nullopt, ConfirmRun{}, ada), Error);
  EXPECT_FALSE(std::filesystem::exists(run.labels()));
}

TEST_F(SavedLabels, AreUndoneAndRedone) {
  save_edit(run, std::nullopt, RejectInterval{"press-1"}, ada);
  const std::string rejected = text();
  save_edit(run, std::nullopt, ConfirmRun{}, ada);
  const std::string confirmed = text();
  const VersionedLabels none = saved(save_undo(run, std::nullopt, 2));
  EXPECT_EQ(none.labels.intervals.size(), 2U);
  EXPECT_EQ(none.labels.history.undone, 2U);
  const VersionedLabels one = saved(save_redo(run, none.version));
  EXPECT_EQ(one.labels.intervals.size(), 1U);
  EXPECT_FALSE(one.labels.intervals[0].confirmed);
  save_redo(run, one.version);
  EXPECT_EQ(text(), confirmed);
  save_undo(run, std::nullopt);
  save_redo(run, std::nullopt);
  EXPECT_EQ(text(), confirmed);
  EXPECT_NE(confirmed, rejected);
}

TEST_F(SavedLabels, AnEditMadeWhileTheRunIsLabelledAgainIsKept) {
  // Once `label_runs` has found the labels, and before it has made new ones.
  LabelRunsOptions options;
  int edits = 0;
  options.has_companions = [&](const RunFolder&) {
    save_edit(run, std::nullopt, RejectInterval{"press-1"}, ada);
    ++edits;
    return false;
  };
  const std::vector<RunOutcome> labelled = label_runs({run}, options);
  EXPECT_EQ(edits, 1);
  EXPECT_FALSE(labelled.at(0).unchanged);
  const Labels now = read_labels(run.labels());
  ASSERT_EQ(now.intervals.size(), 1U);
  EXPECT_EQ(now.rejected.size(), 1U);
  EXPECT_EQ(saved(save_undo(run, std::nullopt)).labels.intervals.size(), 2U);
}

TEST_F(SavedLabels, OfTwoWhoEditAtOnceNoEditIsLost) {
  constexpr int each = 15;
  const auto add = [&](int first) {
    for (int i = first; i < first + each; ++i) save_edit(run, std::nullopt, short_press(i), ada);
  };
  std::future<void> other = std::async(std::launch::async, add, each);
  add(0);
  other.get();
  const Labels labels = read_labels(run.labels());
  EXPECT_EQ(labels.intervals.size(), 2U + 2U * each);
  EXPECT_EQ(labels.history.entries.size(), 2U * each);
}

TEST_F(SavedLabels, OfTwoWhoSawTheSameLabelsOneIsAsked) {
  const auto edit = [&](int number) { return save_edit(run, machines.version, short_press(number), ada); };
  std::future<SaveOutcome> other = std::async(std::launch::async, edit, 1);
  const SaveOutcome first = edit(0), second = other.get();
  EXPECT_NE(std::holds_alternative<EditConflict>(first), std::holds_alternative<EditConflict>(second));
  EXPECT_EQ(read_labels(run.labels()).intervals.size(), 3U);
}

}  // namespace
}  // namespace tactile::labels
