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
#include "suggested_words.hpp"
#include "tactile/simulation/simulate.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

struct SimulateArguments {
  std::string data = "data";
  std::string physics;
  std::string camera;
  std::string preset = "quick";
  int runs = 0;
  std::vector<std::string> objects{"all"};
  std::uint64_t seed = 1;
  bool one_camera = false;
  bool force = false;
  bool verbose = false;
};

std::string_view name_of(simulation::SimulatedRun::Kind kind) {
  constexpr std::array<std::string_view, 4> names{"made", "kept", "replaced", "removed"};
  return names[static_cast<std::size_t>(kind)];
}

/// Sums over the runs.
struct SimulatedTotals {
  std::map<std::string_view, int> counts{{"made", 0}, {"kept", 0}, {"replaced", 0}, {"removed", 0}};
  std::uint64_t bytes = 0, touch_events = 0;
  double touch_s = 0, duration_s = 0;
};

bool is_new(const simulation::SimulatedRun& run) {
  return run.kind == simulation::SimulatedRun::Kind::made || run.kind == simulation::SimulatedRun::Kind::replaced;
}

SimulatedTotals totals_of(const std::vector<simulation::SimulatedRun>& runs) {
  SimulatedTotals totals;
  for (const simulation::SimulatedRun& run : runs) {
    ++totals.counts[name_of(run.kind)];
    totals.bytes += run.bytes;
    totals.touch_events += run.touch_events;
    totals.touch_s += run.touch_s;
    totals.duration_s += run.duration_s;
  }
  return totals;
}

nlohmann::json json_of(const simulation::SimulatedRun& run) {
  nlohmann::json json = {{"run", run.run.name()}, {"outcome", name_of(run.kind)}, {"bytes", run.bytes}};
  if (is_new(run)) {
    json["events"] = run.events;
    json["duration_s"] = run.duration_s;
  }
  return json;
}

/// A row for each object.
std::string table_of_objects(const std::vector<simulation::SimulatedRun>& runs) {
  std::map<std::string, std::vector<simulation::SimulatedRun>> by_object;
  for (const simulation::SimulatedRun& run : runs) by_object[run.run.object].push_back(run);
  std::vector<std::vector<std::string>> rows;
  for (const auto& [object, of_object] : by_object) {
    const SimulatedTotals totals = totals_of(of_object);
    std::uint64_t events = 0;
    for (const simulation::SimulatedRun& run : of_object) events += is_new(run) ? run.events : 0;
    rows.push_back({object, std::to_string(of_object.size()),
                    totals.duration_s > 0 ? fmt::format("{:.2f}", totals.duration_s) : "",
                    events > 0 ? std::to_string(events) : "", fmt::format("{:.1f}", 1e-6 * static_cast<double>(totals.bytes))});
  }
  return text_table({"object", "runs", "seconds", "events", "MB"}, rows);
}

std::string table_of_runs(const std::vector<simulation::SimulatedRun>& runs) {
  std::vector<std::vector<std::string>> rows;
  for (const simulation::SimulatedRun& run : runs) {
    rows.push_back({run.run.name(), std::string(name_of(run.kind)), is_new(run) ? fmt::format("{:.2f}", run.duration_s) : "",
                    is_new(run) ? std::to_string(run.events) : "", fmt::format("{:.1f}", 1e-6 * static_cast<double>(run.bytes))});
  }
  return text_table({"run", "", "seconds", "events", "MB"}, rows);
}

/// The speed as a sentence, and in `json`.
std::string speed_of(const SimulatedTotals& totals, double elapsed_s, double core_s, nlohmann::json& json) {
  const double times_real_time = totals.duration_s / core_s;
  json["times_real_time"] = times_real_time;
  std::string text = fmt::format(
      "{:.1f} s of runs made in {:.1f} s, {:.1f} times faster than real time; in {:.1f} s of processor time, {:.1f} times",
      totals.duration_s, elapsed_s, totals.duration_s / elapsed_s, core_s, times_real_time);
  if (totals.touch_s > 0) {
    const double touch_rate = static_cast<double>(totals.touch_events) / totals.touch_s;
    json["touch_events_per_s"] = touch_rate;
    text += fmt::format("; {:.2f} million events/s in press and slip on average", 1e-6 * touch_rate);
  }
  return wrapped(text) + "\n";
}

