#include "tactile/experiments/slurm.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "experiments/slurm_cluster.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/experiments/slurm_commands.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/results/cell.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;

/// As long as it exists, programs are searched in these folders: "/a:/b".
class ProgramFolders {
 public:
  explicit ProgramFolders(const std::string& folders) { ::setenv("PATH", folders.c_str(), 1); }
  ~ProgramFolders() { ::setenv("PATH", before().c_str(), 1); }
  ProgramFolders(const ProgramFolders&) = delete;
  ProgramFolders& operator=(const ProgramFolders&) = delete;

  /// Those of the tests.
  static const std::string& before() {
    static const std::string folders = test::run_shell("printf %s \"$PATH\"").out;
    return folders;
  }
};

TEST(Slurm, IsNamedWithOrWithoutAPartition) {
  EXPECT_EQ(slurm_named("slurm").partition, "");
  EXPECT_EQ(slurm_named("slurm:gpu").partition, "gpu");
  for (const char* name : {"slurm:", "Slurm", "lsf"})
    EXPECT_EQ(test::error_of([&] { slurm_named(name); }),
              "'" + std::string(name) + "' is unknown; expected local, slurm or slurm:PARTITION");
}

TEST(Slurm, WordsForSbatchAreSplitAsByAShell) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(sbatch_words(" --time=1:00:00  --mem=4G "), (Words{"--time=1:00:00", "--mem=4G"}));
  EXPECT_EQ(sbatch_words("--comment=\"press study\" --constraint='a|b' ''"),
            (Words{"--comment=press study", "--constraint=a|b", ""}));
  EXPECT_EQ(test::error_of([] { sbatch_words("short"); }),
            "--sbatch: 'short' is no option; expected options of sbatch, such as --partition=short");
  for (const std::string word : {"--array", "--wrap", "--quiet", "-W", "-M", "-a0-1", "--outp", "--cluster"})
    EXPECT_EQ(test::error_of([&] { sbatch_words("--mem=4G " + word + "=1"); }),
              "--sbatch: '" + word + "' is set by tactile; expected other options of sbatch");
  EXPECT_EQ(sbatch_words(""), Words{});
  EXPECT_EQ(test::error_of([] { sbatch_words("--comment=\"press"); }),
            "--sbatch '--comment=\"press': a quote has no end; expected words as in a shell");
}

TEST(Slurm, ThatIsNotInstalledIsNamed) {
  const test::TemporaryFolder folder;
  ASSERT_NE(ProgramFolders::before(), "");
  const ProgramFolders none(folder.path().string());
  const std::string error = test::error_of([&] {
    run_on_slurm({{"one", {}, folder / "one.log", "key"}}, ProcessesOptions{}, folder / "slurm", {});
  });
  EXPECT_EQ(error, "scontrol: there is no such program; expected Slurm's commands on this machine, or --executor local");
}

TEST(Slurm, AccountingIsAskedOnceForAllTasks) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "sacct") << "#!/bin/sh\n"
                                     "echo \"$@\" >>'"
                                  << folder.path().string()
                                  << "/calls'\n"
                                     "echo '12_3|NODE_FAIL'\n"
                                     "echo '12_4|CANCELLED by 1000'\n";
  fs::permissions(folder / "sacct", fs::perms::owner_all);
  const ProgramFolders with_sacct(folder.path().string() + ":" + ProgramFolders::before());
  const std::map<std::string, std::string> states = accounted_states({"12_3", "12_4", "12_5"});
  EXPECT_EQ(states, (std::map<std::string, std::string>{{"12_3", "NODE_FAIL"}, {"12_4", "CANCELLED"}}));
  EXPECT_EQ(test::text_in_file(folder / "calls"),
            "--noheader --allocations --parsable2 --format=JobID,State --jobs=12_3,12_4,12_5\n");
}

struct Interrupted {};

