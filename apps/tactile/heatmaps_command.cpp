#include <fmt/core.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "option_checks.hpp"
#include "rendering_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

struct HeatmapsArguments {
  std::string data = "data";
  std::vector<double> histories_ms{2, 10, 20, 30, 40, 50};
  RenderingArguments rendering;
  std::string pictures;
};

/// Whole or not at all, but not synced one by one: thousands of pictures that are easily made again.
void write_picture(const fs::path& file, const cv::Mat& picture) {
  const fs::path part = file.parent_path() / ("." + file.filename().string() + ".part");
  std::vector<unsigned char> bytes;
  cv::imencode(".png", picture, bytes);
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);
  std::ofstream out(part, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out) fs::rename(part, file, failed);
  if (!out || failed) throw Error(file.string() + ": cannot be written; expected a writable place with room");
}

/// One PNG a sample, its pixels the heatmap's own: DIR/th_040/<object>/<run>/<t_us>-<class>.png.
std::uint64_t write_pictures(const Dataset& dataset, const StoredHeatmaps& stored, const fs::path& folder,
                             const ProgressCallback& progress) {
  const std::span<const Sample> samples = dataset.samples();
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    std::vector<std::uint8_t> heatmap = dataset.read_heatmaps(stored.name, std::span(&i, 1));
    const DatasetRun& run = dataset.runs()[samples[i].run_index];
    const std::string name = fmt::format("{}-{}.png", us_of(samples[i].t), name_of(samples[i].touch));
    write_picture(folder / stored.name / run.object / run.run / name,
                  cv::Mat(stored.height, stored.width, CV_8UC1, heatmap.data()));
    tell(progress, i + 1, samples.size(), "pictures of " + stored.name);
  }
  return samples.size();
}

void render_heatmaps(const HeatmapsArguments& args, const CommonArguments& common) {
  const fs::path file = fs::is_regular_file(args.data) ? fs::path(args.data) : fs::path(args.data) / "dataset.h5";
  if (!fs::exists(file)) {
    throw Error(fmt::format("{}: no such dataset; expected one, run 'tactile windows{}' first", file.string(),
                            args.data == "data" ? "" : " " + args.data));
  }
  std::vector<HeatmapOptions> histories;
  for (const double history_ms : args.histories_ms) {
    histories.push_back(heatmap_options(history_ms, args.rendering));
  }
  nlohmann::json result = {{"dataset", file.string()}, {"histories", nlohmann::json::array()}, {"pictures", 0}};
  std::vector<std::vector<std::string>> rows;
  {
    const Dataset dataset(file);
    result["simulated"] = dataset.simulated();
    result["samples"] = dataset.samples().size();
    for (const auto& [stored, kept] : store_heatmaps(dataset, histories, common.threads, progress_line(common))) {
      result["histories"].push_back({{"name", stored.name},
                                     {"outcome", kept ? "unchanged" : "written"},
                                     {"settings", stored.settings},
                                     {"width", stored.width},
                                     {"height", stored.height}});
      rows.push_back({stored.name, fmt::format("{} ms", stored.settings["history_us"].get<double>() / 1000),
                      fmt::format("{}x{}", stored.width, stored.height), std::to_string(dataset.samples().size()),
                      kept ? "unchanged" : "written"});
    }
  }
  std::string text = text_table({"history", "t_h", "size", "samples", ""}, rows);
  if (!args.pictures.empty()) {
    const Dataset dataset(file);  // opened again: it lists what was rendered now
    std::uint64_t pictures = 0;
    for (const HeatmapOptions& options : histories) {
      const auto stored = dataset.find_heatmaps(stored_name(options));
      if (!stored)
        throw Error(fmt::format("{}: history {} is gone again; expected nobody to replace the dataset meanwhile", file.string(),
                                stored_name(options)));
      pictures += write_pictures(dataset, *stored, args.pictures, progress_line(common));
    }
    result["pictures"] = pictures;
    text += fmt::format("{} pictures in {}\n", pictures, args.pictures);
  }
  print_result(common, result, text);
}

}  // namespace

void add_heatmaps_command(CLI::App& app) {
  auto args = std::make_shared<HeatmapsArguments>();
  CLI::App* command = add_command(app, "heatmaps", "Render the heatmaps of a dataset's samples",
                                  [args](const CommonArguments& common) { render_heatmaps(*args, common); });
  command->add_option("data", args->data, "Folder whose dataset.h5 is meant, or a dataset")->capture_default_str();
  command->add_option("--th", args->histories_ms, "Histories t_h [ms], a list with commas; each a whole number of ticks")
      ->delimiter(',')
      ->check(in_range(0.001, 1e5))
      ->capture_default_str();
  add_rendering_options(*command, args->rendering);
  command->add_option("--png", args->pictures, "Also write each heatmap as a PNG below this folder")->type_name("DIR");
}

}  // namespace tactile
