#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <thread>

#include "experiments/step_inputs.hpp"
#include "support/kill_moments.hpp"
#include "support/paths.hpp"
#include "support/running_command.hpp"
#include "support/settings_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;

/// Two objects of two simulated runs, two histories, an epoch: smaller than tiny.
const std::string without_epochs =
    "reproduce --json --preset tiny --objects plastic-container,water-bottle --th 20,40 --held-out plastic-container --threads "
    "2 ";
const std::string small = without_epochs + "--epochs 1 ";

nlohmann::json run_study(const fs::path& folder, const std::string& arguments) {
  const auto result = test::run_tactile(arguments, folder);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out, nullptr, false);
}

/// A study without its times.
nlohmann::json without_times(nlohmann::json study) {
  for (auto& step : study.at("steps")) {
    step.erase("seconds");
    step.erase("finished_at");
  }
  return study;
}

std::string finished_at(const nlohmann::json& study, const std::string& begin) {
  for (const auto& step : study.at("steps")) {
    if (step.at("name").get<std::string>().starts_with(begin)) return step.at("finished_at").dump() + step.at("seconds").dump();
  }
  return "";
}

/// How many programs have this folder as their own.
std::size_t programs_in(const fs::path& folder) {
  std::size_t count = 0;
  for (const auto& process : fs::directory_iterator("/proc")) {
    std::error_code not_ours;
    const fs::path where = fs::read_symlink(process.path() / "cwd", not_ours);
    if (!not_ours && where == fs::canonical(folder)) ++count;
  }
  return count;
}

/// Null if the study has no such claim.
nlohmann::json claim_of(const nlohmann::json& study, const std::string& id) {
  for (const auto& claim : study.at("claims")) {
    if (claim.at("id") == id) return claim;
  }
  return nullptr;
}