/// On a cluster of its own. The machine may be unable to start one: then the message says so.
class SlurmJobs : public testing::Test {
 protected:
  void SetUp() override {
    static std::string lacks = test::SlurmCluster::what_lacks();
    if (lacks.empty()) {
      cluster_.emplace();
      if (!cluster_->is_up()) lacks = cluster_->why_it_is_down();
    }
    if (!lacks.empty()) GTEST_SKIP() << "no cluster can start here, so jobs on it were not tested: " << lacks;
    how_.program = "/bin/sh";
    how_.begun = [this](std::size_t index) { begun_.push_back(index); };
    how_.ended = [this](std::size_t index, double) { ended_.push_back(index); };
    slurm_.poll = std::chrono::milliseconds(200);
  }

  /// A task that writes a line to NAME.txt, after further commands.
  ProcessPlan task(const std::string& name, const std::string& commands = "true") const {
    return {name,
            {"-c", commands + " && echo done >>" + file(name + ".txt")},
            folder_ / "logs" / (name + ".log"),
            "key-of-" + name.substr(name.find(' ') + 1)};
  }
  /// A training, and its judgement, which fails if the training has not ended.
  std::vector<ProcessPlan> judged_training(const std::string& name, const std::string& commands = "true") const {
    std::vector<ProcessPlan> plans{task("train-" + name, commands),
                                   task("judge-" + name, "[ -e " + file("train-" + name + ".txt") + " ]")};
    plans[1].after = 0;
    return plans;
  }
  void run(const std::vector<ProcessPlan>& plans) { run_on_slurm(plans, how_, folder_ / "slurm", slurm_); }

  void run_command(const std::string& command) const {
    const auto result = test::run_tactile(command, folder_.path());
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.err;
  }

  /// Commands of a task: until there is a file of this name; which node it is on.
  std::string waits_for(const std::string& name) const { return "while [ ! -e " + file(name) + " ]; do sleep 0.1; done"; }
  std::string name_node() const { return "printf %s $SLURMD_NODENAME >" + file("node") + "; "; }
  std::string node() const { return text("node"); }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string text(const std::string& name) const { return test::text_in_file(folder_ / name); }
  static std::string queue() {
    const auto answer = test::run_shell("squeue --noheader --array --format='%i %T'");
    return answer.exit_code == 0 ? answer.out : "no answer";
  }

  test::TemporaryFolder folder_;
  std::optional<test::SlurmCluster> cluster_;
  ProcessesOptions how_;
  SlurmOptions slurm_;
  std::vector<std::size_t> begun_, ended_;
};

TEST_F(SlurmJobs, EachRunOnceInArraysOfTheLargestSizeAndAreReported) {
  std::vector<ProcessPlan> plans;
  plans.reserve(7);
  for (int i = 0; i < 7; ++i) plans.push_back(task("task " + std::to_string(i)));  // MaxArraySize is 4
  for (ProcessPlan& plan : plans) plan.arguments[1] = "true && echo done >>'" + file(plan.name + ".txt") + "'";
  run(plans);
  for (const ProcessPlan& plan : plans) EXPECT_EQ(text(plan.name + ".txt"), "done\n");
  EXPECT_EQ(std::set(ended_.begin(), ended_.end()).size(), 7U);
  EXPECT_EQ(std::set(begun_.begin(), begun_.end()).size(), 7U);
  EXPECT_TRUE(fs::is_empty(folder_ / "slurm/ended"));
  EXPECT_TRUE(read_json(folder_ / "slurm/jobs.json").empty());
}

TEST_F(SlurmJobs, ThatFailNameTheirLastMessageAndEndTheOthers) {
  const std::string error = test::error_of([&] {
    run({task("good", "sleep 1000"), task("bad", name_node() + "echo tactile: no light >&2; exit 3")});
  });
  EXPECT_EQ(error, "'bad' failed on node " + node() + ": no light");
  EXPECT_TRUE(test::comes_true([] { return queue().empty(); }));
  EXPECT_EQ(text("good.txt"), "");

  // Once the cause is removed, the same work is done, although its tasks were cancelled or failed.
  std::vector<ProcessPlan> mended{task("good"), task("bad")};
  run(mended);
  EXPECT_EQ(text("good.txt") + text("bad.txt"), "done\ndone\n");
}

