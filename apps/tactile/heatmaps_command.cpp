#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "field_options.hpp"
#include "heatmap_pictures.hpp"
#include "option_checks.hpp"
#include "rendering_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct HeatmapsArguments {
  std::string data = "data";
  std::vector<microseconds> histories{2ms, 10ms, 20ms, 30ms, 40ms, 50ms};
  heatmaps::HeatmapOptions rendering;  ///< its history has no meaning
  std::string mask, pictures;
};

/// "unchanged", "written", or "1 run rendered, 29 kept" of an older dataset.
std::string outcome_of(const heatmaps::StoredHistory& history) {
  if (history.kept) return "unchanged";
  if (history.runs_kept == 0) return "written";
  return fmt::format("{} run{} rendered, {} kept", history.runs_rendered, history.runs_rendered == 1 ? "" : "s",
                     history.runs_kept);
}

nlohmann::json json_of(const heatmaps::StoredHistory& history) {
  const windows::StoredHeatmaps& stored = history.heatmaps;
  return {{"name", stored.name},
          {"outcome", history.kept ? "unchanged" : "written"},
          {"runs_rendered", history.runs_rendered},
          {"runs_kept", history.runs_kept},
          {"settings", stored.settings},
          {"width", stored.width},
          {"height", stored.height}};
}

void render_heatmaps(const HeatmapsArguments& args, const CommonArguments& common) {
  const fs::path given = args.data;
  const bool is_file = fs::is_regular_file(given) || (!fs::exists(given) && given.extension() == ".h5");
  const fs::path file = is_file ? given : given / "dataset.h5";
  if (!fs::exists(file)) {
    if (fs::exists(RunFolder{.folder = given, .object = "", .run = ""}.events())) {
      const fs::path data = (given / "../.." / "x").lexically_normal().parent_path();
      throw Error(fmt::format("{}: a run; expected a dataset of runs, as in 'tactile heatmaps {}', or 'tactile view' for one run",
                              args.data, shell_word(data.empty() ? "." : data.string())));
    }
    throw Error(fmt::format("{}: no such dataset; expected one, run 'tactile windows{}' first", file.string(),
                            args.data == "data" ? "" : (is_file ? " DATA --out " : " ") + shell_word(args.data)));
  }
  std::vector<heatmaps::HeatmapOptions> histories;
  for (const microseconds history : args.histories) {
    heatmaps::HeatmapOptions options = args.rendering;
    options.history = history;
    histories.push_back(with_mask(options, args.mask));
    if (!args.pictures.empty()) check_heatmap_pictures(args.pictures, heatmaps::stored_name(histories.back()));
  }
  nlohmann::json result = {
      {"dataset", file.string()}, {"histories", nlohmann::json::array()}, {"pictures", 0}, {"warnings", nlohmann::json::array()}};
  std::vector<std::vector<std::string>> rows;
  {
    const windows::Dataset dataset(file);
    check_mask(args.mask, histories.front(), dataset.sensor());  // all histories have the same
    result["simulated"] = dataset.simulated();
    result["samples"] = dataset.samples().size();
    for (const auto& history : heatmaps::store_heatmaps(dataset, histories, common.threads, progress_line(common))) {
      const windows::StoredHeatmaps& stored = history.heatmaps;
      if (!history.warning.empty()) {
        spdlog::warn("{}", history.warning);
        result["warnings"].push_back(history.warning);
      }
      result["histories"].push_back(json_of(history));
      rows.push_back({stored.name, fmt::format("{} ms", stored.settings["history_us"].get<double>() / 1000),
                      fmt::format("{}x{}", stored.width, stored.height), std::to_string(dataset.samples().size()),
                      outcome_of(history)});
    }
  }
  std::string text = text_table({"history", "t_h", "size", "samples", ""}, rows);
  if (!args.pictures.empty()) {
    const windows::Dataset dataset(file);  // opened again, because it now lists the new heatmaps
    std::uint64_t pictures = 0;
    for (const heatmaps::HeatmapOptions& options : histories) {
      const auto stored = dataset.find_heatmaps(heatmaps::stored_name(options));
      if (!stored)
        throw Error(fmt::format("{}: history {} has disappeared; expected that no other program replaces the dataset",
                                file.string(), heatmaps::stored_name(options)));
      pictures += write_heatmap_pictures(dataset, *stored, args.pictures, common.threads, progress_line(common));
    }
    result["pictures"] = pictures;
    text += fmt::format("{} pictures in {}\n", pictures, args.pictures);
  }
  print_result(common, result, text);
}

}  // namespace

void add_heatmaps_command(CLI::App& app) {
  auto args = std::make_shared<HeatmapsArguments>();
  Command command = add_command(app, "heatmaps", "Render the heatmaps of a dataset's samples",
                                [args](const CommonArguments& common) { render_heatmaps(*args, common); });
  command.add_option("data", args->data, "Data folder with dataset.h5, or a dataset file").show_default();
  add_histories_option(command, args->histories, "Histories t_h [ms], each a whole number of ticks");
  add_field_options(command, args->rendering, {"th"});
  add_mask_option(command, args->mask);
  command.add_option("--png", args->pictures, "Also write each heatmap as a PNG file in this folder").type_name("DIR");
}

}  // namespace tactile::cli
