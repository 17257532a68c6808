#include "tactile/experiments/step_runner.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;

class Steps : public testing::Test {
 protected:
  StepRunner runner() const { return StepRunner({.folder = folder_.path(), .program = "/bin/sh", .threads = 2}); }

  /// Writes "made" to a file of its name, and counts how often.
  Step writing(const std::string& name, nlohmann::json inputs) {
    const fs::path file = folder_ / name;
    return {.name = name,
            .command = "tactile " + name,
            .inputs = std::move(inputs),
            .outputs = [file] { return fs::exists(file) ? nlohmann::json(read_text(file)) : nlohmann::json(); },
            .work =
                [this, file](const ProgressCallback&) {
                  ++worked_;
                  write_whole(file, "made");
                }};
  }

  /// The same by a process; also keeps what was known of the step.
  Step by_process(const std::string& name, nlohmann::json inputs) {
    Step step = writing(name, std::move(inputs));
    step.work = {};
    step.arguments = [this, file = (folder_ / name).string()](const StepStart& start) {
      starts_.push_back(start);
      return std::vector<std::string>{"-c", "printf made > '" + file + "'"};
    };
    return step;
  }

  test::TemporaryFolder folder_;
  int worked_ = 0;
  std::vector<StepStart> starts_;
};

TEST_F(Steps, AreDoneOnceWhileInputsAndOutputsStay) {
  for (int i = 0; i < 3; ++i) {
    StepRunner steps = runner();
    steps.run(writing("a", {{"x", 1}}));
    EXPECT_EQ(steps.done_now(), i == 0 ? 1U : 0U);
    ASSERT_EQ(steps.records().size(), 1U);
    EXPECT_EQ(steps.records()[0].command, "tactile a");
    EXPECT_FALSE(steps.records()[0].finished_at.empty());
  }
  EXPECT_EQ(worked_, 1);
}

TEST(KeyOf, IsTheHashThatVersion010Wrote) {
  const nlohmann::json inputs = {
      {"data", "../data"}, {"objects", {"fan", "white-box"}}, {"preset", "tiny"}, {"runs", nullptr}, {"seed", 1}};
  EXPECT_EQ(key_of({.name = "simulate", .command = "", .inputs = inputs, .outputs = {}}),
            "04928a2afbae8272e62af4f62d69a45a8e07977442a5f23991c5a2ad93ea0dd9");
}

TEST_F(Steps, AreDoneAgainForOtherInputsAndOtherOutputs) {
  runner().run(writing("a", {{"x", 1}}));
  runner().run(writing("a", {{"x", 2}}));
  EXPECT_EQ(worked_, 2);
  write_whole(folder_ / "a", "touched");
  runner().run(writing("a", {{"x", 2}}));
  EXPECT_EQ(worked_, 3);
  fs::remove(folder_ / "a");
  runner().run(writing("a", {{"x", 2}}));
  EXPECT_EQ(worked_, 4);
}

TEST_F(Steps, ThatFailNameTheirCommandAndAreDoneAgain) {
  Step step = writing("a", {});
  step.work = [](const ProgressCallback&) { throw Error("no room"); };
  EXPECT_EQ(test::error_of([&] { runner().run(step); }), "'tactile a' failed: no room");
  step.command = "";
  EXPECT_EQ(test::error_of([&] { runner().run(step); }), "'a' failed: no room");
  runner().run(writing("a", {}));
  EXPECT_EQ(worked_, 1);
}

TEST_F(Steps, WithoutOutputsAreAnError) {
  Step step = writing("a", {});
  step.work = [](const ProgressCallback&) {};
  EXPECT_NE(test::error_of([&] { runner().run(step); }).find("'tactile a' ended, but its outputs are missing"),
            std::string::npos);
}

TEST_F(Steps, ADamagedRecordIsNone) {
  runner().run(writing("a", {}));
  write_whole(folder_ / "steps/a.json", "{\"key\": 3");
  runner().run(writing("a", {}));
  EXPECT_EQ(worked_, 2);
}

TEST_F(Steps, ProcessesRunSideBySideAndAreRecordedInTheirOrder) {
  StepRunner steps = runner();
  steps.run_side_by_side({by_process("b", {}), by_process("a", {}), by_process("c", {})});
  ASSERT_EQ(steps.records().size(), 3U);
  EXPECT_EQ(steps.records()[0].name, "b");
  EXPECT_EQ(steps.records()[1].name, "a");
  EXPECT_EQ(steps.records()[2].name, "c");
  StepRunner again = runner();
  again.run_side_by_side({by_process("b", {}), by_process("a", {})});
  EXPECT_EQ(again.done_now(), 0U);
  EXPECT_EQ(starts_.size(), 3U);
}

