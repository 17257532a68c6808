#pragma once

#include <CLI/CLI.hpp>
#include <string>

// Scripts with which shells complete command lines: commands, options, values of closed sets, files, runs and models that exist.
// They are made from the same declarations as the help. Completing starts no program of tactile.
namespace tactile::cli {

std::string bash_completion(CLI::App& program);
std::string zsh_completion(CLI::App& program);
std::string fish_completion(CLI::App& program);

}  // namespace tactile::cli
