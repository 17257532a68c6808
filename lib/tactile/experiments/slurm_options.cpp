#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/experiments/slurm.hpp"

namespace tactile::experiments {
namespace {

/// Refuses options that `run_on_slurm` sets itself, and options that hide jobs from it.
void check(const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 14> ours{"--array", "-a",          "--wrap",     "--parsable", "--output",
                                                  "-o",      "--open-mode", "--quiet",    "-Q",         "--wait",
                                                  "-W",      "-M",          "--clusters", "--test-only"};
  if (!words.empty() && !words.front().starts_with('-'))
    throw Error(fmt::format("--sbatch: '{}' is no option; expected options of sbatch, such as --partition={}", words.front(),
                            words.front()));
  for (const std::string& word : words) {
    const std::string_view name = std::string_view(word).substr(0, word.find('='));
    const bool is_long = name.starts_with("--") && name.size() > 2, is_short = !is_long && name.starts_with('-');
    const auto is_ours = [&](std::string_view option) {
      // sbatch takes the beginning of a long name, and a short one with its value: --arr=0-1, -a0-1.
      return (is_long && option.starts_with(name)) || (is_short && !option.starts_with("--") && name.starts_with(option));
    };
    if (std::any_of(ours.begin(), ours.end(), is_ours))
      throw Error(fmt::format("--sbatch: '{}' is set by tactile; expected other options of sbatch", name));
  }
}

}  // namespace

SlurmOptions slurm_named(const std::string& name) {
  const std::string begin = "slurm";
  SlurmOptions options;
  if (name == begin) return options;
  if (name.starts_with(begin + ":") && name.size() > begin.size() + 1) {
    options.partition = name.substr(begin.size() + 1);
    return options;
  }
  throw Error(fmt::format("'{}' is unknown; expected local, slurm or slurm:PARTITION", name));
}

std::vector<std::string> sbatch_words(const std::string& text) {
  std::vector<std::string> words;
  bool in_word = false;
  char quote = 0;
  for (const char letter : text) {
    if (quote == 0 && (letter == ' ' || letter == '\t' || letter == '\n')) {
      in_word = false;
      continue;
    }
    if (!std::exchange(in_word, true)) words.emplace_back();
    if (letter == quote) {
      quote = 0;
    } else if (quote == 0 && (letter == '\'' || letter == '"')) {
      quote = letter;
    } else {
      words.back() += letter;
    }
  }
  if (quote != 0) throw Error(fmt::format("--sbatch '{}': a quote has no end; expected words as in a shell", text));
  check(words);
  return words;
}

std::vector<std::string> words_of(const SlurmOptions& slurm) {
  std::vector<std::string> words{"--job-name=tactile", "--requeue", "--ntasks=1", "--cpus-per-task=1", "--open-mode=append"};
  if (!slurm.partition.empty()) words.push_back("--partition=" + slurm.partition);
  words.insert(words.end(), slurm.sbatch.begin(), slurm.sbatch.end());
  return words;
}

}  // namespace tactile::experiments
