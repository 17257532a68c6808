#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <thread>

#include "support/kill_moments.hpp"
#include "support/paths.hpp"
#include "support/running_command.hpp"
#include "support/settings_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/whole_runs.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;

/// Two objects of two simulated runs, two histories, an epoch, ten steps: smaller than tiny.
const std::string without_epochs =
    "reproduce --json --preset tiny --objects plastic-container,water-bottle --th 20,40 --held-out plastic-container --threads "
    "2 --steps 10 ";
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
  ADD_FAILURE() << "no step " << begin;
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

TEST(ReproduceCommand, FromNothingToAStudyWhoseStepsAreKeptTheNextTime) {
  const test::TemporaryFolder folder;
  const std::string as_before = "--models models";
  const nlohmann::json first = run_study(folder.path(), small + as_before);
  ASSERT_TRUE(first.is_object());
  EXPECT_EQ(first.at("steps_kept"), 0);
  EXPECT_NE(first.at("intervals").get<std::string>().find("Two trainings give no intervals"), std::string::npos);
  const fs::path file = folder / "study/study.json";
  const std::string text = read_text(file);
  const nlohmann::json study = read_json(file);
  const auto dry = test::run_tactile(small + as_before + " --dry-run", folder.path());
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  for (const auto& part : nlohmann::json::parse(dry.out).at("parts")) EXPECT_EQ(part.at("exist"), part.at("count")) << part;
  EXPECT_TRUE(study.at("simulated"));
  EXPECT_NE(study.at("title").get<std::string>().find("simulated"), std::string::npos);
  ASSERT_EQ(study.at("worlds").size(), 1U);
  EXPECT_EQ(study.at("worlds")[0].at("held_out"), std::vector<std::string>{"plastic-container"});
  EXPECT_TRUE(study.at("worlds")[0].at("left_out").is_array());
  std::map<std::string, std::set<std::string>> runs_of;  // that each setting's trainings learned from
  for (const auto& model : study.at("models")) runs_of[model.at("setting")].insert(model.at("train_run").get<std::string>());
  EXPECT_EQ(runs_of, (std::map<std::string, std::set<std::string>>{{"stream", {"01", "02"}},
                                                                   {"stream-unseen", {"01", "02"}},
                                                                   {"th020", {"01", "02"}},
                                                                   {"th040", {"01", "02"}},
                                                                   {"th040-unseen", {"01", "02"}}}));
  EXPECT_EQ(study.at("claims").size(), 14U);
  for (const auto& claim : study.at("claims")) EXPECT_EQ(claim.at("outcome"), "cannot tell") << "two replicates: " << claim;
  for (const auto& unseen : study.at("unseen")) {
    EXPECT_EQ(unseen.at("accuracy").at("runs"), (std::vector<std::string>{"plastic-container/01", "plastic-container/02"}))
        << "each training on the other run";
  }

  // Every file that it names is there, and its figures are those of the table of cells.
  const fs::path out = folder / "study";
  std::vector<std::string> named{study.at("cells")};
  for (const auto& run : study.at("full_runs")) named.push_back(run.at("csv"));
  for (const auto& model : study.at("models")) named.push_back(model.at("history"));
  for (const std::string& name : named) EXPECT_TRUE(fs::is_regular_file(out / name)) << name;
  const std::vector<results::Cell> cells = results::read_cells(out / "cells.csv");
  for (const auto& setting : study.at("results")) {
    std::vector<results::Cell> of_setting, sampled;
    for (const results::Cell& cell : cells) {
      if (cell.setting != setting.at("setting")) continue;
      of_setting.push_back(cell);
      if (evaluation::has_samples(cell)) sampled.push_back(cell);
    }
    EXPECT_EQ(setting.at("accuracy"), nlohmann::json(evaluation::accuracy_of(sampled)));
    const bool is_whole = setting.at("setting") != "th020";
    EXPECT_EQ(setting.at("whole_runs").at("runs").size(), !is_whole ? 0U : setting.at("is_unseen") ? 2U : 4U) << setting;
    if (!is_whole) continue;
    nlohmann::json whole = evaluation::whole_runs(of_setting, 1);
    whole["left_out"] = setting.at("whole_runs").at("left_out");
    EXPECT_EQ(setting.at("whole_runs"), whole) << setting.at("setting");
  }
  // The report is drawn again only for another study.
  const fs::path page = folder / first.at("report").get<std::string>();
  EXPECT_NE(read_text(page).find("<figure"), std::string::npos);
  const auto drawn_at = fs::last_write_time(page);

  // Without --models it finds them where they are.
  const nlohmann::json second = run_study(folder.path(), small);
  EXPECT_EQ(fs::last_write_time(page), drawn_at);
  EXPECT_EQ(second.at("steps_done"), 0);
  EXPECT_EQ(second.at("steps_kept"), study.at("steps").size());
  EXPECT_EQ(read_text(file), text);
  test::expect_settings_of("study/settings.json", "reproduce" + small.substr(std::string("reproduce --json").size()),
                           folder.path());
  const auto report = test::run_tactile("report --config study/report/settings.json --print-config", folder.path());
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_EQ(nlohmann::json::parse(report.out).at("what"), "study");
  EXPECT_EQ(nlohmann::json::parse(report.out).at("out"), "study/report");

  // The text ends with commands to run next.
  const std::string without_json = "reproduce" + small.substr(std::string("reproduce --json").size());
  const auto brief = test::run_tactile(without_json, folder.path());
  EXPECT_LE(std::count(brief.out.begin(), brief.out.end(), '\n'), 24) << brief.out;
  for (const char* line : {"\nLeNet, t_h 40 ms: ", "\nstream: ", "\n  tactile eval data --model ", "\n  tactile detect --model "})
    EXPECT_NE(brief.out.find(line), std::string::npos) << line << " in\n" << brief.out;
  const auto in_words = test::run_tactile(without_json + " --verbose", folder.path());
  EXPECT_EQ(in_words.exit_code, 0) << in_words.err;
  const std::string on_one_line = std::regex_replace(in_words.out, std::regex("\\s+"), " ");
  for (const char* words : {"side by side", "history-2-worst: Not measured in this study.", "Two trainings give no intervals"})
    EXPECT_NE(on_one_line.find(words), std::string::npos) << words << in_words.out;

  // Without gnuplot the study is printed and kept, and the error names gnuplot.
  fs::remove_all(folder / "study/report");
  const auto undrawn = test::run_shell(std::string("PATH=/nowhere '") + test::tactile_binary + "' " + small, folder.path());
  EXPECT_EQ(undrawn.exit_code, 1);
  EXPECT_NE(undrawn.err.find("gnuplot"), std::string::npos) << undrawn.err;
  const nlohmann::json printed = nlohmann::json::parse(undrawn.out);
  EXPECT_TRUE(printed.at("report").is_null());
  EXPECT_EQ(printed.at("claims"), study.at("claims"));
  EXPECT_EQ(read_text(file), text);
}