TEST(ReproduceCommand, FromNothingToAStudyWhoseStepsAreKeptTheNextTime) {
  const test::TemporaryFolder folder;
  // Where version 0.1.0 kept its models: its steps have this folder among their inputs.
  const std::string as_before = "--splits 1 --models models";
  const nlohmann::json first = run_study(folder.path(), small + as_before);
  ASSERT_TRUE(first.is_object());
  EXPECT_EQ(first.at("steps_kept"), 0);
  EXPECT_NE(first.at("bootstrap").at("trainings").get<std::string>().find("Two trainings give no intervals"), std::string::npos);
  EXPECT_TRUE(first.at("left_out").is_array());
  const fs::path file = folder / "study/study.json";
  const std::string text = read_text(file);
  const nlohmann::json study = read_json(file);
  const auto dry = test::run_tactile(small + as_before + " --dry-run", folder.path());
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  for (const auto& part : nlohmann::json::parse(dry.out).at("parts")) {
    // The drawn split holds out the same object as the plan: it is trained once.
    const bool counts_it_twice =
        part.at("what") == "trainings without some objects" || part.at("what") == "judgements of samples";
    if (!counts_it_twice) {
      EXPECT_EQ(part.at("exist"), part.at("count")) << part;
    }
  }
  const auto with_more = test::run_tactile(without_epochs + as_before + " --epochs 7 --dry-run", folder.path());
  ASSERT_EQ(with_more.exit_code, 0) << with_more.err;
  for (const auto& part : nlohmann::json::parse(with_more.out).at("parts")) {
    const std::string what = part.at("what");
    if (what.find("training") != std::string::npos || what.find("judgement") != std::string::npos) {
      EXPECT_EQ(part.at("exist"), 0) << part;
    }
  }
  EXPECT_TRUE(study.at("simulated"));
  EXPECT_NE(study.at("title").get<std::string>().find("simulated"), std::string::npos);
  EXPECT_EQ(study.at("choice").at("th_ms"), 40);
  EXPECT_EQ(study.at("choice").at("chosen_on"), "default");
  EXPECT_TRUE(study.at("choice").at("best").at("choice").is_null());
  const std::vector<std::string> first_runs{"plastic-container/01", "water-bottle/01"};
  const std::vector<std::string> second_runs{"plastic-container/02", "water-bottle/02"};
  ASSERT_EQ(study.at("trainings").size(), 2U);
  EXPECT_EQ(study.at("trainings")[0].at("runs").at("train"), first_runs);
  EXPECT_EQ(study.at("trainings")[0].at("runs").at("reported"), second_runs);
  EXPECT_EQ(study.at("trainings")[1].at("runs").at("train"), second_runs);
  EXPECT_EQ(study.at("trainings")[1].at("runs").at("reported"), first_runs);
  EXPECT_NE(study.at("trainings")[0].at("seed"), study.at("trainings")[1].at("seed"));
  ASSERT_EQ(study.at("histories").size(), 2U);
  EXPECT_EQ(study.at("histories")[0].at("th_ms"), 20);
  EXPECT_EQ(study.at("claims").size(), 14U);
  for (const auto& claim : study.at("claims"))
    EXPECT_EQ(claim.at("verdict"), "cannot tell") << "two objects of a run each: " << claim.at("id");
  EXPECT_EQ(study.at("unseen").at("held_out"), (std::vector<std::vector<std::string>>{{"plastic-container"}}));
  EXPECT_EQ(study.at("unseen").at("reported").at("runs"),
            (std::vector<std::string>{"plastic-container/01", "plastic-container/02"}));
  ASSERT_EQ(study.at("splits").size(), 1U);
  EXPECT_EQ(study.at("training_spread").at("th_ms"), 40);
  for (const char* object : {"plastic-container", "water-bottle"})
    EXPECT_EQ(study.at("training_spread").at("objects").at(object).size(), 2U) << object;
  const auto& guards = study.at("evaluations")[0].at("accuracy_by_guard");
  EXPECT_EQ(guards[0].at("guard_ms"), 100);
  EXPECT_EQ(guards[1].at("guard_ms"), 0);

  // Every file that it names is there.
  const fs::path out = folder / "study";
  std::vector<std::string> named{study.at("dataset").at("file"), study.at("full_runs")[0].at("csv"),
                                 study.at("unseen").at("trainings")[0].at("history"),
                                 study.at("splits")[0].at("training").at("history")};
  for (const auto& history : study.at("histories")) {
    for (const char* key : {"history", "samples"}) named.push_back(history.at("models")[0].at(key));
  }
  for (const auto& evaluation : study.at("evaluations")) {
    for (const char* key : {"json", "csv"}) named.push_back(evaluation.at(key));
  }
  for (const char* table : {"accuracy.csv", "unseen.csv", "claims.csv"}) named.emplace_back(table);
  for (const std::string& name : named) EXPECT_TRUE(fs::is_regular_file(out / name)) << name;

  test::expect_inputs_of_first_version(out, "study");

  // Two computations of the same accuracy agree: from samples, and from every tick.
  const nlohmann::json evaluation = read_json(out / study.at("evaluations")[0].at("json").get<std::string>());
  EXPECT_EQ(evaluation.at("accuracy"), study.at("histories")[1].at("accuracy").at("reported"));

  // The report is drawn again only for another study.
  const fs::path page = folder / first.at("report").get<std::string>();
  EXPECT_NE(read_text(page).find("<figure"), std::string::npos);
  const auto drawn_at = fs::last_write_time(page);

  // Without --models it finds them where they are.
  const nlohmann::json second = run_study(folder.path(), small + "--splits 1");
  EXPECT_EQ(fs::last_write_time(page), drawn_at);
  EXPECT_EQ(second.at("steps_done"), 0);
  EXPECT_EQ(second.at("steps_kept"), study.at("steps").size());
  EXPECT_EQ(read_text(file), text);

  test::expect_settings_of("study/settings.json",
                           "reproduce" + (small + "--splits 1").substr(std::string("reproduce --json").size()), folder.path());

  const auto report = test::run_tactile("report --config study/report/settings.json --print-config", folder.path());
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_EQ(nlohmann::json::parse(report.out).at("what"), "study");
  EXPECT_EQ(nlohmann::json::parse(report.out).at("out"), "study/report");

  // The text ends with commands to run next.
  const std::string without_json = "reproduce" + (small + "--splits 1").substr(std::string("reproduce --json").size());
  const auto brief = test::run_tactile(without_json, folder.path());
  EXPECT_LE(std::count(brief.out.begin(), brief.out.end(), '\n'), 15) << brief.out;
  for (const char* line : {"\naccuracy ", "\nheld out ", "\nclaims ", "\n  tactile eval --model "})
    EXPECT_NE(brief.out.find(line), std::string::npos) << line << " in\n" << brief.out;
  const auto in_words = test::run_tactile(without_json + " --verbose", folder.path());
  EXPECT_EQ(in_words.exit_code, 0) << in_words.err;
  const std::string model = "models/" + study.at("choice").at("model").get<std::string>();
  EXPECT_NE(in_words.out.find("  tactile eval --model " + model + "\n"), std::string::npos) << in_words.out;
  EXPECT_NE(in_words.out.find("  tactile export --model " + model + " --onnx model.onnx\n"), std::string::npos) << in_words.out;
  const std::string on_one_line = std::regex_replace(in_words.out, std::regex("\\s+"), " ");
  for (const char* words : {"side by side", "history-2-worst: Not decided: not measured.",
                            "Not decided: too few trainings: 2, 5 needed.", "Two trainings give no intervals"})
    EXPECT_NE(on_one_line.find(words), std::string::npos) << words << in_words.out;

  // Without gnuplot the study is printed and kept, and the error names gnuplot.
  fs::remove_all(folder / "study/report");
  const auto undrawn =
      test::run_shell(std::string("PATH=/nowhere '") + test::tactile_binary + "' " + small + "--splits 1", folder.path());
  EXPECT_EQ(undrawn.exit_code, 1);
  EXPECT_NE(undrawn.err.find("gnuplot"), std::string::npos) << undrawn.err;
  const nlohmann::json printed = nlohmann::json::parse(undrawn.out);
  EXPECT_TRUE(printed.at("report").is_null());
  EXPECT_EQ(printed.at("claims"), study.at("claims"));
  EXPECT_EQ(read_text(file), text);
}

