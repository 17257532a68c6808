#pragma once

#include <span>

namespace CLI {
class App;
}

namespace tactile {

/// Declares these commands, runs the one that was asked for, and turns what it throws into a sentence and an exit code.
int run_program(int argc, char** argv, std::span<void (*const)(CLI::App&)> commands);

/// Becomes another program of ours, which stands beside this one, with the same arguments; returns only where that fails: 1,
/// after saying why.
int hand_over_to(const char* program, char** argv);

}  // namespace tactile