TEST(ReproduceCommand, DrawsWorldsOfTheirOwnAndTakesIntervalsOverThem) {
  const test::TemporaryFolder folder;
  const nlohmann::json study =
      run_study(folder.path(),
                "reproduce --json --preset tiny --objects plastic-container,white-box --th 40 --worlds 3 "
                "--trainings 1 --epochs 1 --steps 10 --seed 501 --threads 2 --no-report");
  ASSERT_TRUE(study.is_object());
  std::vector<std::string> names, held_out;
  for (const auto& world : study.at("worlds")) {
    names.push_back(world.at("name"));
    ASSERT_EQ(world.at("held_out").size(), 1U);
    held_out.push_back(world.at("held_out")[0]);
    EXPECT_TRUE(fs::is_regular_file(folder / ("data/world-" + names.back()) / "plastic-container/01/events.aedat4"));
  }
  EXPECT_EQ(names, (std::vector<std::string>{"501", "502", "503"}));
  EXPECT_EQ(held_out, (std::vector<std::string>{"plastic-container", "white-box", "plastic-container"}))
      << "those of the paper, and the others in every second world";
  const auto& stream = study.at("results")[1];
  EXPECT_EQ(stream.at("setting"), "stream");
  EXPECT_EQ(stream.at("whole_runs").at("units"), "worlds");
  const std::vector<std::string> judged = stream.at("whole_runs").at("runs");
  EXPECT_TRUE(judged.front().starts_with("501/plastic-container/")) << judged.front();
  EXPECT_TRUE(judged.back().starts_with("503/white-box/")) << judged.back();
  EXPECT_EQ(stream.at("baselines").size(), 3U);
  EXPECT_EQ(stream.at("accuracy").at("mean").at("n"), 3);
  EXPECT_EQ(study.at("claims")[4].at("replicates"), 3);
  EXPECT_NE(study.at("intervals").get<std::string>().find("Intervals are over worlds"), std::string::npos);
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
  EXPECT_EQ(read_text(broken / "study/cells.csv"), read_text(whole / "study/cells.csv"));
}

