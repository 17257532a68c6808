#include "commands.hpp"
#include "program.hpp"

/// What needs no libtorch: see main.cpp.
int main(int argc, char** argv) {
  using namespace tactile;
  return run_program(argc, argv,
                     {add_simulate_command, add_record_command, add_serve_command, add_convert_command, add_label_command,
                      add_windows_command, add_heatmaps_command, add_view_command, add_report_command, add_export_command});
}
