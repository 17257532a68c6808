#include <fmt/format.h>

#include "completed_value.hpp"
#include "completion_scripts.hpp"
#include "help_text.hpp"
#include "tactile/core/text_lines.hpp"

namespace tactile::cli {
namespace {

/// Functions that offer what begins with $current. They are independent of the commands.
constexpr std::string_view bash_functions = R"sh(
# Offers those of the arguments that begin with $current.
_tactile_offer() {
  local typed=${COMP_WORDS[COMP_CWORD]-} lead= before= word
  # bash replaces only what follows the last : or = of a word.
  [[ $typed == [=:] ]] && typed=
  [[ $typed == --*=* ]] && lead=${typed%%=*}= typed=${typed#*=}
  [[ $current == *"$typed" ]] && before=${current%"$typed"}
  for word; do
    [[ $word == "$current"* ]] || continue
    word=${word#"$before"}
    [[ $word == *[!a-zA-Z0-9_.,:=/+@%-]* ]] && printf -v word %q "$word"
    COMPREPLY+=("$lead$word")
  done
}

_tactile_list() {
  local done=
  [[ $current == *,* ]] && done=${current%,*},
  _tactile_offer "${@/#/$done}"
  compopt -o nospace 2>/dev/null
}

# Offers folders, and files whose names end with an argument.
_tactile_paths() {
  local path ending
  while IFS= read -r path; do
    if [[ -d $path ]]; then
      _tactile_offer "$path/"
    else
      for ending; do [[ $path == *"$ending" ]] && _tactile_offer "$path"; done
    fi
  done < <(compgen -f -- "$current")
  [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == */ ]] && compopt -o nospace 2>/dev/null
}

_tactile_files() { _tactile_paths "${1:+.$1}"; }
_tactile_folders() { _tactile_paths; }

# Prints the runs below a folder.
_tactile_runs_in() {
  local events
  for events in "$1"/*/[0-9][0-9]/events.aedat4; do [[ -e $events ]] && echo "${events%/events.aedat4}"; done
}

_tactile_run_folders() {
  local -a runs
  mapfile -t runs < <(_tactile_runs_in data)
  _tactile_offer "${runs[@]}"
  _tactile_folders
}

_tactile_recordings() {
  local -a runs
  mapfile -t runs < <(_tactile_runs_in data)
  _tactile_offer "${runs[@]}"
  _tactile_files
}

# The names of the runs in the folder that the line names, else in data/.
_tactile_runs() {
  local -a runs
  local folder=data word
  for word in "${before[@]:2}"; do [[ -d $word ]] && folder=${word%/}; done
  mapfile -t runs < <(_tactile_runs_in "$folder")
  _tactile_list "${runs[@]#"$folder"/}"
}

_tactile_models() {
  local folder=models description i
  for ((i = 2; i + 1 < ${#before[@]}; ++i)); do [[ ${before[i]} == --models ]] && folder=${before[i + 1]}; done
  for description in "$folder"/*/model.json; do
    description=${description%/model.json}
    [[ -e $description ]] && _tactile_offer "${description##*/}"
  done
  [[ $current == */* ]] && _tactile_folders
}

_tactile_sources() {
  local path
  if [[ $current == file:* ]]; then
    while IFS= read -r path; do
      [[ -d $path && ! -e $path/events.aedat4 ]] && path+=/
      _tactile_offer "file:$path"
    done < <(compgen -f -- "${current#file:}")
  else
    _tactile_offer sim file: tcp:// unix: camera
    _tactile_recordings
  fi
  compopt -o nospace 2>/dev/null
}
)sh";

constexpr std::string_view main_function = R"sh(
_tactile() {
  local line=${COMP_LINE:0:COMP_POINT} token command options option= current word
  local -a before
  local -i number=1
  token=${line##*[[:space:]]}
  read -ra before <<<"${line%"$token"}"
  COMPREPLY=()
  current=$token
  command=${before[1]-}
  if [[ -z $command || $command == help ]]; then
    _tactile_commands
    return
  fi
  options=$(_tactile_options "$command")
  for word in "${before[@]:2}"; do
    if [[ -n $option && $word != --* ]]; then
      option=
    elif [[ " $options " == *" $word= "* ]]; then
      option=$word
    elif [[ $word != -* ]]; then
      number+=1
    fi
  done
  if [[ -z $option && $token == --*=* ]]; then
    option=${token%%=*}
    current=${token#*=}
  elif [[ $token == --* || ( -z $option && $token == -* ) ]]; then
    read -ra options <<<"$options"
    _tactile_offer "${options[@]%=}"
    return
  fi
  _tactile_value "$command" "${option:-$number}"
}

complete -F _tactile tactile
)sh";

std::string bash_offer_of(Completion what) {
  switch (what) {
    case Completion::nothing:
      return "";
    case Completion::words:
      return "_tactile_offer";
    case Completion::list:
      return "_tactile_list";
    case Completion::files:
      return "_tactile_files";
    case Completion::folders:
      return "_tactile_folders";
    default:
      return function_of(what);
  }
}

/// A line of `case` for the value of an option; empty if nothing completes it.
std::string case_of(const CLI::App& command, CLI::Option& option, int& number) {
  std::string key = option.get_name();
  if (option.get_positional()) {
    key = std::to_string(number++);
    if (option.get_expected_max() > 1) key = "[0-9]*";  // the last argument may be repeated
  }
  const CompletedValue value = completed_value(option);
  if (value.what == Completion::nothing) return "";
  std::string call = bash_offer_of(value.what);
  for (const std::string& word : value.words) call += " " + shell_word(word);
  if (!value.extension.empty()) call += " " + value.extension;
  return fmt::format("    {}\\ {}) {} ;;\n", command.get_name(), key, call);
}

}  // namespace

std::string bash_completion(CLI::App& program) {
  std::string names, options, values;
  for (CLI::App* command : listed_commands(program)) {
    names += " " + command->get_name();
    std::string of_command;
    int number = 1;
    for (CLI::Option* option : command->get_options({})) {
      if (!option->get_positional())
        of_command += (of_command.empty() ? "" : " ") + option->get_name() + (value_text(*option).name.empty() ? "" : "=");
      values += case_of(*command, *option, number);
    }
    options += fmt::format("    {}) echo '{}' ;;\n", command->get_name(), of_command);
  }
  return fmt::format(
      "# Completion of tactile for bash. The program made it from the declarations of its options.\n{}\n"
      "_tactile_commands() {{ _tactile_offer{} help version --help --version; }}\n\n"
      "# The options of a command; = where a value follows.\n_tactile_options() {{\n  case $1 in\n{}  esac\n}}\n\n"
      "# Offers what completes the value of an option, or an argument by its number.\n_tactile_value() {{\n"
      "  case \"$1 $2\" in\n{}  esac\n}}\n{}",
      bash_functions, names, options, values, main_function);
}

}  // namespace tactile::cli