simulation::SimulationPhysics physics_of(const SimulateArguments& args) {
  simulation::SimulationPhysics physics = !args.physics.empty() ? simulation::read_physics(args.physics, args.camera)
                                          : args.camera.empty() ? simulation::default_physics()
                                                                : simulation::with_camera(args.camera);
  if (args.one_camera) physics.sessions.vary = false;
  return physics;
}

void simulate_runs(const SimulateArguments& args, const CommonArguments& common) {
  simulation::SimulateOptions options{.data = args.data,
                                      .preset = args.preset,
                                      .runs = {},
                                      .objects = args.objects,
                                      .seed = args.seed,
                                      .force = args.force,
                                      .threads = common.threads,
                                      .physics = physics_of(args)};
  if (args.runs > 0) options.runs = args.runs;
  if (std::find(options.objects.begin(), options.objects.end(), "all") != options.objects.end()) options.objects.clear();
  const auto begun = std::chrono::steady_clock::now();
  const std::clock_t worked = std::clock();  // of all threads
  const std::vector<simulation::SimulatedRun> runs = simulation::simulate(options, progress_line(common));
  const double core_s = static_cast<double>(std::clock() - worked) / CLOCKS_PER_SEC;
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();

  const SimulatedTotals totals = totals_of(runs);
  nlohmann::json result = {{"data", args.data},     {"physics", options.physics.source},
                           {"preset", args.preset}, {"seed", args.seed},
                           {"bytes", totals.bytes}, {"runs", nlohmann::json::array()}};
  for (const simulation::SimulatedRun& run : runs) result["runs"].push_back(json_of(run));
  std::string counts;
  for (const std::string_view kind : {"made", "kept", "replaced", "removed"}) {
    result[std::string(kind)] = totals.counts.at(kind);
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", totals.counts.at(kind), kind);
  }
  std::string text = (args.verbose ? table_of_runs(runs) : table_of_objects(runs)) +
                     fmt::format("\n{}: {}; {:.1f} MB (simulated, seed {})\n", args.data, counts,
                                 1e-6 * static_cast<double>(totals.bytes), args.seed);
  if (totals.duration_s > 0 && core_s > 0) text += speed_of(totals, elapsed_s, core_s, result);
  print_result(common, result, text);
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  auto args = std::make_shared<SimulateArguments>();
  Command command = add_command(app, "simulate", "Simulate run folders: events, robot log, video and exact truth",
                                [args](const CommonArguments& common) { simulate_runs(*args, common); });
  command.add_option("data", args->data, "Folder of runs").show_default();
  command
      .add_option("--physics", args->physics,
                  "JSON file with values that replace those of configs/simulation.json, cameras.json and objects.json")
      .check(is_existing_file())
      .type_name("FILE.json");
  command
      .add_option("--camera", args->camera,
                  "quiet: little noise, one stamp per read-out; measured: noise and stamps of a real camera; noisy: more noise, "
                  "a slower and darker sensor. Default: that of --physics, else measured")
      .check(one_of({"measured", "noisy", "quiet"}));
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
      .suggest(simulated_objects())
      .show_default();
  command.add_option("--seed", args->seed, "Seed of the whole data set").check(is_seed()).show_default();
  command.add_flag("--one-camera", args->one_camera, "The same camera in all sessions; otherwise each session has its own");
  command.add_flag("--force", args->force,
                   "Replace runs that were simulated with other settings, and remove extra simulated runs");
  command.add_flag("--verbose", args->verbose, "Print a line for each run");
}

}  // namespace tactile::cli
