#include <algorithm>
#include <array>
#include <string_view>

#include "commands.hpp"
#include "program.hpp"

// Loading libtorch, OpenCV and libav takes longer, and more memory, than many a command does. So there are three programs:
// this one, which holds what needs none of them; tactile-runs, which holds what needs no libtorch; and tactile-model, which holds
// every command. This one becomes another where the command is not its own.

int main(int argc, char** argv) {
  using namespace tactile;
  const std::string_view command = argc > 1 ? argv[1] : "";
  constexpr std::array own{"info", "repair", "--version"};
  constexpr std::array of_runs{"simulate", "record",   "serve", "convert", "label",
                               "windows",  "heatmaps", "view",  "report",  "export"};
  const auto is_among = [command](const auto& names) { return std::find(names.begin(), names.end(), command) != names.end(); };
  if (is_among(own)) return run_program(argc, argv, {add_info_command, add_repair_command});
  return hand_over_to(is_among(of_runs) ? "tactile-runs" : "tactile-model", argv);
}
