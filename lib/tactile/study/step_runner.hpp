#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"

namespace tactile {

/// What is known of a step that is not done.
struct StepPast {
  bool begun_otherwise = false;  ///< it was begun, with another key: what that left half-done is of no use
  bool made_outputs = false;     ///< what lies there, it made: it may be replaced
};

/// What a study's runner is to do once, and again only when what it comes from has changed.
struct Step {
  std::string name;       ///< a file's name too: "train-th040-single-run-01-s1"
  std::string command;    ///< that does the same, as one would type it; empty where there is none
  nlohmann::json inputs;  ///< settings, and hashes of what goes in: the step's key is the hash of this, its name and the version
  std::function<nlohmann::json()> outputs;  ///< what tells the outputs that lie there from others, null where they are not whole

  std::function<void(const ProgressCallback&)> work = {};  ///< done in this process; empty where `arguments` are given
  std::function<std::vector<std::string>(const StepPast&)> arguments = {};  ///< of a process that does it
  std::string words = {};  ///< what is told of it while it is done: "training 3 of 11: t_h 20 ms"; where empty, its name
};

/// What is kept of a step that was done.
struct StepRecord {
  std::string name;
  std::string command;
  double seconds = 0;       ///< that it took, whenever it was done
  std::string finished_at;  ///< UTC
};

/// Gives what is told of one step's progress; may be empty.
using NewProgress = std::function<ProgressCallback()>;

struct StepRunnerOptions {
  std::filesystem::path folder;   ///< the study's
  std::filesystem::path program;  ///< that `arguments` are of
  unsigned threads = 1;           ///< how many processes run side by side, > 0
  NewProgress new_progress = {};
  std::function<void(const std::string& words, bool kept)> tell = {};  ///< told of each step as it begins, or is found done
};

/// Runs steps and remembers them in `folder/steps`. A step whose key and outputs are those remembered is not done again; one that
/// was broken off is begun anew, or gone on with by its own means.
class StepRunner {
 public:
  explicit StepRunner(StepRunnerOptions options);

  /// @throws Error  that names the step's command, or the step, and what went wrong
  void run(const Step& step);

  /// Steps that need nothing of each other: those done by processes run side by side, one thread each.
  void run_side_by_side(const std::vector<Step>& steps);

  /// Those run or found done, in order.
  const std::vector<StepRecord>& records() const { return records_; }
  std::size_t done_now() const { return done_now_; }

  /// Whether it would be found done.
  bool is_done(const Step& step) const;

  /// Whether a step of this name was ever begun, with whatever inputs.
  bool knows(const std::string& name) const;

  /// The inputs that it was begun with last; null where it never was.
  nlohmann::json inputs_of(const std::string& name) const;

 private:
  struct Known;
  std::filesystem::path file_of(const std::string& name) const;
  Known read(const std::string& name) const;
  std::optional<Known> known_as_done(const Step& step) const;
  bool find_done(const Step& step);
  void begin(const Step& step);
  void tell_of(const Step& step, bool kept) const;
  void finish(const Step& step, double seconds);

  StepRunnerOptions options_;
  std::vector<StepRecord> records_;
  std::size_t done_now_ = 0;
};

/// What a step of this name and these inputs is known by.
std::string key_of(const Step& step);

/// UTC now, "2024-05-31T12:00:00Z".
std::string utc_now();

}  // namespace tactile