TEST(ReproduceCommand, KilledAgainAndAgainComesToTheSameStudy) {
  const test::TemporaryFolder whole, broken;
  const auto begun = std::chrono::steady_clock::now();
  run_study(whole.path(), small);
  test::KillMoments moments(std::chrono::steady_clock::now() - begun, 5);
  for (int kills = 0; kills < 4;) {
    {
      const test::RunningCommand study(small, broken.path());
      moments.sleep(0.05, 0.5);
    }
    if (!fs::exists(broken / "study/study.json")) {
      ++kills;
      continue;
    }
    // It ended before the kill: start again, for the kills are what is tested.
    ASSERT_EQ(without_times(read_json(broken / "study/study.json")), without_times(read_json(whole / "study/study.json")));
    for (const char* made : {"data", "models", "study"}) fs::remove_all(broken / made);
    kills = 0;
    moments.were_too_late();
  }
  run_study(broken.path(), small);
  EXPECT_EQ(without_times(read_json(broken / "study/study.json")), without_times(read_json(whole / "study/study.json")));
  for (const char* table : {"accuracy.csv", "unseen.csv", "claims.csv"})
    EXPECT_EQ(read_text(broken / "study" / table), read_text(whole / "study" / table)) << table;
}

TEST(ReproduceCommand, AChangedSettingRedoesWhatDependsOnItAlone) {
  const test::TemporaryFolder folder;
  const nlohmann::json first = run_study(folder.path(), small);
  const nlohmann::json more = run_study(folder.path(), small + "--th 10,20,40");
  EXPECT_GE(more.at("steps_done"), 5) << "heatmaps, two trainings and their samples";
  EXPECT_LE(more.at("steps_done"), 6) << "and an evaluation, if it is the best";
  EXPECT_EQ(finished_at(more, "windows"), finished_at(first, "windows"));
  EXPECT_EQ(finished_at(more, "train-th040"), finished_at(first, "train-th040"));

  const nlohmann::json longer = run_study(folder.path(), without_epochs + "--epochs 2");
  for (const char* kept : {"simulate", "label", "windows"})
    EXPECT_EQ(finished_at(longer, kept), finished_at(first, kept)) << kept;
  for (const char* redone : {"train-th040", "judge-th040", "evaluate-", "run-"})
    EXPECT_NE(finished_at(longer, redone), finished_at(first, redone)) << redone;
  EXPECT_NE(longer.at("histories")[0].at("models")[0].at("name"), first.at("histories")[0].at("models")[0].at("name"));

  // A confirmed label changes nothing that is learned.
  const fs::path labels = folder / "data/plastic-container/02/labels.json";
  nlohmann::json edited = read_json(labels);
  for (auto& interval : edited.at("intervals")) interval["confirmed"] = true;
  write_json(labels, edited);
  const nlohmann::json confirmed = run_study(folder.path(), without_epochs + "--epochs 2");
  EXPECT_EQ(confirmed.at("steps_done"), 0);
  EXPECT_EQ(finished_at(confirmed, "windows"), finished_at(first, "windows"));

  // A moved onset: another dataset, and models of the same names, which are replaced.
  auto& onset = edited.at("intervals")[0].at("start_us");
  onset = onset.get<std::int64_t>() + 500;
  write_json(labels, edited);
  const nlohmann::json relabelled = run_study(folder.path(), small);
  EXPECT_NE(relabelled.at("dataset").at("manifest_hash"), first.at("dataset").at("manifest_hash"));
  EXPECT_EQ(relabelled.at("histories")[0].at("models")[0].at("name"), first.at("histories")[0].at("models")[0].at("name"));
  EXPECT_EQ(finished_at(relabelled, "simulate"), finished_at(first, "simulate"));
  EXPECT_NE(finished_at(relabelled, "train-th040"), finished_at(first, "train-th040"));
}