TEST_F(SlurmJobs, ThatEndedWellBeforeAnotherFailedAreKept) {
  const std::vector<ProcessPlan> plans{task("bad", name_node() + waits_for("go") + "; exit 3"), task("good")};
  how_.while_waiting = [&] {
    if (!begun_.empty()) throw Interrupted();
  };
  EXPECT_THROW(run(plans), Interrupted);
  std::ofstream(file("go")) << "now";
  EXPECT_TRUE(test::comes_true([] { return queue().empty(); }));
  how_.while_waiting = {};
  EXPECT_EQ(test::error_of([&] { run(plans); }), "'bad' failed on node " + node() + ": it ended with 3 and no message");
  EXPECT_EQ(ended_, (std::vector<std::size_t>{1}));
}

TEST_F(SlurmJobs, ThatAreRefusedBecauseThereAreManyAreSubmittedInParts) {
  // Takes at most two tasks at a time, as where a site limits them.
  std::ofstream(file("sbatch"))
      << "#!/bin/sh\n"
         "for word; do case $word in --array=0-*) more=${word#--array=0-} ;; esac; done\n"
         "there=$(squeue --noheader --array --states=PENDING,RUNNING | wc -l)\n"
         "[ $((there + more + 1)) -le 2 ] || { echo 'Job violates accounting/QOS policy' >&2; exit 1; }\n"
         "exec /usr/bin/sbatch \"$@\"\n";
  fs::permissions(file("sbatch"), fs::perms::owner_all);
  const ProgramFolders with_sbatch(folder_.path().string() + ":" + ProgramFolders::before());
  std::vector<ProcessPlan> plans;
  for (const char* name : {"a", "b", "c", "d", "e"}) plans.push_back(task(name, "sleep 1"));
  run(plans);
  for (const ProcessPlan& plan : plans) EXPECT_EQ(text(plan.name + ".txt"), "done\n");
  EXPECT_NE(text("slurm/slurm.log").find("sbatch refused the jobs: Job violates accounting/QOS policy"), std::string::npos);
}

TEST_F(SlurmJobs, OfAnEarlierCallAreStillKnownAfterAnotherCall) {
  // The short one waits, too: if it ended during the first call, that call would report it, and another would run it again.
  const std::vector<ProcessPlan> plans{task("short", waits_for("go-short")), task("long", waits_for("go-long"))};
  how_.while_waiting = [&] {
    if (begun_.size() == 2) throw Interrupted();
  };
  EXPECT_THROW(run(plans), Interrupted);
  how_.while_waiting = {};
  std::ofstream(file("go-short")) << "now";
  run({plans[0]});
  std::ofstream(file("go-long")) << "now";
  run({plans[1]});
  EXPECT_EQ(text("short.txt") + text("long.txt"), "done\ndone\n");
}

TEST_F(SlurmJobs, AreLeftWhenTheWaitingIsInterruptedAndCollectedLater) {
  const std::vector<ProcessPlan> plans{task("short"), task("long", waits_for("go"))};
  how_.while_waiting = [&] {
    if (ended_.size() == 1 && begun_.size() == 2) throw Interrupted();
  };
  EXPECT_THROW(run(plans), Interrupted);
  const std::string id = read_json(folder_ / "slurm/jobs.json").at("long").at("task");
  EXPECT_NE(queue().find(id + " RUNNING"), std::string::npos);

  std::ofstream(file("go")) << "now";
  EXPECT_TRUE(test::comes_true([] { return queue().empty(); }));  // it ends while nobody waits
  how_.while_waiting = {};
  run({plans[1]});
  EXPECT_EQ(ended_, (std::vector<std::size_t>{0, 0}));
  EXPECT_EQ(text("long.txt"), "done\n");
}

TEST_F(SlurmJobs, AreCancelledWhereAPersonWantsIt) {
  slurm_.cancel = [] { return true; };
  how_.while_waiting = [&] {
    if (!begun_.empty()) throw Interrupted();
  };
  EXPECT_THROW(run({task("long", "sleep 1000")}), Interrupted);
  EXPECT_TRUE(test::comes_true([] { return queue().empty(); }));
}

