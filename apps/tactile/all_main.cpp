#include "commands.hpp"
#include "library_versions.hpp"
#include "program.hpp"

/// `tactile-all`: every command.
int main(int argc, char** argv) {
  using namespace tactile::cli;
  return run_program(argc, argv, commands_of<Program::all>(), libraries_text);
}