TEST(ReproduceCommand, WarnsWhereItReplacesTheDatasetOfAnotherStudy) {
  const test::TemporaryFolder folder;
  const std::string one_history =
      "reproduce --preset tiny --objects plastic-container,water-bottle --epochs 1 --threads 2 --no-report --th ";
  const auto first = test::run_tactile(one_history + "40", folder.path());
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.err.find("is made again"), std::string::npos) << first.err;
  // All runs that are there are studied.
  const auto other =
      test::run_tactile("reproduce --preset tiny --epochs 1 --threads 2 --no-report --th 60 --out other", folder.path());
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_NE(other.err.find("data/dataset.h5 was made with other settings and is made again with history 60 ms instead of 50 ms;"),
            std::string::npos)
      << other.err;
}

TEST(ReproduceCommand, HeldOutEachHoldsOutOneObjectAtATime) {
  const test::TemporaryFolder folder;
  run_study(folder.path(),
            "reproduce --json --preset tiny --objects plastic-container,water-bottle --th 40 --held-out each --trainings 1 "
            "--epochs 1 --threads 2 --no-report");
  const nlohmann::json unseen = read_json(folder / "study/study.json").at("unseen");
  EXPECT_EQ(unseen.at("held_out"), (std::vector<std::vector<std::string>>{{"plastic-container"}, {"water-bottle"}}));
  ASSERT_EQ(unseen.at("trainings").size(), 2U);
  EXPECT_EQ(unseen.at("reported").at("runs"), (std::vector<std::string>{"plastic-container/02", "water-bottle/02"}));
  for (const auto& [without, other] :
       {std::pair("plastic-container", "water-bottle"), std::pair("water-bottle", "plastic-container")}) {
    const auto& training = unseen.at("trainings")[without == std::string("plastic-container") ? 0 : 1];
    const nlohmann::json model = read_json(folder / "study" / training.at("folder").get<std::string>() / "model.json");
    EXPECT_EQ(model.at("train_runs"), std::vector<std::string>{std::string(other) + "/01"}) << without;
    EXPECT_TRUE(unseen.at("reported").at("objects").contains(without));
  }
}

TEST(ReproduceCommand, ContradictoryOptionsAreRefused) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(test::run_tactile("simulate --preset tiny --objects plastic-container,water-bottle --quiet", folder.path()).exit_code,
            0);
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    const auto result = test::run_tactile("reproduce --preset tiny --th 40 --epochs 1 " + arguments, folder.path());
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(folder / "study/study.json"));
  };
  refused("--objects plastic-container", "holds runs already");
  refused("--runs 3", "holds runs already");
  refused("--held-out cup", "'cup'");
  refused("--held-out plastic-container,water-bottle", "nothing is left to learn from");
}

