#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "field_options.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "tactile/core/error.hpp"
#include "tactile/windows/dataset_settings.hpp"
#include "tactile/windows/verify_dataset.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

struct WindowsArguments {
  std::string data = "data";
  std::string out;
  windows::WindowsOptions options;
  bool verify = false, verbose = false;
};

const char* name_of(windows::DatasetSummary::Outcome outcome) {
  switch (outcome) {
    case windows::DatasetSummary::Outcome::written:
      return "written";
    case windows::DatasetSummary::Outcome::replaced:
      return "replaced";
    case windows::DatasetSummary::Outcome::moved:
      return "moved";
    case windows::DatasetSummary::Outcome::unchanged:
      return "unchanged";
  }
  return "unknown";
}

nlohmann::json json_of(const std::optional<windows::DatasetChanges>& changes) {
  if (!changes) return nullptr;
  return {{"added", changes->added}, {"changed", changes->changed}, {"dropped", changes->dropped}, {"kept", changes->kept}};
}

nlohmann::json json_of(const windows::DatasetSummary& summary, const std::string& file) {
  nlohmann::json runs = nlohmann::json::array();
  for (const windows::WindowedRun& run : summary.runs) {
    runs.push_back({{"object", run.object},
                    {"run", run.run},
                    {"in_dataset", run.in_dataset},
                    {"none", run.samples[0]},
                    {"press", run.samples[1]},
                    {"slip", run.samples[2]},
                    {"remark", run.remark}});
  }
  return {{"dataset", file},
          {"outcome", name_of(summary.outcome)},
          {"manifest_sha256", summary.manifest_hash},
          {"simulated", summary.simulated},
          {"samples", summary.samples},
          {"events", summary.events},
          {"runs", runs},
          {"changes", json_of(summary.changes)},
          {"read_runs", summary.read_runs},
          {"warnings", summary.warnings},
          {"misnamed", summary.misnamed},
          {"errors", summary.errors}};
}

/// "1 run added, 29 kept"
std::string text_of(const windows::DatasetChanges& changes) {
  std::string text;
  const auto add = [&](const std::vector<std::string>& runs, const char* what) {
    if (runs.empty()) return;
    if (!text.empty()) text += fmt::format(", {} {}", runs.size(), what);
    if (text.empty()) text = fmt::format("{} run{} {}", runs.size(), runs.size() == 1 ? "" : "s", what);
  };
  add(changes.added, "added");
  add(changes.changed, "changed");
  add(changes.dropped, "dropped");
  add(changes.kept, "kept");
  return text;
}

/// A row for each object; one for all of them where there are many.
std::string table_of_objects(const windows::DatasetSummary& summary) {
  constexpr std::size_t most_objects = 10;
  struct Sum {
    std::size_t runs = 0, remarks = 0;
    std::array<std::size_t, touch_count> samples{};
  };
  std::map<std::string, Sum> sums;
  Sum all;
  for (const windows::WindowedRun& run : summary.runs) {
    for (Sum* sum : {&sums[run.object], &all}) {
      ++sum->runs;
      sum->remarks += run.remark.empty() ? 0 : 1;
      for (const Touch touch : all_touches)
        sum->samples[static_cast<std::size_t>(touch)] += run.samples[static_cast<std::size_t>(touch)];
    }
  }
  if (sums.size() > most_objects) sums = {{fmt::format("all {}", sums.size()), all}};
  std::vector<std::vector<std::string>> rows;
  rows.reserve(sums.size());
  for (const auto& [object, sum] : sums) {
    rows.push_back({object, std::to_string(sum.runs), std::to_string(sum.samples[0]), std::to_string(sum.samples[1]),
                    std::to_string(sum.samples[2]),
                    sum.remarks == 0 ? "" : fmt::format("{} with a remark, see --verbose", counted(sum.remarks, "run"))});
  }
  return text_table({"object", "runs", "none", "press", "slip", ""}, rows);
}

std::string table_of_runs(const windows::DatasetSummary& summary) {
  std::vector<std::vector<std::string>> rows;
  for (const windows::WindowedRun& run : summary.runs) {
    const auto count = [&](Touch touch) {
      return run.in_dataset ? std::to_string(run.samples[static_cast<std::size_t>(touch)]) : std::string("-");
    };
    rows.push_back({run.object + "/" + run.run, count(Touch::none), count(Touch::press), count(Touch::slip), run.remark});
  }
  return text_table({"run", "none", "press", "slip", ""}, rows);
}

