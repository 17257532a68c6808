#include "commands.hpp"
#include "program.hpp"

/// `tactile`: runs its own commands, and starts another program for the others.
int main(int argc, char** argv) {
  using namespace tactile::cli;
  const std::string_view command = argc > 1 ? argv[1] : "";
  const Program program = command == "--version" ? Program::tactile : program_of(command).value_or(Program::model);
  if (program == Program::tactile) return run_program(argc, argv, commands_of<Program::tactile>());
  return hand_over_to(program == Program::runs ? "tactile-runs" : "tactile-model", argv);
}
