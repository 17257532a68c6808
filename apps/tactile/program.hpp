#pragma once

#include <span>

namespace CLI {
class App;
}

namespace tactile::cli {

/// Declares these commands, runs the requested one, and turns an exception into a sentence and an exit code.
int run_program(int argc, char** argv, std::span<void (*const)(CLI::App&)> commands);

/// Starts another tactile program from the same folder in place of this one, with the same arguments. Returns only if that fails:
/// 1, after printing the reason.
int hand_over_to(const char* program, char** argv);

}  // namespace tactile::cli
