#include <string>
#include <vector>

#include "commands.hpp"
#include "program.hpp"

namespace {

/// The words of a command line as options: "help train" is "train --help", "version" is "--version", and nothing is "--help".
std::vector<std::string> as_options(std::vector<std::string> words) {
  if (words.size() == 1) words.emplace_back("--help");
  if (words[1] == "version") words[1] = "--version";
  if (words[1] != "help") return words;
  words.erase(words.begin() + 1);
  const bool is_known = words.size() == 1 || tactile::cli::program_of(words[1]).has_value();
  if (is_known) words.emplace_back("--help");  // else the message names the nearest command
  return words;
}

}  // namespace

/// `tactile`: runs its own commands, and starts another program for the others.
int main(int argc, char** argv) {
  using namespace tactile::cli;
  std::vector<std::string> words = as_options({argv, argv + argc});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string& command = words[1];
  const Program program = program_of(command).value_or(Program::model);  // --version, too: it names every library
  if (program == Program::tactile)
    return run_program(static_cast<int>(words.size()), arguments.data(), commands_of<Program::tactile>());
  return hand_over_to(program == Program::runs ? "tactile-runs" : "tactile-model", arguments.data());
}
