#include "completed_value.hpp"

#include "help_text.hpp"

namespace tactile::cli {
namespace {

bool takes_many(const CLI::Option& option) { return option.get_expected_max() == CLI::detail::expected_max_vector_size; }

}  // namespace

std::string function_of(Completion what) {
  switch (what) {
    case Completion::recordings:
      return "_tactile_recordings";
    case Completion::run_folders:
      return "_tactile_run_folders";
    case Completion::runs:
      return "_tactile_runs";
    case Completion::models:
      return "_tactile_models";
    case Completion::sources:
      return "_tactile_sources";
    default:
      return "";
  }
}

std::vector<std::string> words_of(CLI::Option& option) {
  std::vector<std::string> words;
  for (int i = 0;; ++i) {
    std::string names;
    try {
      names = option.get_validator(i)->get_name();
    } catch (const CLI::OptionNotFound&) {  // CLI11 has no count of them
      return words;
    }
    for (std::size_t begin = 0; begin < names.size();) {
      const std::size_t end = std::min(names.find('|', begin), names.size());
      words.push_back(names.substr(begin, end - begin));
      begin = end + 1;
    }
  }
}

CompletedValue completed_value(CLI::Option& option) {
  const std::string value = value_text(option).name, name = option.get_positional() ? "" : option.get_name();
  if (value.empty()) return {};
  const bool is_list = option.get_delimiter() == ',' || value.ends_with(",...");
  if (const std::vector<std::string> words = words_of(option); !words.empty())
    return {is_list ? Completion::list : Completion::words, words};
  if (name == "--model" || value == "MODEL") return {Completion::models};
  if (value == "SOURCE") return {Completion::sources};
  if (value == "FILE|RUN" || value == "IN" || value == "RECORDING") return {Completion::recordings};
  if (value.starts_with("RUN")) return {Completion::runs};
  if (value == "DATA|RUN" || (value == "DATA" && takes_many(option))) return {Completion::run_folders};
  if (value == "DIR" || value == "DATA" || value.starts_with("STUDY|")) return {Completion::folders};
  if (value.starts_with("FILE.") && value.find('|') == std::string::npos)
    return {Completion::files, {}, value.substr(std::string("FILE.").size())};
  if (value.find("FILE") != std::string::npos || value == "OUT" || value == "PATH") return {Completion::files};
  return {};
}

}  // namespace tactile::cli