TEST_F(SlurmJobs, OfOtherWorkOfTheSameNameAreNotTakenForIt) {
  run({task("one")});
  ProcessPlan other = task("one");
  other.key = "another";
  run({other});
  EXPECT_EQ(text("one.txt"), "done\ndone\n");
}

TEST_F(SlurmJobs, AreRefusedWithTheWordsOfSbatch) {
  check_slurm(slurm_, folder_ / "slurm");
  slurm_.partition = "none";
  EXPECT_NE(test::error_of([&] { check_slurm(slurm_, folder_ / "slurm"); }).find("artition"), std::string::npos);
  const std::string error = test::error_of([&] { run({task("one")}); });
  EXPECT_NE(error.find("sbatch refused the jobs: "), std::string::npos) << error;
  EXPECT_NE(error.find("artition"), std::string::npos) << error;
}

TEST_F(SlurmJobs, AreRefusedBeforeTheWorkUnlessNodesMayComeBack) {
  const auto check = [&] { check_slurm(slurm_, folder_ / "slurm"); };
  std::string warning;
  slurm_.warn = [&](const std::string& sentence) { warning = sentence; };
  EXPECT_EQ(test::run_shell("scontrol update PartitionName=short State=DRAIN").exit_code, 0);
  EXPECT_NE(test::error_of(check).find("partition not available"), std::string::npos);
  EXPECT_EQ(test::run_shell("scontrol update PartitionName=short State=UP").exit_code, 0);
  EXPECT_EQ(test::run_shell("scontrol update NodeName=node1,node2 State=DRAIN Reason=repair").exit_code, 0);
  EXPECT_EQ(warning, "");
  check();
  EXPECT_NE(warning.find("node configuration is not available"), std::string::npos) << warning;
}

TEST_F(SlurmJobs, OfWhichSbatchPrintsNoNumberAreNotSubmittedAgain) {
  std::ofstream(file("sbatch")) << "#!/bin/sh\necho submitted >>" << file("calls") << "\n";
  fs::permissions(file("sbatch"), fs::perms::owner_all);
  const ProgramFolders with_sbatch(folder_.path().string() + ":" + ProgramFolders::before());
  EXPECT_EQ(test::error_of([&] {
              run({task("one"), task("two")});
            }),
            "sbatch took the jobs and printed ''; expected their number (scancel --name=tactile cancels them)");
  EXPECT_EQ(text("calls"), "submitted\n");
}

TEST_F(SlurmJobs, ThatWereSubmittedWithoutAnAnswerAreFound) {
  std::ofstream(file("sbatch")) << "#!/bin/sh\n/usr/bin/sbatch \"$@\" && echo 'Socket timed out' >&2 && exit 1\n";
  fs::permissions(file("sbatch"), fs::perms::owner_all);
  const ProgramFolders with_sbatch(folder_.path().string() + ":" + ProgramFolders::before());
  const std::vector<ProcessPlan> plans{task("one", waits_for("go")), task("two", waits_for("go"))};
  how_.while_waiting = [&] {
    if (!begun_.empty()) throw Interrupted();
  };
  EXPECT_THROW(run(plans), Interrupted);
  fs::remove(folder_ / "slurm/jobs.json");  // as where the command was killed before it could note them
  how_.while_waiting = [&] { std::ofstream(file("go")) << "now"; };
  run(plans);
  EXPECT_EQ(text("one.txt") + text("two.txt"), "done\ndone\n");
}

TEST_F(SlurmJobs, WaitWhileAPartitionIsClosed) {
  const auto set_partition = [](const std::string& state) {
    EXPECT_EQ(test::run_shell("scontrol update PartitionName=short State=" + state).exit_code, 0);
  };
  set_partition("DOWN");
  std::vector<std::string> queue;
  how_.queue = [&](const std::string& text) {
    if (queue.empty() || queue.back() != text) queue.push_back(text);
    if (text == "2 wait (PartitionDown)") set_partition("UP");
  };
  how_.while_waiting = [&] {
    if (!queue.empty() && queue.back() == "2 run") std::ofstream(file("go")) << "now";
  };
  run({task("one", waits_for("go")), task("two", waits_for("go"))});
  EXPECT_NE(std::find(queue.begin(), queue.end(), "2 wait (PartitionDown)"), queue.end())
      << fmt::format("{}", fmt::join(queue, "; "));
}