TEST_F(Steps, OneAfterAnotherBeginsWhenThatOneIsDoneAndHasInputsOfIts) {
  Step first = by_process("a", {{"x", 1}});
  Step second = by_process("b", {{"y", 2}});
  second.after = "a";
  second.later_inputs = [file = folder_ / "a"] { return nlohmann::json{{"a", read_text(file)}}; };
  second.arguments = [this](const StepStart&) {
    return std::vector<std::string>{"-c", "cat '" + (folder_ / "a").string() + "' >'" + (folder_ / "b").string() + "'"};
  };
  const auto done_by = [&](const std::vector<Step>& all) {
    StepRunner steps = runner();
    steps.run_side_by_side(all);
    EXPECT_EQ(steps.records().size(), all.size());
    EXPECT_EQ(steps.records().back().name, "b");
    return steps.done_now();
  };
  EXPECT_EQ(done_by({first, second}), 2U);
  EXPECT_EQ(runner().inputs_of("b"), (nlohmann::json{{"a", "made"}, {"y", 2}}));
  EXPECT_EQ(done_by({first, second}), 0U);
  fs::remove(folder_ / "b");
  EXPECT_EQ(done_by({first, second}), 1U) << "the first is kept";
  first.inputs = {{"x", 2}};
  EXPECT_EQ(done_by({first, second}), 2U);

  Step third = by_process("c", {});
  third.after = "d";
  EXPECT_EQ(test::error_of([&] {
              runner().run_side_by_side({first, third});
            }),
            "'c' comes after 'd'; expected two processes, and the other one earlier");

  // The key is that of a step that knew all inputs at once.
  second.inputs = {{"a", "made"}, {"y", 2}};
  second.later_inputs = {};
  second.after = {};
  EXPECT_EQ(done_by({second}), 0U);
}

TEST_F(Steps, TheProgressCountsEachKind) {
  std::vector<std::string> progress;
  StepRunner steps({.folder = folder_.path(), .program = "/bin/sh", .threads = 1, .new_progress = [&] {
                      return [&](const Progress& now) {
                        if (progress.empty() || progress.back() != now.what) progress.push_back(now.what);
                      };
                    }});
  Step first = by_process("a", {}), second = by_process("b", {});
  first.kind = "training";
  second.kind = "judgement";
  second.after = "a";
  steps.run_side_by_side({first, second});
  ASSERT_GE(progress.size(), 2U);
  EXPECT_EQ(progress[0], "0 of 1 trainings, 0 of 1 judgements");
  EXPECT_EQ(progress[1], "1 of 1 trainings, 0 of 1 judgements");
}

TEST_F(Steps, AreReportedByTheirDescriptionAsEachBegins) {
  std::vector<std::string> reported;
  StepRunner steps({.folder = folder_ / "study",
                    .program = "/bin/sh",
                    .threads = 1,
                    .on_step = [&](const std::string& description, bool kept) {
                      reported.push_back(description + (kept ? " is kept" : ""));
                    }});
  Step first = by_process("a", {}), second = by_process("b", {});
  first.description = "training 1 of 2";
  second.description = "training 2 of 2";
  steps.run_side_by_side({first, second});
  steps.run(writing("c", {}));
  EXPECT_FALSE(steps.is_done(writing("d", {})));
  EXPECT_TRUE(steps.is_done(first));
  steps.run(first);
  EXPECT_EQ(reported, (std::vector<std::string>{"training 1 of 2", "training 2 of 2", "c", "training 1 of 2 is kept"}));
}

TEST_F(Steps, TheArgumentsDependOnWhatIsKnownOfTheStep) {
  runner().run(by_process("a", {{"x", 1}}));
  ASSERT_EQ(starts_.size(), 1U);
  EXPECT_FALSE(starts_[0].begun_with_other_inputs);
  EXPECT_FALSE(starts_[0].made_outputs);
  runner().run(by_process("a", {{"x", 2}}));
  EXPECT_TRUE(starts_[1].begun_with_other_inputs);
  EXPECT_TRUE(starts_[1].made_outputs);

  Step broken = by_process("b", {{"x", 1}});
  broken.arguments = [](const StepStart&) { return std::vector<std::string>{"-c", "exit 1"}; };
  EXPECT_THROW(runner().run(broken), Error);
  runner().run(by_process("b", {{"x", 1}}));
  EXPECT_FALSE(starts_[2].begun_with_other_inputs) << "what it left half-done is its own";
  EXPECT_FALSE(starts_[2].made_outputs);
  Step other = broken;
  other.name = "c";
  EXPECT_THROW(runner().run(other), Error);
  runner().run(by_process("c", {{"x", 2}}));
  EXPECT_TRUE(starts_[3].begun_with_other_inputs);
  EXPECT_FALSE(starts_[3].made_outputs);
}

TEST_F(Steps, ProcessesShareTheThreads) {
  runner().run(by_process("alone", {}));
  runner().run_side_by_side({by_process("a", {}), by_process("b", {})});
  StepRunner({.folder = folder_.path(), .program = "/bin/sh", .threads = 7})
      .run_side_by_side({by_process("c", {}), by_process("d", {})});
  runner().run_side_by_side({by_process("e", {}), by_process("f", {}), by_process("g", {})});
  std::vector<unsigned> threads;
  for (const StepStart& start : starts_) threads.push_back(start.threads);
  EXPECT_EQ(threads, (std::vector<unsigned>{2, 1, 1, 3, 3, 1, 1, 1}));
}

TEST_F(Steps, InputsAreRemembered) {
  EXPECT_TRUE(runner().inputs_of("a").is_null());
  runner().run(writing("a", {{"x", 1}}));
  EXPECT_EQ(runner().inputs_of("a").at("x"), 1);
}

}  // namespace
}  // namespace tactile::experiments
