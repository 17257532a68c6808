#include "commands.hpp"

#include <fmt/core.h>

#include "command.hpp"
#include "tactile/core/version.hpp"

namespace tactile {
namespace {

void examine_machine(const CommonArguments& common) {
  const nlohmann::json result = {{"version", version()}, {"revision", revision()}};
  print_result(common, result, fmt::format("tactile {} ({})\n", version(), revision()));
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  add_command(app, "doctor", "Check this machine: libraries, BLAS, CPU, timer, disk, camera", examine_machine);
}

}  // namespace tactile