TEST_F(SlurmJobs, OfAnEarlierCallAreCollectedWhileTheClusterTakesNoOthers) {
  const fs::path jobs = folder_ / "slurm";
  std::string warning;
  how_.while_waiting = [&] {
    if (!begun_.empty()) throw Interrupted();
  };
  EXPECT_THROW(run({task("one", waits_for("go"))}), Interrupted);
  slurm_.partition = "none";
  slurm_.warn = [&](const std::string& sentence) { warning = sentence; };
  check_slurm(slurm_, jobs);
  EXPECT_NE(warning.find("artition"), std::string::npos) << warning;
  how_.while_waiting = {};
  std::ofstream(file("go")) << "now";
  run({task("one", waits_for("go"))});
  EXPECT_EQ(text("one.txt"), "done\n");
  EXPECT_NE(test::error_of([&] { check_slurm(slurm_, jobs); }).find("artition"), std::string::npos);
}

TEST_F(SlurmJobs, OfOtherWorkHaveEndedBeforeAStepLooksAtWhatTheyLeft) {
  bool interrupts = true;
  const auto run_step = [&](int input, const std::function<std::vector<std::string>(const StepStart&)>& arguments) {
    StepRunner runner({.folder = folder_.path(),
                       .program = "/bin/sh",
                       .threads = 2,
                       .new_progress =
                           [&] {
                             return [&](const Progress&) {
                               if (interrupts && fs::exists(file("runs"))) throw Interrupted();
                             };
                           },
                       .slurm = slurm_});
    runner.run({.name = "work",
                .command = "",
                .inputs = {{"x", input}},
                .outputs = [] { return nlohmann::json("made"); },
                .arguments = arguments});
  };
  const std::string earlier = "trap ': >" + file("ended") + "; exit 1' TERM; : >" + file("runs") + "; " + waits_for("go");
  EXPECT_THROW(run_step(1, [&](const StepStart&) { return std::vector<std::string>{"-c", earlier}; }), Interrupted);
  EXPECT_NE(queue().find("RUNNING"), std::string::npos);
  interrupts = false;
  run_step(2, [&](const StepStart& start) {
    EXPECT_TRUE(fs::exists(file("ended")));
    EXPECT_TRUE(start.begun_with_other_inputs);
    return std::vector<std::string>{"-c", "true"};
  });
}

TEST_F(SlurmJobs, OfAStepMayShowTheirFilesLate) {
  StepRunner runner({.folder = folder_.path(), .program = "/bin/sh", .threads = 2, .slurm = slurm_});
  int looks = 0;
  runner.run({.name = "late",
              .command = "",
              .inputs = {},
              .outputs = [&] { return ++looks < 4 ? nlohmann::json() : nlohmann::json("made"); },
              .arguments =
                  [](const StepStart&) {
                    return std::vector<std::string>{"-c", "true"};
                  }});
  EXPECT_EQ(runner.done_now(), 1U);
}

