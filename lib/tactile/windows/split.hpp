#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactile::windows {

enum class SplitKind : std::uint8_t { single_run, unseen };

inline constexpr std::array<std::string_view, 2> split_names{"single-run", "unseen"};
std::string_view name_of(SplitKind kind);      ///< "single-run", "unseen"
SplitKind split_named(std::string_view name);  ///< @throws Error

/// The five objects that the paper holds out in its unseen test.
const std::vector<std::string>& default_held_out();

struct SplitOptions {
  SplitKind kind = SplitKind::single_run;
  std::string train_run = "01";
  std::vector<std::string> held_out = default_held_out();  ///< objects; for `unseen` only
};

/// A split by run, never by sample: neighbouring samples share nearly all of their events.
struct Split {
  std::vector<std::uint32_t> train_runs;  ///< indexes of the given runs
  std::vector<std::uint32_t> test_runs;
};

struct RunName {
  std::string object;
  std::string run;
  bool has_samples = true;
};

/// single-run: trains on run `train_run` of every object, and tests on its other runs. unseen: trains on run `train_run` of the
/// objects that are not held out, and tests on all runs of the held-out ones.
/// If an object's `train_run` is missing or has no samples, its next run with samples is used; after the last run comes the
/// first. An object without such a run is not used, unless it is held out.
/// @throws Error  if a held-out object does not exist, or no run remains for training or testing
Split split_runs(std::span<const RunName> runs, const SplitOptions& options);

}  // namespace tactile::windows
