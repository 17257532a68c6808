#include "tactile/windows/split.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "tactile/core/enum_names.hpp"
#include "tactile/core/error.hpp"

namespace tactile::windows {
namespace {

using RunIndexes = std::vector<std::uint32_t>;

/// The run for training: the wanted one, otherwise the next with samples, cyclically; nothing if none has samples.
std::optional<std::uint32_t> training_run(std::span<const RunName> runs, const RunIndexes& of_object, const std::string& wanted) {
  std::map<std::string, std::uint32_t> whole;
  for (const std::uint32_t index : of_object) {
    if (runs[index].has_samples) whole.emplace(runs[index].run, index);
  }
  if (whole.empty()) return std::nullopt;
  const auto next = whole.lower_bound(wanted);
  return next == whole.end() ? whole.begin()->second : next->second;
}

std::string names_of(const std::map<std::string, RunIndexes>& by_object) {
  std::string names;
  for (const auto& [object, runs] : by_object) names += (names.empty() ? "" : ", ") + object;
  return names;
}

}  // namespace

std::string_view name_of(SplitKind kind) { return split_names.at(static_cast<std::size_t>(kind)); }
SplitKind split_named(std::string_view name) { return enumerator_named<SplitKind>(name, split_names, "split"); }

const std::vector<std::string>& default_held_out() {
  static const std::vector<std::string> objects{"textured-box", "plastic-container", "fan", "small-box", "sprayer"};
  return objects;
}

Split split_runs(std::span<const RunName> runs, const SplitOptions& options) {
  std::map<std::string, RunIndexes> by_object;
  for (std::uint32_t index = 0; index < runs.size(); ++index) by_object[runs[index].object].push_back(index);
  const bool unseen = options.kind == SplitKind::unseen;
  if (unseen) {
    for (const std::string& object : options.held_out) {
      if (!by_object.contains(object))
        throw Error("held-out object '" + object +
                    "': no run of it; expected one of the dataset's objects: " + names_of(by_object));
    }
  }
  Split split;
  for (const auto& [object, of_object] : by_object) {
    if (unseen && std::find(options.held_out.begin(), options.held_out.end(), object) != options.held_out.end()) {
      split.test_runs.insert(split.test_runs.end(), of_object.begin(), of_object.end());
      continue;
    }
    const std::optional<std::uint32_t> trained_on = training_run(runs, of_object, options.train_run);
    if (!trained_on) continue;
    split.train_runs.push_back(*trained_on);
    if (unseen) continue;
    std::copy_if(of_object.begin(), of_object.end(), std::back_inserter(split.test_runs),
                 [&](std::uint32_t index) { return index != *trained_on; });
  }
  const std::string which = "split " + std::string(name_of(options.kind)) + " with --train-run " + options.train_run;
  if (split.train_runs.empty())
    throw Error(which + ": no run with samples is left to train on; expected one of at least one object that is not held out");
  const auto has_samples = [&](std::uint32_t index) { return runs[index].has_samples; };
  if (std::none_of(split.test_runs.begin(), split.test_runs.end(), has_samples)) {
    throw Error(which + ": no run with samples is left to test on; expected at least " +
                (unseen ? "one of a held-out object" : "two of an object"));
  }
  std::sort(split.train_runs.begin(), split.train_runs.end());
  std::sort(split.test_runs.begin(), split.test_runs.end());
  return split;
}

}  // namespace tactile::windows
