#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "program.hpp"
#include "tactile/core/runs_below.hpp"

namespace {

/// "info models/th40-single-1" is "models show th40-single-1 --models models": a model is no recording.
std::vector<std::string> with_model_as_model(std::vector<std::string> words) {
  namespace fs = std::filesystem;
  for (std::size_t i = 2; i < words.size(); ++i) {
    const fs::path given = fs::path(words[i]).has_filename() ? fs::path(words[i]) : fs::path(words[i]).parent_path();
    const fs::path bundle = tactile::is_there(given) ? given : "models" / given;
    if (words[i].starts_with('-') || !tactile::is_file(bundle / "model.json")) continue;
    words[1] = "models";
    words[i] = bundle.filename().string();
    words.insert(words.begin() + static_cast<std::ptrdiff_t>(i),
                 {"show", "--models", bundle.has_parent_path() ? bundle.parent_path().string() : "."});
    break;
  }
  return words;
}

/// The words of a command line as options: "help train" is "train --help", "version" is "--version", and nothing is "--help".
std::vector<std::string> as_options(std::vector<std::string> words) {
  if (words.size() == 1) words.emplace_back("--help");
  if (words[1] == "version") words[1] = "--version";
  if (words[1] == "info") return with_model_as_model(std::move(words));
  if (words[1] != "help") return words;
  words.erase(words.begin() + 1);
  const bool is_known = words.size() == 1 || tactile::cli::program_of(words[1]).has_value();
  if (is_known) words.emplace_back("--help");  // else the message names the nearest command
  return words;
}

}  // namespace

/// `tactile`: runs its own commands, and starts `tactile-all` for the others.
int main(int argc, char** argv) {
  using namespace tactile::cli;
  std::vector<std::string> words = as_options({argv, argv + argc});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string& command = words[1];
  const Program program = program_of(command).value_or(Program::all);  // --version, too: it names every library
  if (program == Program::tactile)
    return run_program(static_cast<int>(words.size()), arguments.data(), commands_of<Program::tactile>());
  return hand_over_to_all(arguments.data());
}
