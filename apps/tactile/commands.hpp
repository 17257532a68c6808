#pragma once

namespace CLI {
class App;
}

namespace tactile {

// In the order they are run.
void add_simulate_command(CLI::App& app);
void add_record_command(CLI::App& app);
void add_serve_command(CLI::App& app);
void add_info_command(CLI::App& app);
void add_repair_command(CLI::App& app);
void add_convert_command(CLI::App& app);
void add_label_command(CLI::App& app);
void add_windows_command(CLI::App& app);
void add_heatmaps_command(CLI::App& app);
void add_view_command(CLI::App& app);
void add_train_command(CLI::App& app);
void add_eval_command(CLI::App& app);
void add_detect_command(CLI::App& app);
void add_reproduce_command(CLI::App& app);
void add_trade_command(CLI::App& app);
void add_report_command(CLI::App& app);
void add_export_command(CLI::App& app);
void add_doctor_command(CLI::App& app);

}  // namespace tactile