TEST(ReproduceCommand, CtrlCEndsItWith130AndItsTrainingsToo) {
  const test::TemporaryFolder folder;
  const std::string arguments = without_epochs + "--epochs 1000";
  test::RunningCommand study(arguments, folder.path());
  while (programs_in(folder.path()) < 3 && !study.has_ended()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  study.signal(SIGINT);  // to it alone, as `kill` would
  EXPECT_EQ(study.wait().exit_code, 130) << study.err();
  EXPECT_EQ(programs_in(folder.path()), 0U);
  EXPECT_FALSE(fs::exists(folder / "study/study.json"));
}

TEST(ReproduceCommand, AFailingTrainingIsReportedWithItsCommand) {
  const test::TemporaryFolder folder;
  write_whole(folder / "models", "no folder");
  const auto result = test::run_tactile(small + "--models models", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("tactile: 'tactile train data --th "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("' failed: "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("models"), std::string::npos) << result.err;
}

TEST(ReproduceCommand, ChoosesOnRunsThatItDoesNotReportOn) {
  const test::TemporaryFolder folder;
  const nlohmann::json study =
      run_study(folder.path(),
                "reproduce --json --preset quick --objects plastic-container,sprayer,water-bottle --th 2,20 --held-out "
                "plastic-container --epochs 1 --trainings 2 --threads 2");
  ASSERT_TRUE(study.is_object());
  EXPECT_EQ(study.at("choice").at("chosen_on"), "choice");
  const auto& runs = study.at("trainings")[0].at("runs");
  EXPECT_EQ(runs.at("choice"), (std::vector<std::string>{"plastic-container/02", "sprayer/02", "water-bottle/02"}));
  EXPECT_EQ(runs.at("reported"), (std::vector<std::string>{"plastic-container/03", "sprayer/03", "water-bottle/03"}));
  EXPECT_EQ(runs.at("all_test").size(), 6U);
  EXPECT_EQ(study.at("choice").at("th_ms"), study.at("choice").at("best").at("choice").at("th_ms"));
  EXPECT_EQ(study.at("paper_way").at("th_ms"), study.at("choice").at("best").at("all_test").at("th_ms"));
  ASSERT_EQ(study.at("histories")[0].at("models").size(), 2U);
  EXPECT_NE(study.at("histories")[0].at("models")[0].at("weights_sha256"),
            study.at("histories")[0].at("models")[1].at("weights_sha256"));
  std::set<std::string> evaluations;
  for (const auto& evaluation : study.at("evaluations")) evaluations.insert(evaluation.at("id").get<std::string>());
  EXPECT_EQ(evaluations, (std::set<std::string>{"reported", "all_test"}));
  // Each training is judged with the history that its own choice runs chose.
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_EQ(study.at("evaluations")[0].at("models")[k].at("th_ms"), study.at("choice").at("trainings")[k]);
  EXPECT_TRUE(claim_of(study, "marginal-past-20").at("measured").at("value").is_null()) << "no history past 20 ms was asked for";
  const nlohmann::json right_at_first = claim_of(study, "right-at-first");
  EXPECT_TRUE(right_at_first.at("measured").at("low").is_null()) << "two trainings";
  EXPECT_EQ(right_at_first.at("measured").at("trainings"), 2);
  EXPECT_EQ(right_at_first.at("why"), "too few trainings: 2, 5 needed");
  EXPECT_EQ(study.at("unseen").at("trainings").size(), 2U);
}

TEST(ReproduceCommand, TwoStudiesDoNotShareAFolder) {
  const test::TemporaryFolder folder;
  test::RunningCommand study(small, folder.path());
  while (!fs::exists(folder / "study/steps/simulate.json") && !study.has_ended())
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  study.signal(SIGSTOP);  // else it might come to its end first
  const auto second = test::run_tactile(small, folder.path());
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_NE(second.err.find("another 'tactile reproduce' is writing to this folder"), std::string::npos) << second.err;
}

TEST(ReproduceCommand, ADryRunPrintsWhatTheStudyWouldDoAndDoesNothing) {
  const test::TemporaryFolder folder;
  const auto printed = test::run_tactile("reproduce --preset tiny --th 20,40 --splits 3 --dry-run --json", folder.path());
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const nlohmann::json estimate = nlohmann::json::parse(printed.out);
  std::map<std::string, int> counts;
  for (const auto& part : estimate.at("parts")) {
    counts[part.at("what")] = part.at("count");
    EXPECT_EQ(part.at("exist"), 0) << part;
    EXPECT_GT(part.at("processor_s"), 0) << part;
  }
  EXPECT_EQ(counts, (std::map<std::string, int>{{"simulated runs", 20},
                                                {"labelled runs", 20},
                                                {"dataset", 1},
                                                {"histories of heatmaps", 2},
                                                {"trainings", 4},
                                                {"trainings without some objects", 2 + 3},
                                                {"judgements of samples", 4 + 2 + 3},
                                                {"evaluations of all ticks", 2}}));
  EXPECT_GT(estimate.at("bytes"), 5e7);

  const auto on_cluster = test::run_tactile("reproduce --preset tiny --executor slurm --dry-run", folder.path());
  ASSERT_EQ(on_cluster.exit_code, 0) << on_cluster.err;
  EXPECT_NE(on_cluster.out.find("256 cores"), std::string::npos) << on_cluster.out;
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(ReproduceCommand, BadOptionsAreRefusedBeforeAnythingIsMade) {
  const test::TemporaryFolder folder;
  for (const char* arguments :
       {"reproduce --splits some", "reproduce --th 3", "reproduce --preset large", "reproduce --train-run 1"}) {
    const auto result = test::run_tactile(arguments, folder.path());
    EXPECT_NE(result.exit_code, 0) << arguments;
    EXPECT_FALSE(result.err.empty());
    EXPECT_FALSE(fs::exists(folder / "data")) << arguments;
  }
}

}  // namespace
}  // namespace tactile::study