/// @param differing  what differs from the previous dataset
std::string text_of(const windows::DatasetSummary& summary, const std::string& file, const std::vector<std::string>& differing,
                    bool verbose) {
  std::string text = verbose ? table_of_runs(summary) : table_of_objects(summary);
  text += fmt::format("\n{}: {}, {} samples and {} events{}, manifest {}\n", file, name_of(summary.outcome), summary.samples,
                      summary.events, summary.simulated ? " of simulated runs" : "", summary.manifest_hash.substr(0, 8));
  if (summary.was_damaged) text += "The previous dataset could not be read. It is replaced, and its heatmaps are lost.\n";
  if (!differing.empty() && summary.outcome == windows::DatasetSummary::Outcome::replaced && !summary.was_damaged)
    text += fmt::format("The previous dataset had other settings: {}.\n", fmt::join(differing, ", "));
  if (summary.changes) {
    text += text_of(*summary.changes) + "\n";
    text += summary.changes->kept.empty() ? "Its heatmaps are lost; 'tactile heatmaps' renders them.\n"
                                          : "'tactile heatmaps' keeps the heatmaps of the kept runs and renders the others.\n";
  }
  if (summary.outcome == windows::DatasetSummary::Outcome::moved)
    text += "It is the previous dataset, with its heatmaps. The folders of its runs were updated.\n";
  return text;
}

void verify(const WindowsArguments& args, const std::string& file, const CommonArguments& common) {
  const windows::DatasetCheck check = windows::verify_dataset(args.data, file, common.threads, progress_line(common));
  const bool verified = check.differences.empty();
  std::string text;
  for (const std::string& difference : check.differences) text += difference + "\n";
  std::string verdict = fmt::format("{}: differs from the runs and labels below {}", file, args.data);
  if (verified) {
    verdict = fmt::format(
        "{}: every sample, interval and event agrees with the runs and labels below {}, and no event in a window of one run is "
        "in another run, so every split is clean; ",
        file, args.data);
    verdict += check.pairs_at_one_time == 0
                   ? "no two recordings overlap in camera time"
                   : fmt::format("recordings compared where they overlap in camera time: {} pairs, events equal by chance: {}",
                                 check.pairs_at_one_time, check.equal_by_chance);
    verdict += check.histories.empty() ? "; no history is stored"
                                       : fmt::format("; every value of {} is unchanged", fmt::join(check.histories, ", "));
  }
  print_result(common,
               {{"dataset", file},
                {"verified", verified},
                {"differences", check.differences},
                {"histories", check.histories},
                {"pairs_at_one_time", check.pairs_at_one_time},
                {"equal_by_chance", check.equal_by_chance}},
               text + wrapped(verdict) + "\n");
  if (!verified) throw CheckFailed{};
}

void write_windows(const WindowsArguments& args, const CommonArguments& common) {
  const std::string file = args.out.empty() ? (std::filesystem::path(args.data) / "dataset.h5").string() : args.out;
  if (args.verify) return verify(args, file, common);
  const std::vector<std::string> differing = windows::settings_unlike_those_in(file, args.options);
  const windows::DatasetSummary summary =
      windows::write_dataset(args.data, file, args.options, common.threads, progress_line(common));
  for (const std::string& warning : summary.warnings) spdlog::warn("{}", warning);
  print_result(common, json_of(summary, file), text_of(summary, file, differing, args.verbose));
  end_with(summary.errors);
}

}  // namespace

void add_windows_command(CLI::App& app) {
  auto args = std::make_shared<WindowsArguments>();
  Command command = add_command(app, "windows", "Draw balanced samples from labelled runs into a dataset",
                                [args](const CommonArguments& common) { write_windows(*args, common); });
  command.add_option("data", args->data, "Folder of runs, DATA/<object>/<run>").show_default();
  command.add_option("--out", args->out, "Dataset to write; default: DATA/dataset.h5").type_name("FILE.h5");
  add_field_options(command, args->options.sampling);
  command.add_flag("--mix", args->options.mix,
                   "Put simulated and real runs into one dataset; default: only the real runs if there are both");
  command.add_flag("--include-flagged", args->options.include_flagged, "Also use flagged runs and intervals");
  add_strict_option(command, args->options.strict);
  command.add_flag("--verbose", args->verbose, "Print a line for each run, with its remarks");
  command.add_flag("--verify", args->verify,
                   "Write nothing: derive the dataset again with its own settings and compare; exit with 2 if it differs");
}

}  // namespace tactile::cli
