#include "commands.hpp"
#include "program.hpp"

/// Every command, in the order they are run: see main.cpp.
int main(int argc, char** argv) {
  using namespace tactile;
  return run_program(argc, argv,
                     {add_simulate_command, add_record_command, add_serve_command, add_info_command, add_repair_command,
                      add_convert_command, add_label_command, add_windows_command, add_heatmaps_command, add_view_command,
                      add_train_command, add_eval_command, add_detect_command, add_reproduce_command, add_report_command, add_export_command,
                      add_doctor_command});
}
