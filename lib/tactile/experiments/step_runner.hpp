#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/experiments/slurm.hpp"
#include "tactile/results/step_record.hpp"

namespace tactile::experiments {

/// What a step must know when it begins.
struct StepStart {
  bool begun_with_other_inputs = false;  ///< what it left half-done cannot be used
  bool made_outputs = false;             ///< it made the outputs that exist: they may be replaced
  unsigned threads = 1;                  ///< that its process may use: its share of those of this machine
};

/// A piece of work that is done once, and again only if its inputs change or its outputs are missing or changed.
struct Step {
  std::string name;        ///< also a file's name: "train-th40-single-1"
  std::string command;     ///< what a person types to do the same; empty if there is no such command
  nlohmann::json inputs;   ///< settings and hashes of what goes in. The step's key is the hash of this and its name
  std::string after = {};  ///< name of an earlier step of the same call, which must be done first: if it is due, so is this one
  std::function<nlohmann::json()> later_inputs = {};  ///< more `inputs`, which are known when the step `after` is done
  std::function<nlohmann::json()> outputs;            ///< identifies the outputs that exist; null if they are not complete

  std::function<void(const ProgressCallback&)> work = {};  ///< runs in this process; empty if `arguments` are given
  std::function<std::vector<std::string>(const StepStart&)> arguments = {};  ///< of a process that does the work
  /// On a cluster: of a process that does `work` there. Empty: this process always does it.
  std::function<std::vector<std::string>()> on_cluster = {};
  std::string description = {};  ///< reported while it runs: "training 3 of 11: t_h 20 ms"; the name if empty
  std::string kind = "step";     ///< of a process, as its progress counts it: "training"
};

/// Returns the callback for one step's progress; may be empty.
using NewProgress = std::function<ProgressCallback()>;

/// Called for each step when it begins (`kept` is false) or is found done (`kept` is true). May be empty.
using StepCallback = std::function<void(const std::string& description, bool kept)>;

struct StepRunnerOptions {
  std::filesystem::path folder;   ///< of the experiment
  std::filesystem::path program;  ///< takes the `arguments` of steps
  unsigned threads = 1;           ///< shared by the processes that run side by side, of which there are at most as many; > 0
  NewProgress new_progress = {};
  StepCallback on_step = {};
  std::optional<SlurmOptions> slurm = {};  ///< the processes run on a cluster, in `folder/slurm`; nothing: on this machine
};

/// Runs steps and keeps a record of each in `folder/steps`. A step whose key and outputs equal its record is not done again. An
/// interrupted step starts again, or resumes by its own means.
class StepRunner {
 public:
  /// @throws Error  if there is no cluster, or it does not take the options of `slurm`
  explicit StepRunner(StepRunnerOptions options);

  /// @throws Error  that names the step's command, or the step, and what went wrong
  void run(const Step& step);

  /// Runs steps that depend on each other only by `Step::after`. Those with `arguments` run side by side, in one process each; on
  /// a cluster also those with `on_cluster`. Only such steps may have an `after`.
  void run_side_by_side(const std::vector<Step>& steps);

  /// Steps that were run or found done, in order.
  const std::vector<results::StepRecord>& records() const { return records_; }
  std::size_t done_now() const { return done_now_; }
  std::size_t kept() const { return records_.size() - done_now_; }

  /// Whether the step would be found done.
  bool is_done(const Step& step) const;

  /// The inputs of the last step of this name that began; null if none did.
  nlohmann::json inputs_of(const std::string& name) const;

 private:
  struct Known;
  struct DueStep;
  std::filesystem::path file_of(const std::string& name) const;
  Known read(const std::string& name) const;
  void write(const Step& step, const Known& known) const;
  std::optional<Known> known_as_done(const Step& step) const;
  bool find_done(const Step& step);
  void begin(const Step& step) const;
  std::filesystem::path slurm_folder() const { return options_.folder / "slurm"; }
  void report(const Step& step, bool kept) const;
  void finish(const Step& step, double seconds);
  bool is_a_process(const Step& step) const { return step.arguments || (options_.slurm && step.on_cluster); }
  ProcessPlan plan_of(const DueStep& due) const;
  void wait_for_files_of(const Step& step, const std::function<void()>& while_waiting);
  std::vector<std::string> arguments_of(const DueStep& due, unsigned threads) const;
  void run_processes_of(const std::vector<DueStep>& due);

  StepRunnerOptions options_;
  std::vector<results::StepRecord> records_;
  std::size_t done_now_ = 0;
  bool files_may_be_late_ = true;  ///< until those of a step did not come
};

/// What the folder `experiment` keeps of its steps whose names begin so; without records that cannot be read: their steps are
/// done again.
std::vector<nlohmann::json> step_records(const std::filesystem::path& experiment, std::string_view begin);

/// Identifies a step of this name with these inputs, which must all be known. Later versions have the same keys until a step does
/// something else.
std::string key_of(const Step& step);

}  // namespace tactile::experiments
