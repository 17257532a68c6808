#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace CLI {
class App;
}

namespace tactile::cli {

void add_simulate_command(CLI::App& app);
void add_record_command(CLI::App& app);
void add_serve_command(CLI::App& app);
void add_info_command(CLI::App& app);
void add_repair_command(CLI::App& app);
void add_characterise_command(CLI::App& app);
void add_convert_command(CLI::App& app);
void add_import_command(CLI::App& app);
void add_split_command(CLI::App& app);
void add_label_command(CLI::App& app);
void add_review_command(CLI::App& app);
void add_windows_command(CLI::App& app);
void add_heatmaps_command(CLI::App& app);
void add_view_command(CLI::App& app);
void add_train_command(CLI::App& app);
void add_models_command(CLI::App& app);
void add_eval_command(CLI::App& app);
void add_detect_command(CLI::App& app);
void add_reproduce_command(CLI::App& app);
void add_stress_command(CLI::App& app);
void add_trade_command(CLI::App& app);
void add_report_command(CLI::App& app);
void add_export_command(CLI::App& app);
void add_doctor_command(CLI::App& app);
void add_judge_command(CLI::App& app);
void add_stress_step_command(CLI::App& app);
void add_pages_command(CLI::App& app);

// Loading OpenCV and libav takes more time than some commands need. Therefore there are two programs. libtorch and most of OpenCV
// are loaded by neither, but at their first use (core/loaded_part.hpp).
enum class Program : std::uint8_t {
  tactile,  ///< loads neither, and starts the other for its commands
  all       ///< tactile-all: every command
};

using AddCommand = void (*)(CLI::App&);

struct CommandEntry {
  std::string_view name;
  Program program;  ///< the first that has it
  AddCommand add;
};

/// Every command, in the order of use. The compiler evaluates it, so that a program links only its own commands.
consteval auto command_table() {
  return std::array{
      CommandEntry{"simulate", Program::all, add_simulate_command},
      CommandEntry{"record", Program::all, add_record_command},
      CommandEntry{"serve", Program::all, add_serve_command},
      CommandEntry{"info", Program::tactile, add_info_command},
      CommandEntry{"repair", Program::tactile, add_repair_command},
      CommandEntry{"characterise", Program::all, add_characterise_command},
      CommandEntry{"convert", Program::all, add_convert_command},
      CommandEntry{"import", Program::all, add_import_command},
      CommandEntry{"split", Program::all, add_split_command},
      CommandEntry{"label", Program::all, add_label_command},
      CommandEntry{"review", Program::all, add_review_command},
      CommandEntry{"windows", Program::all, add_windows_command},
      CommandEntry{"heatmaps", Program::all, add_heatmaps_command},
      CommandEntry{"view", Program::all, add_view_command},
      CommandEntry{"train", Program::all, add_train_command},
      CommandEntry{"models", Program::all, add_models_command},
      CommandEntry{"eval", Program::all, add_eval_command},
      CommandEntry{"detect", Program::all, add_detect_command},
      CommandEntry{"reproduce", Program::all, add_reproduce_command},
      CommandEntry{"trade", Program::all, add_trade_command},
      CommandEntry{"stress", Program::all, add_stress_command},
      CommandEntry{"report", Program::all, add_report_command},
      CommandEntry{"export", Program::all, add_export_command},
      CommandEntry{"doctor", Program::all, add_doctor_command},
      CommandEntry{"judge", Program::all, add_judge_command},
      CommandEntry{"stress-step", Program::all, add_stress_step_command},
      CommandEntry{"pages", Program::all, add_pages_command},
  };
}

/// The commands of a program.
template <Program program>
consteval auto commands_of() {
  constexpr auto table = command_table();
  constexpr std::size_t count = [&table] {
    std::size_t n = 0;
    for (const CommandEntry& entry : table) n += entry.program <= program ? 1 : 0;
    return n;
  }();
  std::array<AddCommand, count> commands{};
  std::size_t next = 0;
  for (const CommandEntry& entry : table) {
    if (entry.program <= program) commands[next++] = entry.add;
  }
  return commands;
}

/// The first program with a command; nothing if there is no such command.
constexpr std::optional<Program> program_of(std::string_view command) {
  constexpr auto programs = [] {
    constexpr auto table = command_table();
    std::array<std::pair<std::string_view, Program>, table.size()> found{};
    for (std::size_t i = 0; i < table.size(); ++i) found[i] = {table[i].name, table[i].program};
    return found;
  }();
  for (const auto& [name, program] : programs) {
    if (name == command) return program;
  }
  return std::nullopt;
}

}  // namespace tactile::cli