TEST_F(SlurmJobs, OfANodeThatFailsResumeOnAnotherAndGiveTheSameModel) {
  for (const char* command : {"simulate --preset tiny --objects plastic-container,water-bottle", "label --no-pictures", "windows",
                              "train --epochs 20 --threads 1 --name whole"})
    run_command(command);
  const auto model_file = [this](const std::string& name) { return folder_ / "models" / name; };
  std::vector<ProcessPlan> plans{
      {.name = "training",
       .arguments = {"train", file("data"), "--epochs", "20", "--threads", "1", "--models", file("models"), "--name", "killed",
                     "--resume"},
       .log = folder_ / "logs/training.log",
       .key = "training"},
      {.name = "judgement",
       .arguments = {"judge", file("data/dataset.h5"), "--model", model_file("killed").string(), "--out", file("judged.csv"),
                     "--threads", "1", "--runs", "water-bottle/02", "plastic-container/02"},
       .log = folder_ / "logs/judgement.log",
       .key = "judgement",
       .after = 0}};
  how_.program = test::tactile_binary;
  bool killed = false;
  how_.while_waiting = [&] {
    const std::string epochs = test::text_in_file(model_file("killed.training") / "history.csv");
    if (killed || std::count(epochs.begin(), epochs.end(), '\n') < 5) return;
    cluster_->kill_busy_node();
    killed = true;
  };
  run(plans);
  EXPECT_TRUE(killed);
  EXPECT_NE(text("logs/training.log").find("resuming killed in epoch "), std::string::npos) << text("logs/training.log");
  const std::string whole = test::text_in_file(model_file("whole/weights.safetensors"));
  EXPECT_FALSE(whole.empty());
  EXPECT_TRUE(whole == test::text_in_file(model_file("killed/weights.safetensors")));
  EXPECT_EQ(results::read_cells(folder_ / "judged.csv").size(), 2U);
}

TEST_F(SlurmJobs, ThatASignalEndsRunAgain) {
  run({task("one", "[ -e " + file("second") + " ] || { : >" + file("second") + "; kill -9 $$; }")});
  EXPECT_EQ(text("one.txt"), "done\n");

  slurm_.attempts = 2;
  const std::string error = test::error_of([&] { run({task("two", "echo begun >>" + file("begun.txt") + "; kill -9 $$")}); });
  EXPECT_EQ(error,
            "'two' failed: it was started 2 times, and signal 9 ended it the last time; if memory was short, expected --sbatch "
            "with more, such as \"--mem=4G\" (its log: " +
                file("logs/two.log") + ")");
  EXPECT_EQ(text("begun.txt"), "begun\nbegun\n");
}

TEST_F(SlurmJobs, AfterOthersBeginWhereNobodyWaits) {
  constexpr std::size_t trainings = 5;  // in two arrays
  std::vector<ProcessPlan> plans, judgements;
  for (std::size_t i = 0; i < trainings; ++i) {
    std::vector<ProcessPlan> two = judged_training(std::to_string(i), waits_for("go"));
    two[1].after = i;
    plans.push_back(two[0]);
    judgements.push_back(two[1]);
  }
  plans.insert(plans.end(), judgements.begin(), judgements.end());
  how_.while_waiting = [&] {
    if (!begun_.empty()) throw Interrupted();
  };
  EXPECT_THROW(run(plans), Interrupted);
  std::ofstream(file("go")) << "now";
  EXPECT_TRUE(test::comes_true([] { return queue().empty(); }));
  for (const ProcessPlan& judgement : judgements) EXPECT_EQ(text(judgement.name + ".txt"), "done\n");

  how_.while_waiting = {};
  run(plans);
  EXPECT_EQ(ended_.size(), plans.size());
  for (const ProcessPlan& plan : plans) EXPECT_EQ(text(plan.name + ".txt"), "done\n") << "it ran once";
}

TEST_F(SlurmJobs, AfterOthersAreReplacedWithThemWhereTheyAreOtherWork) {
  std::vector<ProcessPlan> plans = judged_training("a", "echo begun >>" + file("begun.txt") + "; " + waits_for("go"));
  how_.while_waiting = [&] {
    if (!text("begun.txt").empty()) throw Interrupted();
  };
  EXPECT_THROW(run(plans), Interrupted);
  const std::string before = read_json(folder_ / "slurm/jobs.json").at("train-a").at("task");
  how_.while_waiting = [&] {
    if (queue().find(before + " ") == std::string::npos) std::ofstream(file("go")) << "now";
  };
  plans[1].key = "judged-otherwise";
  run(plans);
  EXPECT_EQ(text("begun.txt"), "begun\nbegun\n") << "the earlier task is cancelled";
  EXPECT_EQ(text("train-a.txt") + text("judge-a.txt"), "done\ndone\n");
}

