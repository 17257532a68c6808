#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactile {

enum class SplitKind : std::uint8_t { single_run, unseen };

std::string_view name_of(SplitKind kind);      ///< "single-run", "unseen"
SplitKind split_named(std::string_view name);  ///< @throws Error

/// The paper's five objects that its unseen test never trains on.
const std::vector<std::string>& default_held_out();

struct SplitOptions {
  SplitKind kind = SplitKind::single_run;
  std::string train_run = "01";
  std::vector<std::string> held_out = default_held_out();  ///< objects; of `unseen` only
};

/// Runs by object and id, never samples: neighbours share nearly all of their events.
struct Split {
  std::vector<std::uint32_t> train_runs;  ///< indexes into the runs given
  std::vector<std::uint32_t> test_runs;
};

struct RunName {
  std::string object;
  std::string run;
  bool has_samples = true;
};

/// single-run: trains on run `train_run` of every object, tests on every other run of it. unseen: trains on it for the objects
/// not held out, tests on every run of those held out.
/// Where an object's `train_run` is missing or has no samples, the next of its runs that has some takes its place, after the last
/// the first. An object without any such run is neither trained nor tested on, unless it is held out.
/// @throws Error  if a held-out object does not exist, or nothing is left to train or test on
Split split_runs(std::span<const RunName> runs, const SplitOptions& options);

}  // namespace tactile
