#include <fmt/format.h>

#include "completed_value.hpp"
#include "completion_scripts.hpp"
#include "help_text.hpp"

namespace tactile::cli {
namespace {

constexpr std::string_view zsh_functions = R"sh(
_tactile_recordings() {
  local -a runs=(data/*/[0-9][0-9]/events.aedat4(N:h))
  _alternative 'runs:run:compadd -a runs' 'files:file:_files'
}

_tactile_run_folders() {
  local -a runs=(data/*/[0-9][0-9]/events.aedat4(N:h))
  _alternative 'runs:run:compadd -a runs' 'folders:folder:_files -/'
}

# The names of the runs in the folder that the line names, else in data/.
_tactile_runs() {
  local folder=data word
  for word in ${words[2,CURRENT-1]}; do [[ -d $word ]] && folder=${word%/}; done
  local -a runs=($folder/*/[0-9][0-9]/events.aedat4(N:h))
  runs=(${runs#$folder/})
  _sequence compadd - -a runs
}

_tactile_models() {
  local folder=${opt_args[--models]:-models}
  local -a models=($folder/*/model.json(N:h:t))
  _alternative 'models:model:compadd -a models' 'folders:folder:_files -/'
}

_tactile_sources() {
  if compset -P file:; then
    _tactile_recordings
  else
    local -a sources=(sim file: tcp:// unix: camera)
    _alternative 'sources:source:compadd -S "" -a sources' 'recordings:recording:_tactile_recordings'
  fi
}
)sh";

/// `text` within single quotes, after a backslash before each of `special`.
std::string with_backslashes(const std::string& text, std::string_view special) {
  std::string out;
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
      continue;
    }
    if (c == '\\' || special.find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string action_of(const CompletedValue& value) {
  const std::string words = fmt::format("{}", fmt::join(value.words, " "));
  switch (value.what) {
    case Completion::nothing:
      return " ";  // no guess
    case Completion::words:
      return "(" + words + ")";
    case Completion::list:
      return "_sequence compadd - " + words;
    case Completion::files:
      return value.extension.empty() ? "_files" : "_files -g \"*." + value.extension + "\"";
    case Completion::folders:
      return "_files -/";
    default:
      return function_of(value.what);
  }
}

/// What _arguments reads: '--preset=[tiny: ...]:NAME:(paper quick tiny)'.
std::string argument_of(CLI::Option& option, int& number) {
  const std::string value = value_text(option).name;
  const std::string of_value = value.empty() ? ""
                                             : (has_optional_value(option) ? "::" : ":") + with_backslashes(value, ":") + ":" +
                                                   action_of(completed_value(option));
  if (option.get_positional()) {
    const std::string place = option.get_expected_max() > 1 ? "*" : std::to_string(number++);
    return fmt::format("'{}{}'", place, of_value);
  }
  return fmt::format("'*{}{}[{}]{}'", option.get_name(), value.empty() ? "" : "=",
                     with_backslashes(option.get_description(), "[]"), of_value);
}

}  // namespace

std::string zsh_completion(CLI::App& program) {
  std::string names, cases;
  for (CLI::App* command : listed_commands(program)) {
    names += fmt::format("    '{}:{}'\n", command->get_name(), with_backslashes(command->get_description(), ":"));
    cases += fmt::format("    {})\n      _arguments", command->get_name());
    int number = 1;
    for (CLI::Option* option : command->get_options({})) cases += " \\\n        " + argument_of(*option, number);
    cases += "\n      ;;\n";
  }
  return fmt::format(
      "#compdef tactile\n# Completion of tactile for zsh. The program made it from the declarations of its options.\n{}\n"
      "_tactile() {{\n  local -A opt_args\n  local curcontext=$curcontext command=$words[2]\n  local -a commands=(\n{}"
      "    'help:Show help'\n    'version:Show version, libraries and CPU features'\n  )\n"
      "  if (( CURRENT == 2 )) || [[ $command == help ]]; then\n    _describe -t commands command commands\n    return\n  fi\n"
      "  shift words\n  (( CURRENT-- ))\n  case $command in\n{}  esac\n}}\n\n"
      "if [[ $funcstack[1] == _tactile ]]; then _tactile \"$@\"; else compdef _tactile tactile; fi\n",
      zsh_functions, names, cases);
}

}  // namespace tactile::cli
