#include <fmt/format.h>

#include "completed_value.hpp"
#include "completion_scripts.hpp"
#include "help_text.hpp"

namespace tactile::cli {
namespace {

constexpr std::string_view fish_functions = R"sh(
# Whether the line has this command.
function __tactile_command
    set -l words (commandline -opc)
    test (count $words) -ge 2; and test $words[2] = $argv[1]
end

function __tactile_no_command
    test (count (commandline -opc)) -eq 1
end

# Offers the arguments as a list with commas.
function __tactile_list
    set -l chosen (string match -r '^.*,' -- (commandline -ct))
    for word in $argv
        echo "$chosen$word"
    end
end

# The run folders below a folder.
function __tactile_run_folders
    for object in $argv[1]/*
        for run in $object/*
            if string match -qr '/[0-9][0-9]$' -- $run; and test -e $run/events.aedat4
                echo $run
            end
        end
    end
end

# The names of the runs in the folder that the line names, else in data/.
function __tactile_runs
    set -l folder data
    for word in (commandline -opc)[3..]
        test -d $word; and set folder (string trim -r -c / -- $word)
    end
    __tactile_list (__tactile_run_folders $folder | string replace "$folder/" '')
end

function __tactile_models
    set -l folder models
    set -l words (commandline -opc)
    if set -l place (contains -i -- --models $words)
        set -q words[(math $place + 1)]; and set folder $words[(math $place + 1)]
    end
    for model in $folder/*
        test -e $model/model.json; and string replace -r '.*/' '' -- $model
    end
end

function __tactile_sources
    printf '%s\n' sim file: tcp:// unix: camera
    __tactile_run_folders data | string replace -r '^' file:
end
)sh";

/// A text in single quotes.
std::string quoted(const std::string& text) {
  std::string inner;
  for (const char c : text) inner += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return "'" + inner + "'";
}

/// What offers a value: "-x -a 'tiny quick'", where -x permits no files, and -r -F all.
std::string fish_offer_of(const CompletedValue& value) {
  const std::string words = fmt::format("{}", fmt::join(value.words, " "));
  switch (value.what) {
    case Completion::nothing:
      return "-x";
    case Completion::words:
      return "-x -a " + quoted(words);
    case Completion::list:
      return "-x -a " + quoted("(__tactile_list " + words + ")");
    case Completion::files:
      return value.extension.empty() ? "-r -F" : "-x -a " + quoted("(__fish_complete_suffix ." + value.extension + ")");
    case Completion::folders:
      return "-x -a '(__fish_complete_directories)'";
    case Completion::recordings:
      return "-r -F -a '(__tactile_run_folders data)'";
    case Completion::run_folders:
      return "-x -a '(__tactile_run_folders data) (__fish_complete_directories)'";
    case Completion::runs:
      return "-x -a '(__tactile_runs)'";
    case Completion::models:
      return "-x -a '(__tactile_models) (__fish_complete_directories)'";
    case Completion::sources:
      return "-r -F -a '(__tactile_sources)'";
  }
  return "";
}

/// A line for an option, or for arguments; empty if nothing completes the arguments.
std::string line_of(const CLI::App& command, CLI::Option& option) {
  const CompletedValue value = completed_value(option);
  std::string line = fmt::format("complete -c tactile -n '__tactile_command {}'", command.get_name());
  if (option.get_positional()) {
    if (value.what == Completion::nothing) return "";
    std::string offer = fish_offer_of(value);
    offer.erase(0, offer.find(' ') + 1);  // -x and -r are for the values of options
    return fmt::format("{} {}\n", line, offer);
  }
  line += option.get_name() == "--help" ? " -s h -l help" : " -l " + option.get_name().substr(2);
  if (!value_text(option).name.empty() && !has_optional_value(option)) line += " " + fish_offer_of(value);
  return fmt::format("{} -d {}\n", line, quoted(option.get_description()));
}

}  // namespace

std::string fish_completion(CLI::App& program) {
  std::string text = fmt::format(
      "# Completion of tactile for fish. The program made it from the declarations of its options.\n{}\ncomplete -c tactile -f\n",
      fish_functions);
  for (CLI::App* command : listed_commands(program)) {
    text += fmt::format("complete -c tactile -n __tactile_no_command -a {} -d {}\n", command->get_name(),
                        quoted(command->get_description()));
    text += fmt::format("complete -c tactile -n '__tactile_command help' -a {}\n", command->get_name());
    for (CLI::Option* option : command->get_options({})) text += line_of(*command, *option);
  }
  return text + "complete -c tactile -n __tactile_no_command -a 'help version' -l help -l version\n";
}

}  // namespace tactile::cli
