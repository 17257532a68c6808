#include "tactile/labels/label_edit.hpp"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>

#include "labels/exchange/exported.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/human_edits.hpp"
#include "tactile/labels/saved_labels.hpp"

namespace tactile::labels {
namespace {

using test::in_run;
using test::interval_of;

const RecordingSpan recording{in_run(0), in_run(1'000'000)};

/// press-1 at 100 to 200 ms with a flag, slip-1 at 300 to 400 ms, and a flag on the run.
Labels machines() {
  Labels labels;
  labels.intervals = {interval_of("press-1", Touch::press, 100'000, 200'000),
                      interval_of("slip-1", Touch::slip, 300'000, 400'000)};
  labels.flags = {{.interval_index = 0, .reason = "weak", .key = "weak"},
                  {.interval_index = {}, .reason = "one press", .key = "one"}};
  return labels;
}

std::string text_of(const Labels& labels) {
  const test::TemporaryFolder folder;
  write_labels(folder / "labels.json", labels);
  return read_text(folder / "labels.json");
}

std::string text_without_history(Labels labels) {
  labels.history = {};
  return text_of(labels);
}

Labels edit(const Labels& labels, const LabelEdit& one) { return edited(labels, one, recording, {.who = "ada", .why = "seen"}); }

void expect_refused(const LabelEdit& one, const std::string& part) {
  try {
    with_edit(machines(), one, recording);
    ADD_FAILURE() << "expected: " << part;
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  }
}

TEST(LabelEdit, AMovedOnsetIsThePersonsWithinWhatTheySaw) {
  const Labels labels = with_edit(machines(), MoveEnd{.id = "press-1", .to = in_run(120'000), .within = 250us}, recording);
  const LabelledInterval& press = labels.intervals.at(0);
  EXPECT_EQ(press.start.at, in_run(120'000));
  EXPECT_EQ(press.start.low, in_run(119'750));
  EXPECT_EQ(press.start.high, in_run(120'250));
  EXPECT_EQ(press.end.at, in_run(200'000));
  EXPECT_EQ(press.source, "person");
  EXPECT_TRUE(press.confirmed);
  EXPECT_TRUE(labels.flags.at(0).confirmed);
  EXPECT_FALSE(labels.flags.at(1).confirmed);
  EXPECT_TRUE(labels.rejected.empty());
}

TEST(LabelEdit, OneThatCannotBeIsRefusedInOneSentence) {
  expect_refused(MoveEnd{.id = "press-9", .to = in_run(1)}, "'press-9': there is none; expected press-1, slip-1");
  expect_refused(MoveEnd{.id = "press-1", .to = in_run(200'000)}, "its end after its start");
  expect_refused(MoveEnd{.id = "press-1", .to = in_run(-1)}, "outside the recording; expected 0 s to 1.000000 s");
  expect_refused(MoveEnd{.id = "press-1", .which = IntervalEnd::end, .to = in_run(310'000), .end_earlier = true},
                 "would overlap slip-1");
  expect_refused(MoveEnd{.id = "slip-1", .to = in_run(150'000)}, "a place that is free, once the end of press-1 is moved");
  expect_refused(AddInterval{.touch = Touch::none, .start = in_run(500'000), .end = in_run(600'000)}, "class none");
  expect_refused(AddInterval{.start = in_run(500'000), .end = in_run(1'000'001)}, "outside the recording");
  expect_refused(ChangeClass{.id = "slip-1", .touch = Touch::slip}, "is a slip already");
  expect_refused(LiftFlag{2}, "flag 3: the run has 2");
}

TEST(LabelEdit, ALaterStartEndsTheEarlierIntervalWhereThePersonWantsIt) {
  const Labels labels = with_edit(machines(), MoveEnd{.id = "slip-1", .to = in_run(150'000), .end_earlier = true}, recording);
  EXPECT_EQ(labels.intervals.at(0).end.at, in_run(150'000));
  EXPECT_TRUE(labels.intervals.at(0).confirmed);
  EXPECT_EQ(labels.intervals.at(1).start.at, in_run(150'000));
}

TEST(LabelEdit, ARejectedIntervalTakesItsFlagsAlong) {
  const Labels labels = with_edit(machines(), RejectInterval{"press-1"}, recording);
  ASSERT_EQ(labels.intervals.size(), 1U);
  ASSERT_EQ(labels.rejected.size(), 1U);
  EXPECT_EQ(labels.rejected[0].start, in_run(100'000));
  ASSERT_EQ(labels.flags.size(), 1U);
  EXPECT_EQ(labels.flags[0].key, "one");
}

TEST(LabelEdit, AnAddedIntervalGetsTheNextFreeId) {
  const Labels labels = with_edit(machines(), AddInterval{.start = in_run(500'000), .end = in_run(600'000)}, recording);
  ASSERT_EQ(labels.intervals.size(), 3U);
  EXPECT_EQ(labels.intervals[2].id, "press-2");
  EXPECT_TRUE(labels.intervals[2].confirmed);
}

TEST(LabelEdit, AnIntervalThatWasMovedAwayOrIsOfAnotherClassIsNotFoundAgain) {
  for (const LabelEdit& one : {LabelEdit(ChangeClass{.id = "slip-1", .touch = Touch::press}),
                               LabelEdit(MoveEnd{.id = "slip-1", .which = IntervalEnd::end, .to = in_run(310'000)})}) {
    const Labels again = keep_human_edits(machines(), with_edit(machines(), one, recording));
    ASSERT_EQ(again.intervals.size(), 2U);
    EXPECT_EQ(again.intervals[1].source, "person");
  }
  Labels labels = with_edit(machines(), MoveEnd{.id = "slip-1", .which = IntervalEnd::end, .to = in_run(600'000)}, recording);
  labels = with_edit(labels, MoveEnd{.id = "slip-1", .to = in_run(500'000)}, recording);
  EXPECT_EQ(keep_human_edits(machines(), labels).intervals.size(), 2U);
}

TEST(LabelEdit, ConfirmingTheRunLiftsEveryFlag) {
  const Labels labels = with_edit(machines(), ConfirmRun{}, recording);
  EXPECT_TRUE(labels.intervals.at(0).confirmed && labels.intervals.at(1).confirmed);
  EXPECT_FALSE(labels.run_is_flagged());
  EXPECT_FALSE(labels.interval_is_flagged(0));
}

TEST(LabelEdit, AnImportRemovesWhatItsFileLacks) {
  ImportedLabels file{.where = "fan-01.csv"};
  file.intervals = {{.id = "slip-1", .touch = Touch::slip, .start_us = 50'000, .end_us = 150'000, .where = "line 1"}};
  const Labels labels = with_edit(machines(), ImportFile{file, {.zero_us = 250'000}}, recording);
  ASSERT_EQ(labels.intervals.size(), 1U);
  EXPECT_EQ(labels.rejected.size(), 1U);
  const Labels emptied = with_edit(machines(), ImportFile{{.where = "fan-01.csv"}, {}}, recording);
  EXPECT_EQ(emptied.rejected.size(), 2U);
}

TEST(LabelEdit, ChangesAreNamedByTheEditsThatMakeThem) {
  Labels after = with_edit(machines(), MoveEnd{.id = "press-1", .to = in_run(120'000)}, recording);
  after = with_edit(after, RejectInterval{"slip-1"}, recording);
  after = with_edit(after, AddInterval{.start = in_run(500'000), .end = in_run(600'000)}, recording);
  const std::vector<std::string> expected{"start of press-1 from 0.100000 s to 0.120000 s",
                                          "slip-1 rejected, from 0.300000 s to 0.400000 s",
                                          "press added from 0.500000 s to 0.600000 s"};
  EXPECT_EQ(words_of_changes(machines(), after, recording), expected);
  const Labels confirmed = with_edit(machines(), ConfirmInterval{"slip-1"}, recording);
  EXPECT_EQ(words_of_changes(machines(), confirmed, recording), std::vector<std::string>{"slip-1 confirmed"});
  EXPECT_TRUE(words_of_changes(machines(), machines(), recording).empty());
}

TEST(LabelEdit, SnapsToTheNearestTickAndEvent) {
  EXPECT_EQ(nearest_tick(camera_time(2'999), 2ms), camera_time(2'000));
  EXPECT_EQ(nearest_tick(camera_time(3'001), 2ms), camera_time(4'000));
  EXPECT_EQ(nearest_tick(camera_time(3'000), 2ms), camera_time(2'000));
  EXPECT_THROW(nearest_tick(camera_time(1), 0us), Error);
  const std::array events{camera_time(10), camera_time(20)};
  EXPECT_EQ(nearest_event(camera_time(15), events), camera_time(10));
  EXPECT_EQ(nearest_event(camera_time(16), events), camera_time(20));
  EXPECT_EQ(nearest_event(camera_time(99), events), camera_time(20));
  EXPECT_EQ(nearest_event(camera_time(0), events), camera_time(10));
  EXPECT_FALSE(nearest_event(camera_time(0), {}));
}

/// One of each edit, in turn.
std::vector<LabelEdit> all_edits() {
  return {MoveEnd{.id = "press-1", .to = in_run(120'000)},
          AddInterval{.start = in_run(500'000), .end = in_run(600'000)},
          RejectInterval{"slip-1"},
          ChangeClass{.id = "press-2", .touch = Touch::slip},
          ConfirmInterval{"press-1"},
          LiftFlag{1},
          ImportFile{{.where = "fan-01.txt"}, {}},
          ConfirmRun{}};
}

TEST(EditHistory, EveryEditIsUndoneAndRedoneExactlyAlsoThroughTheFile) {
  const test::TemporaryFolder folder;
  std::vector<std::string> states;
  Labels labels = machines();
  states.push_back(text_without_history(labels));
  for (const LabelEdit& one : all_edits()) {
    labels = edit(labels, one);
    states.push_back(text_without_history(labels));
    write_labels(folder / "labels.json", labels);
    labels = read_labels(folder / "labels.json");
  }
  ASSERT_EQ(labels.history.entries.size(), states.size() - 1);
  EXPECT_EQ(labels.history.entries[0].what, "start of press-1 from 0.100000 s to 0.120000 s");
  EXPECT_EQ(labels.history.entries[0].who, "ada");
  EXPECT_EQ(labels.history.entries[0].why, "seen");
  for (std::size_t i = states.size() - 1; i-- > 0;) {
    labels = undone(labels);
    EXPECT_EQ(text_without_history(labels), states[i]) << i;
  }
  EXPECT_THROW(undone(labels), Error);
  for (std::size_t i = 1; i < states.size(); ++i) {
    labels = redone(labels);
    EXPECT_EQ(text_without_history(labels), states[i]) << i;
  }
  EXPECT_THROW(redone(labels), Error);
  EXPECT_EQ(text_without_history(undone(labels, states.size() - 1)), states.front());
}

TEST(EditHistory, NamesHowManyEditsCanBeUndoneAndRedone) {
  Labels labels = edit(machines(), ConfirmRun{});
  EXPECT_EQ(test::error_of([&] { undone(labels, 2); }), "2 edits to undo, but only 1 edit made; expected at most 1");
  labels = undone(edit(labels, ConfirmInterval{"slip-1"}));
  EXPECT_EQ(test::error_of([&] { redone(labels, 3); }), "3 edits to redo, but only 1 edit undone; expected at most 1");
}

TEST(EditHistory, AnotherEditEndsWhatCanBeRedone) {
  Labels labels = undone(edit(machines(), ConfirmRun{}));
  labels = edit(labels, ConfirmInterval{"slip-1"});
  ASSERT_EQ(labels.history.entries.size(), 1U);
  EXPECT_EQ(labels.history.entries[0].what, "slip-1 confirmed");
  EXPECT_THROW(redone(labels), Error);
}

TEST(EditHistory, AfterLabellingAgainAnUndoneEditShowsTheNewLabel) {
  Labels fresh = machines();
  fresh.intervals[0].start.at = in_run(104'000);
  fresh.intervals[1].end.at = in_run(404'000);
  Labels edits = machines();
  for (const LabelEdit& one : all_edits()) edits = edit(edits, one);
  for (std::size_t redoable = 0; redoable <= all_edits().size(); ++redoable) {
    const Labels again = relabelled(fresh, undone(edits, redoable));
    EXPECT_EQ(text_without_history(undone(again, all_edits().size() - redoable)), text_of(fresh)) << redoable;
    const Labels all = redone(again, redoable);
    EXPECT_EQ(text_without_history(all), text_without_history(keep_human_edits(fresh, edits))) << redoable;
    EXPECT_EQ(all.history.entries.front().when, edits.history.entries.front().when);
  }
}

TEST(EditHistory, DiscardedEditsComeBack) {
  const Labels moved = edit(machines(), MoveEnd{.id = "press-1", .to = in_run(120'000)});
  const Labels forced = relabelled_without_edits(machines(), moved, {.who = "ada", .why = ""});
  EXPECT_EQ(text_without_history(forced), text_of(machines()));
  EXPECT_EQ(text_without_history(undone(forced)), text_without_history(moved));
  EXPECT_TRUE(relabelled_without_edits(machines(), machines(), {}).history.entries.empty());
}

TEST(EditHistory, AnEditUnderAnotherProgramsChangeIsNotUndoneByGuess) {
  Labels labels = edit(machines(), MoveEnd{.id = "press-1", .to = in_run(120'000)});
  labels.intervals[0].start.at = in_run(130'000);
  EXPECT_THROW(undone(labels), Error);
  const Labels again = relabelled(machines(), labels);
  ASSERT_EQ(again.history.entries.size(), 1U);
  EXPECT_FALSE(again.history.entries[0].change);
  EXPECT_THROW(undone(again), Error);
}

TEST(EditHistory, TooManyEditsAreRefusedAndTheOldestLeaveBeforeTheFileIsTooLarge) {
  const test::TemporaryFolder folder;
  Labels labels = edit(machines(), ConfirmRun{});
  labels.history.entries.resize(20'000, labels.history.entries.front());
  labels.history.entries.back().what = "the last";
  write_labels(folder / "labels.json", labels);
  const Labels read = read_labels(folder / "labels.json");
  EXPECT_LT(read.history.entries.size(), 20'000U);
  EXPECT_GT(read.history.entries.size(), 1'000U);
  EXPECT_EQ(read.history.entries.back().what, "the last");
  nlohmann::json object = read_json(folder / "labels.json");
  const nlohmann::json small = {{"who", ""}, {"when", ""}, {"what", ""}, {"why", ""}, {"replaced", nullptr}};
  object["history"] = {{"undone", 0}, {"entries", nlohmann::json::array()}};
  for (std::size_t i = 0; i <= most_history_entries; ++i) object["history"]["entries"].push_back(small);
  write_whole(folder / "labels.json", object.dump());
  EXPECT_THROW(read_labels(folder / "labels.json"), Error);
}

TEST(LabelEdit, AFlagIsLiftedWithAReason) {
  EXPECT_THROW(edited(machines(), LiftFlag{0}, recording, {.who = "ada", .why = ""}), Error);
  EXPECT_FALSE(edited(machines(), LiftFlag{0}, recording, {.who = "ada", .why = "seen"}).interval_is_flagged(0));
}

}  // namespace
}  // namespace tactile::labels
