#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

using nlohmann::json;
using test::run_tactile;

/// fan/01 and usb-hub/01 with labels: a press and a slip each.
class LabelEdits : public testing::Test {
 protected:
  void SetUp() override {
    const auto made = run_tactile("simulate --preset tiny --objects fan,usb-hub --runs 1", folder.path());
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const auto labelled = run_tactile("label", folder.path());
    ASSERT_EQ(labelled.exit_code, 0) << labelled.err;
    ASSERT_EQ(labels().at("intervals").size(), 2U);
    first_us = labels().at("provenance").at("first_event_us");
  }

  test::CommandResult label(const std::string& arguments) const { return run_tactile("label " + arguments, folder.path()); }

  std::string done(const std::string& arguments) const {
    const test::CommandResult result = label(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }

  /// One sentence, exit code 1, and no change of any labels.
  void expect_refused(const std::string& arguments, const std::string& part) const {
    const std::string before = text_of("fan/01/labels.json") + text_of("usb-hub/01/labels.json");
    const test::CommandResult result = label(arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(text_of("fan/01/labels.json") + text_of("usb-hub/01/labels.json"), before) << arguments;
  }

  std::string text_of(const std::string& file) const { return read_text(folder / "data" / file); }
  /// The run gets a flag.
  void leave_incomplete(const std::string& run) const {
    json info = json::parse(text_of(run + "/run.json"));
    info["complete"] = false;
    write_whole(folder / "data" / run / "run.json", info.dump());
  }
  json labels(const std::string& run = "fan/01") const { return json::parse(text_of(run + "/labels.json")); }
  json interval(std::size_t index) const { return labels().at("intervals").at(index); }

  test::TemporaryFolder folder;
  std::int64_t first_us = 0;
};

TEST_F(LabelEdits, ThePictureShowsTheLastOfEditsThatAreMadeAtTheSameTime) {
  std::string together;
  for (int i = 0; i < 5; ++i)
    together += "'" + std::string(test::tactile_binary) + "' label --quiet --set fan/01:press-1.start=0." +
                std::to_string(60 + 3 * i) + " & ";
  ASSERT_EQ(test::run_shell(together + "wait", folder.path()).exit_code, 0);
  ASSERT_EQ(labels().at("history").at("entries").size(), 5U);
  const std::string picture = text_of("fan/01/labels.png");
  done("data/fan/01 --undo");
  EXPECT_NE(text_of("fan/01/labels.png"), picture);
  done("data/fan/01 --redo");
  EXPECT_EQ(text_of("fan/01/labels.png"), picture);
}

TEST_F(LabelEdits, AnOnsetIsSetInSecondsFromTheFirstEvent) {
  const std::string picture = text_of("fan/01/labels.png");
  const std::string out = done("--set fan/01:press-1.start=0.7005 --who ada --why 'the first contact'");
  EXPECT_NE(out.find("fan/01: start of press-1 from 0."), std::string::npos) << out;
  EXPECT_NE(out.find(" s to 0.700500 s\n"), std::string::npos) << out;
  EXPECT_EQ(interval(0).at("start_us"), first_us + 700'500);
  EXPECT_EQ(interval(0).at("start_low_us"), first_us + 699'500);
  EXPECT_EQ(interval(0).at("start_high_us"), first_us + 701'500);
  EXPECT_EQ(interval(0).at("source").get<std::string>(), "person");
  EXPECT_TRUE(interval(0).at("confirmed").get<bool>());
  const json entry = labels().at("history").at("entries").at(0);
  EXPECT_EQ(entry.at("who").get<std::string>(), "ada");
  EXPECT_EQ(entry.at("why").get<std::string>(), "the first contact");
  const std::string drawn = text_of("fan/01/labels.png");
  EXPECT_NE(drawn, picture) << "the picture follows at once";
  ASSERT_EQ(label("data/fan/01 --force").exit_code, 0);
  EXPECT_EQ(text_of("fan/01/labels.png"), picture);
  done("data/fan/01 --undo");
  EXPECT_EQ(text_of("fan/01/labels.png"), drawn) << "labels discarded by --force come back, and their picture";
}

TEST_F(LabelEdits, SeveralAreMadeInTheirOrderEachWithItsEntry) {
  const std::string out = done(
      "--no-pictures --reject fan/01:slip-1 --add data/fan/01:slip=1.2..1.3 --set fan/01:slip-1.end=1.4 --confirm "
      "usb-hub/01:press-1 --set fan/01:press-1.class=slip --json");
  const json edited = json::parse(out).at("edited");
  ASSERT_EQ(edited.size(), 5U) << out;
  const auto what = [&](std::size_t i) { return edited.at(i).at("what").get<std::string>(); };
  EXPECT_EQ(what(0).substr(0, 15), "slip-1 rejected");
  EXPECT_EQ(what(1), "slip added from 1.200000 s to 1.300000 s");
  EXPECT_EQ(what(2), "end of slip-1 from 1.300000 s to 1.400000 s");
  EXPECT_EQ(what(3), "class of press-1 from press to slip");
  EXPECT_EQ(what(4), "press-1 confirmed");
  EXPECT_EQ(edited.at(4).at("run").get<std::string>(), "usb-hub/01");
  EXPECT_EQ(labels().at("history").at("entries").size(), 4U);
  EXPECT_EQ(interval(0).at("class").get<std::string>(), "slip");
  EXPECT_EQ(interval(1).at("end_us"), first_us + 1'400'000);
  std::vector<std::string> rejected;
  const json now = labels();
  for (const json& one : now.at("rejected")) rejected.push_back(one.at("class"));
  std::sort(rejected.begin(), rejected.end());
  EXPECT_EQ(rejected, (std::vector<std::string>{"press", "slip"})) << "the press that is a slip now is not found again";
  EXPECT_TRUE(labels("usb-hub/01").at("intervals").at(0).at("confirmed").get<bool>());
  EXPECT_FALSE(labels("usb-hub/01").at("intervals").at(1).at("confirmed").get<bool>());
}

TEST_F(LabelEdits, ConfirmingARunLiftsItsFlags) {
  leave_incomplete("fan/01");
  ASSERT_EQ(label("data/fan/01 --strict").exit_code, 2);
  done("data --confirm fan/01");
  EXPECT_EQ(label("data/fan/01 --strict --summary").exit_code, 0);
  EXPECT_TRUE(interval(0).at("confirmed").get<bool>() && interval(1).at("confirmed").get<bool>());
}

TEST_F(LabelEdits, AFlagIsLiftedByItsWordsWithAReason) {
  leave_incomplete("fan/01");
  ASSERT_EQ(label("data/fan/01 --no-pictures").exit_code, 0);
  expect_refused("--lift 'fan/01:not completed'", "without a reason; expected why the label is right");
  expect_refused("--lift 'fan/01:no such words' --why seen", "0 flags have these words; expected words of one of ");
  done("--lift 'fan/01:not completed' --why 'it is long enough' --no-pictures");
  const json now = labels();
  ASSERT_FALSE(now.at("flags").empty());
  for (const json& flag : now.at("flags")) {
    const bool is_lifted = flag.at("reason").get<std::string>().find("not completed") != std::string::npos;
    EXPECT_EQ(flag.at("confirmed").get<bool>(), is_lifted) << flag;
  }
}

TEST_F(LabelEdits, APatternEditsAllRunsThatItMatches) {
  const auto all_confirmed = [&](const std::string& run) {
    const json now = labels(run);
    return std::all_of(now.at("intervals").begin(), now.at("intervals").end(),
                       [](const json& one) { return one.at("confirmed").get<bool>(); });
  };
  EXPECT_EQ(done("--confirm 'f*/*' --no-pictures"), "fan/01: run confirmed\n");
  EXPECT_FALSE(all_confirmed("usb-hub/01"));
  EXPECT_EQ(done("--confirm '*/01:press-1' --no-pictures"), "usb-hub/01: press-1 confirmed\n") << "fan/01 is confirmed already";
  EXPECT_EQ(done("--confirm 'data/*' --dry-run"), "usb-hub/01: would be: run confirmed\n");
  EXPECT_EQ(done("--confirm '*/*' --no-pictures"), "usb-hub/01: run confirmed\n");
  EXPECT_TRUE(all_confirmed("fan/01") && all_confirmed("usb-hub/01"));
  expect_refused("--confirm '*/*'", "there is nothing to edit in the runs that match");
  expect_refused("--confirm 'mug/*'", "matches no run with labels; expected a pattern of runs in data, such as 'fan/*'");
  expect_refused("--reject 'fan/*:press-1'",
                 "names more than one run; expected one run: only --confirm and --lift take a pattern");
}

TEST_F(LabelEdits, AFlagOfOneKindIsLiftedInAllRuns) {
  leave_incomplete("fan/01");
  leave_incomplete("usb-hub/01");
  ASSERT_EQ(label("--no-pictures").exit_code, 0);
  done("--lift '*/*:not completed' --why 'it is long enough' --no-pictures");
  for (const char* run : {"fan/01", "usb-hub/01"}) {
    const json now = labels(run);
    ASSERT_FALSE(now.at("flags").empty());
    for (const json& flag : now.at("flags")) {
      const bool is_lifted = flag.at("reason").get<std::string>().find("not completed") != std::string::npos;
      EXPECT_EQ(flag.at("confirmed").get<bool>(), is_lifted) << flag;
    }
  }
}

TEST_F(LabelEdits, AreListedUndoneAndRedone) {
  EXPECT_EQ(done("--history"), "no edits\n");
  done("--no-pictures --set fan/01:press-1.start=0.7 --reject fan/01:slip-1 --confirm fan/01 --who ada --why look");
  const json edited = labels();
  EXPECT_EQ(done("--no-pictures data/fan/01 --undo"), "fan/01: undone: run confirmed\n");
  const std::string two = done("--no-pictures data/fan/01 --undo 2");
  EXPECT_EQ(two.find("fan/01: undone: slip-1 rejected"), 0U) << two;
  EXPECT_NE(two.find("\nfan/01: undone: start of press-1"), std::string::npos) << two;
  EXPECT_EQ(labels().at("intervals").size(), 2U);
  const std::string again = done("--no-pictures data/fan/01 --redo 2");
  EXPECT_EQ(again.find("fan/01: redone: start of press-1"), 0U) << again;
  const json history = json::parse(done("--history --json")).at("history");
  ASSERT_EQ(history.size(), 3U);
  EXPECT_FALSE(history.at(1).at("undone").get<bool>());
  EXPECT_TRUE(history.at(2).at("undone").get<bool>());
  EXPECT_EQ(history.at(2).at("who").get<std::string>(), "ada");
  EXPECT_NE(done("data/fan/01 --history").find("ada  undone: run confirmed (look)"), std::string::npos);
  done("--no-pictures data/fan/01 --redo");
  EXPECT_EQ(labels(), edited);
  expect_refused("data/fan/01 --redo", "fan/01: 1 edit to redo, but only 0 edits undone");
  expect_refused("data/usb-hub/01 --undo 3", "usb-hub/01: 3 edits to undo, but only 0 edits made");
}

TEST_F(LabelEdits, WrongInputIsRefusedInOneSentenceAndChangesNothing) {
  expect_refused("--set fan/01:press-9.start=1", "--set 'fan/01:press-9.start=1': interval 'press-9': there is none");
  expect_refused("--set fan/01:press-1.start=x", "'x' is no time; expected seconds from the run's first event");
  expect_refused("--set fan/01:press-1.begin=1", "'begin' cannot be set; expected start, end or class");
  expect_refused("--set fan/01:press-1", "names no setting");
  expect_refused("--set fan/01:press-1.class=none", "'none' is no class; expected press or slip");
  expect_refused("--set fan/01:press-1.end=99", "outside the recording");
  expect_refused("--add fan/01:press=1.2", "describes no interval");
  expect_refused("--add fan/01:press=0.1..9", "outside the recording");
  expect_refused("--reject fan/01", "names no interval");
  expect_refused("--reject fan/09:press-1", "names no run; expected a run's folder, or a name such as fan/01 of a run in data");
  expect_refused("--confirm fan/01 --reject usb-hub/01:press-7", "there is none");
  expect_refused("--undo", "--undo: 2 runs are given; expected one");
  expect_refused("data/fan/01 --undo 0", "--undo '0': is no number of edits");
  expect_refused("--history --undo", "--undo, --history: cannot be combined");
  expect_refused("--confirm fan/01 --summary", "--confirm, --summary: cannot be combined");
  expect_refused("--why x", "--why: belongs to edits");
}

TEST_F(LabelEdits, ADryRunWritesNothing) {
  const std::string before = text_of("fan/01/labels.json");
  const std::string out = done("--reject fan/01:press-1 --dry-run");
  EXPECT_EQ(out.find("fan/01: would be: press-1 rejected, from "), 0U) << out;
  EXPECT_EQ(text_of("fan/01/labels.json"), before);
}

TEST_F(LabelEdits, AnImportIsOneEditThatCanBeTriedAndUndone) {
  const std::string picture = text_of("fan/01/labels.png"), before = text_of("fan/01/labels.json");
  done("data/fan/01 --export fan-01.csv --origin first-event");
  std::string text = read_text(folder / "fan-01.csv");
  const std::size_t row = text.find("fan/01,slip-1"), end = text.find('\n', row);
  ASSERT_NE(row, std::string::npos) << text;
  write_whole(folder / "fan-01.csv", text.erase(row, end - row + 1));
  const json tried = json::parse(done("data/fan/01 --import fan-01.csv --dry-run --json")).at("imported").at(0);
  EXPECT_EQ(tried.at("rejected"), 1);
  ASSERT_EQ(tried.at("changes").size(), 1U);
  const std::string change = tried.at("changes").at(0);
  EXPECT_EQ(change.find("slip-1 rejected, from "), 0U) << change;
  EXPECT_NE(done("data/fan/01 --import fan-01.csv --dry-run").find("fan/01: would be: " + change + "\n"), std::string::npos);
  EXPECT_EQ(text_of("fan/01/labels.json"), before);
  done("data/fan/01 --import fan-01.csv --who ada");
  EXPECT_EQ(labels().at("intervals").size(), 1U);
  EXPECT_NE(text_of("fan/01/labels.png"), picture);
  EXPECT_NE(done("data/fan/01 --history").find("ada  fan-01.csv imported: 0 confirmed, 0 moved, 0 added, 1 rejected"),
            std::string::npos);
  done("data/fan/01 --undo");
  EXPECT_EQ(labels().at("intervals"), json::parse(before).at("intervals"));
  EXPECT_EQ(text_of("fan/01/labels.png"), picture);
}

}  // namespace
}  // namespace tactile::cli