TEST_F(SlurmJobs, AfterOneThatHasEndedAloneRunAgainWhereSlurmStartsTheirTaskAgain) {
  std::vector<ProcessPlan> plans = judged_training("a");
  plans[1].arguments[1] =
      "[ -e " + file("second") + " ] || { : >" + file("first") + "; exec sleep 1000; }; echo done >>" + file("judge-a.txt");
  bool requeued = false;
  how_.while_waiting = [&] {
    if (requeued || !fs::exists(file("first")) || ended_.empty()) return;
    std::ofstream(file("second")) << "now";
    const std::string task = read_json(folder_ / "slurm/jobs.json").at("judge-a").at("task");
    EXPECT_EQ(test::run_shell("scontrol requeue " + task).exit_code, 0);
    requeued = true;
  };
  run(plans);
  EXPECT_TRUE(requeued);
  EXPECT_EQ(text("train-a.txt") + text("judge-a.txt"), "done\ndone\n");
  EXPECT_TRUE(fs::is_empty(folder_ / "slurm/ended"));
}

TEST_F(SlurmJobs, AfterOneThatASignalEndsBeginWhenItHasRunAgain) {
  run(judged_training("a", "[ -e " + file("second") + " ] || { : >" + file("second") + "; kill -9 $$; }"));
  EXPECT_EQ(text("train-a.txt") + text("judge-a.txt"), "done\ndone\n");
}

TEST_F(SlurmJobs, AfterOneThatFailsNeverBegin) {
  const std::string error =
      test::error_of([&] { run(judged_training("a", name_node() + "echo tactile: no light >&2; exit 3")); });
  EXPECT_EQ(error, "'train-a' failed on node " + node() + ": no light");
  EXPECT_TRUE(test::comes_true([] { return queue().empty(); }));
  EXPECT_FALSE(fs::exists(file("judge-a.txt")));
  run(judged_training("a"));
  EXPECT_EQ(text("train-a.txt") + text("judge-a.txt"), "done\ndone\n");
}

