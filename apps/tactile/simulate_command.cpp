#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "option_checks.hpp"
#include "tactile/simulation/simulate.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

struct SimulateArguments {
  std::string data = "data";
  std::string physics;
  std::string preset = "quick";
  int runs = 0;
  std::vector<std::string> objects{"all"};
  std::uint64_t seed = 1;
  bool force = false;
};

std::string_view name_of(SimulatedRun::Kind kind) {
  constexpr std::array<std::string_view, 4> names{"made", "kept", "replaced", "removed"};
  return names[static_cast<std::size_t>(kind)];
}

void simulate_runs(const SimulateArguments& args, const CommonArguments& common) {
  SimulateOptions options{.data = args.data,
                          .preset = args.preset,
                          .runs = {},
                          .objects = args.objects,
                          .seed = args.seed,
                          .force = args.force,
                          .threads = common.threads,
                          .physics = args.physics.empty() ? default_physics() : read_physics(args.physics)};
  if (args.runs > 0) options.runs = args.runs;
  if (std::find(options.objects.begin(), options.objects.end(), "all") != options.objects.end()) options.objects.clear();
  const auto begun = std::chrono::steady_clock::now();
  const std::clock_t worked = std::clock();  // on all threads
  const std::vector<SimulatedRun> outcomes = simulate(options, progress_line(common));
  const double core_s = static_cast<double>(std::clock() - worked) / CLOCKS_PER_SEC;
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();

  std::map<std::string_view, int> counts{{"made", 0}, {"kept", 0}, {"replaced", 0}, {"removed", 0}};
  nlohmann::json runs = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  std::uint64_t bytes = 0, touch_events = 0;
  double touch_s = 0, duration_s = 0;
  for (const SimulatedRun& outcome : outcomes) {
    ++counts[name_of(outcome.kind)];
    bytes += outcome.bytes;
    touch_events += outcome.touch_events;
    touch_s += outcome.touch_s;
    duration_s += outcome.duration_s;
    const bool is_new = outcome.kind == SimulatedRun::Kind::made || outcome.kind == SimulatedRun::Kind::replaced;
    nlohmann::json run = {{"run", outcome.run.name()}, {"outcome", name_of(outcome.kind)}, {"bytes", outcome.bytes}};
    if (is_new) {
      run["events"] = outcome.events;
      run["duration_s"] = outcome.duration_s;
    }
    runs.push_back(run);
    rows.push_back({outcome.run.name(), std::string(name_of(outcome.kind)),
                    is_new ? fmt::format("{:.2f}", outcome.duration_s) : "", is_new ? std::to_string(outcome.events) : "",
                    fmt::format("{:.1f}", 1e-6 * static_cast<double>(outcome.bytes))});
  }
  nlohmann::json result = {{"data", args.data},
                           {"physics", options.physics.source},
                           {"preset", args.preset},
                           {"seed", args.seed},
                           {"made", counts["made"]},
                           {"kept", counts["kept"]},
                           {"replaced", counts["replaced"]},
                           {"removed", counts["removed"]},
                           {"bytes", bytes},
                           {"runs", runs}};
  std::string text = text_table({"run", "", "seconds", "events", "MB"}, rows);
  text +=
      fmt::format("\n{}: {} made, {} kept, {} replaced, {} removed; {:.1f} MB (simulated, seed {})\n", args.data, counts["made"],
                  counts["kept"], counts["replaced"], counts["removed"], 1e-6 * static_cast<double>(bytes), args.seed);
  if (duration_s > 0 && core_s > 0) {
    const double times_real_time = duration_s / core_s;
    result["times_real_time"] = times_real_time;
    std::string speed = fmt::format(
        "{:.1f} s of runs made in {:.1f} s by the clock, {:.1f} times faster than real time, and in {:.1f} s "
        "of work of all cores, {:.1f} times",
        duration_s, elapsed_s, duration_s / elapsed_s, core_s, times_real_time);
    if (touch_s > 0) {
      const double touch_rate = static_cast<double>(touch_events) / touch_s;
      result["touch_events_per_s"] = touch_rate;
      speed += fmt::format("; {:.2f} million events/s in press and slip on average", 1e-6 * touch_rate);
    }
    text += wrapped(speed) + "\n";
  }
  print_result(common, result, text);
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  auto args = std::make_shared<SimulateArguments>();
  Command command = add_command(app, "simulate", "Simulate run folders: events, robot log, video and exact truth",
                                [args](const CommonArguments& common) { simulate_runs(*args, common); });
  command.add_option("data", args->data, "Folder of runs").show_default();
  command
      .add_option(
          "--physics", args->physics,
          "JSON file of what runs are drawn from, in the place of what configs/simulation.json and configs/objects.json say")
      .check(is_existing_file())
      .type_name("FILE.json");
  command
      .add_option("--preset", args->preset,
                  "tiny: 2 runs of about 2.5 s per object; quick: 3 runs of about 4 s; paper: 10 runs of about 4 s, some with "
                  "two presses, no slip or no press")
      .check(one_of({"paper", "quick", "tiny"}))
      .show_default();
  command.add_option("--runs", args->runs, "Runs per object; default: the preset's").check(in_range(1, 99)).type_name("N");
  command.add_option("--objects", args->objects, "Objects, separated by commas, or all")
      .delimiter(',')
      .type_name("NAME,...")
      .show_default();
  command.add_option("--seed", args->seed, "Seed of the whole data set").check(is_seed()).show_default();
  command.add_flag("--force", args->force,
                   "Replace runs that were simulated with other settings, and remove extra simulated runs");
}

}  // namespace tactile