TEST(ReproduceCommand, AChangedSettingRedoesWhatDependsOnItAlone) {
  const test::TemporaryFolder folder;
  const nlohmann::json first = run_study(folder.path(), small);
  const nlohmann::json more = run_study(folder.path(), small + "--th 10,20,40");
  EXPECT_EQ(more.at("steps_done"), 5) << "heatmaps, two trainings and their judgements";
  EXPECT_EQ(finished_at(more, "windows"), finished_at(first, "windows"));
  EXPECT_EQ(finished_at(more, "train-th40"), finished_at(first, "train-th40"));

  const nlohmann::json longer = run_study(folder.path(), without_epochs + "--epochs 2");
  for (const char* kept : {"simulate", "label", "windows"})
    EXPECT_EQ(finished_at(longer, kept), finished_at(first, kept)) << kept;
  for (const char* redone : {"train-th40", "judge-th40", "run-th040"})
    EXPECT_NE(finished_at(longer, redone), finished_at(first, redone)) << redone;
  EXPECT_NE(longer.at("models")[0].at("name"), first.at("models")[0].at("name"));

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
  EXPECT_NE(relabelled.at("worlds")[0].at("manifest_hash"), first.at("worlds")[0].at("manifest_hash"));
  EXPECT_EQ(relabelled.at("models")[0].at("name"), first.at("models")[0].at("name"));
  EXPECT_EQ(finished_at(relabelled, "simulate"), finished_at(first, "simulate"));
  EXPECT_NE(finished_at(relabelled, "train-th40"), finished_at(first, "train-th40"));
}

TEST(ReproduceCommand, WarnsWhereItReplacesTheDatasetOfAnotherStudy) {
  const test::TemporaryFolder folder;
  const std::string one_history =
      "reproduce --preset tiny --objects plastic-container,water-bottle --epochs 1 --steps 10 --threads 2 --no-report --th ";
  const auto first = test::run_tactile(one_history + "40", folder.path());
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.err.find("is made again"), std::string::npos) << first.err;
  // All runs that are there are studied.
  const auto other = test::run_tactile(
      "reproduce --preset tiny --epochs 1 --steps 10 --threads 2 --no-report --th 60 --out other", folder.path());
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_NE(other.err.find("data/dataset.h5 was made with other settings and is made again with history 60 ms instead of 50 ms;"),
            std::string::npos)
      << other.err;
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
  refused("--worlds 2", "they are one world");
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
  const auto printed = test::run_tactile("reproduce --preset tiny --th 20,40 --worlds 3 --dry-run --json", folder.path());
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const nlohmann::json estimate = nlohmann::json::parse(printed.out);
  std::map<std::string, int> counts;
  for (const auto& part : estimate.at("parts")) {
    counts[part.at("what")] = part.at("count");
    EXPECT_EQ(part.at("exist"), 0) << part;
    EXPECT_GT(part.at("processor_s"), 0) << part;
  }
  EXPECT_EQ(counts, (std::map<std::string, int>{{"simulated runs", 60},
                                                {"labelled runs", 60},
                                                {"datasets", 3},
                                                {"histories of heatmaps", 6},
                                                {"trainings of LeNet", 3 * 2 * 3},
                                                {"trainings of streams", 3 * 2 * 2},
                                                {"judgements of samples", 3 * 2},
                                                {"judgements of whole runs", 3 * 2 * 4}}));
  EXPECT_GT(estimate.at("bytes"), 5e7);

  const auto on_cluster = test::run_tactile("reproduce --preset tiny --executor slurm --dry-run", folder.path());
  ASSERT_EQ(on_cluster.exit_code, 0) << on_cluster.err;
  EXPECT_NE(on_cluster.out.find("256 cores"), std::string::npos) << on_cluster.out;
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(ReproduceCommand, BadOptionsAreRefusedBeforeAnythingIsMade) {
  const test::TemporaryFolder folder;
  for (const char* arguments :
       {"reproduce --worlds 0", "reproduce --th 3", "reproduce --preset large", "reproduce --train-run 1"}) {
    const auto result = test::run_tactile(arguments, folder.path());
    EXPECT_NE(result.exit_code, 0) << arguments;
    EXPECT_FALSE(result.err.empty());
    EXPECT_FALSE(fs::exists(folder / "data")) << arguments;
  }
}

}  // namespace
}  // namespace tactile::study
