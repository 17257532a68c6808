#pragma once

#include <CLI/CLI.hpp>

namespace tactile {

// In the order they are run.
void add_simulate_command(CLI::App& app);
void add_doctor_command(CLI::App& app);

}  // namespace tactile