TEST_F(SlurmJobs, OfAStudyGiveTheSameStudyAsOneMachine) {
  const std::string study =
      "reproduce --preset tiny --objects plastic-container,water-bottle --th 20,40 --held-out plastic-container --epochs 1 "
      "--steps 10 --threads 2 --no-report";
  for (const std::string where : {"local", "slurm:short"}) {
    fs::create_directory(folder_ / where);
    const auto result = test::run_tactile(fmt::format("{} --executor {}", study, where), folder_ / where);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  std::map<std::string, nlohmann::json> studies;
  for (const std::string where : {"local", "slurm:short"}) {
    nlohmann::json& made = studies[where] = read_json(folder_ / where / "study/study.json");
    for (auto& step : made.at("steps")) {
      step.erase("seconds");
      step.erase("finished_at");
    }
  }
  EXPECT_EQ(studies.at("slurm:short"), studies.at("local"));
  EXPECT_TRUE(read_json(folder_ / "slurm:short/study/slurm/jobs.json").empty());
  EXPECT_FALSE(fs::exists(folder_ / "local/study/slurm"));
}

TEST_F(SlurmJobs, AreLeftOrCancelledByTheAnswerAfterCtrlC) {
  const std::string study =
      "reproduce --preset tiny --objects plastic-container --th 40 --epochs 100000 --steps 1000000 --trainings 1 --no-report "
      "--executor slurm";
  // In a terminal, a person interrupts the command when it waits for a training that runs, and then answers.
  const auto answered = [&](const std::string& answer) {
    const std::string shown = file("terminal-" + answer);
    const std::string wait =
        "waits() { i=0; until \"$@\" >/dev/null 2>&1; do sleep 0.1; i=$((i + 1)); [ $i -lt 1200 ] || return; done; }; ";
    test::run_shell(wait + "{ waits sh -c 'squeue --noheader --states=RUNNING | grep tactile'; waits grep 'of 2 trainings' " +
                        shown + "; printf '\\003'; waits grep 'y/N' " + shown + "; printf '" + answer +
                        "\\n'; } | script -qefc \"" + test::tactile_binary + " " + study + "\" " + shown,
                    folder_.path());
    return test::text_in_file(shown);
  };
  const std::string left = answered("n");
  EXPECT_NE(left.find("Cancel the jobs on the cluster? Otherwise they continue, and the same command collects them later. [y/N]"),
            std::string::npos)
      << left;
  EXPECT_NE(left.find("the jobs on the cluster continue"), std::string::npos) << left;
  const std::string running = queue();
  EXPECT_NE(running.find("RUNNING"), std::string::npos);

  const std::string cancelled = answered("y");
  EXPECT_EQ(cancelled.find("the jobs on the cluster continue"), std::string::npos) << cancelled;
  EXPECT_TRUE(test::comes_true([] { return queue().empty(); }));
  EXPECT_TRUE(read_json(folder_ / "study/slurm/jobs.json").empty());
  // The second call waited for the jobs of the first: Slurm gave no number after those of the two tasks.
  const std::string job = running.substr(0, running.find('_'));
  EXPECT_NE(test::run_shell("scontrol show job " + std::to_string(std::stoi(job) + 2)).exit_code, 0);
}

TEST_F(SlurmJobs, OfATradeTrainTheSameModelsAsOneMachine) {
  run_command("simulate --preset tiny --runs 3 --objects plastic-container,water-bottle");
  run_command("label --no-pictures");
  run_command("windows");
  const std::string trade =
      "trade --th 20,40 --tick-us 2000 --factor 0.2 --resize area --denoise mean --augment none --engine fast --precision fp32 "
      "--kind lenet --epochs 1 --trainings 1 --timed-ticks 600 --no-figures --threads 2 ";
  for (const std::string where : {"local", "slurm:short"})
    run_command(fmt::format("{}--out {} --executor {}", trade, where, where));
  const auto weights = [this](const std::string& where) {
    std::map<std::string, std::string> all;
    for (const auto& model : fs::directory_iterator(folder_ / where / "models"))
      if (model.is_directory()) all[model.path().filename()] = test::text_in_file(model.path() / "weights.safetensors");
    return all;
  };
  EXPECT_EQ(weights("local").size(), 2U);
  EXPECT_TRUE(weights("slurm:short") == weights("local"));
  EXPECT_TRUE(read_json(folder_ / "slurm:short/slurm/jobs.json").empty());
  const auto accuracies = [this](const std::string& where) {
    std::vector<nlohmann::json> all;
    for (const auto& point : read_json(folder_ / where / "trade.json").at("points"))
      all.push_back(point.at("reported").at("accuracy"));
    return all;
  };
  EXPECT_EQ(accuracies("slurm:short"), accuracies("local"));
}

TEST_F(SlurmJobs, OfAStressGiveTheSameFiguresAsOneMachine) {
  for (const char* command : {"simulate --preset tiny --objects plastic-container,water-bottle", "label --no-pictures", "windows",
                              "train --epochs 1", "train --epochs 1 --lr 0.002 --name other"})
    run_command(command);
  // A recipe with its own seed, a simulated world and a quiet recording.
  const std::string stress =
      "stress --recipe noise:50 --world light-dim:90 --quiet-recording data/water-bottle/01/events.aedat4 --seed 7 --no-figures "
      "--model th40-single-1-epochs1 --model other ";
  std::map<std::string, nlohmann::json> stressed;
  for (const std::string where : {"local", "slurm:short"}) {
    run_command(fmt::format("{}--out {} --executor {}", stress, where, where));
    stressed[where] = read_json(folder_ / where / "stress.json").at("models");
    EXPECT_EQ(stressed[where][0].at("curves").size(), 2U);
  }
  EXPECT_EQ(stressed.at("slurm:short"), stressed.at("local"));
  EXPECT_TRUE(read_json(folder_ / "slurm:short/slurm/jobs.json").empty());
  EXPECT_FALSE(fs::exists(folder_ / "local/slurm"));
}

}  // namespace
}  // namespace tactile::experiments
