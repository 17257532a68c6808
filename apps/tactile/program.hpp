#pragma once

#include <span>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): its authors named it
class App;
}

namespace tactile::cli {

/// Declares these commands, runs the requested one, and turns an exception into a sentence and an exit code.
/// @param libraries  the lines that --version prints after the first; none if null
int run_program(int argc, char** argv, std::span<void (*const)(CLI::App&)> commands, std::string (*libraries)() = nullptr);

/// Starts `tactile-all` in place of this program, with the same arguments. It is in the folder of this program, as after a build,
/// or in `../libexec/tactile` from there, as after an installation. Returns only if that fails: 1, after printing the reason.
int hand_over_to_all(char** argv);

}  // namespace tactile::cli
