#include "commands.hpp"
#include "program.hpp"

/// `tactile-runs`: every command that needs no libtorch.
int main(int argc, char** argv) {
  using namespace tactile::cli;
  return run_program(argc, argv, commands_of<Program::runs>());
}
