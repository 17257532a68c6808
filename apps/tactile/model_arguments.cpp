#include "model_arguments.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <set>

#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "tactile/core/error.hpp"
#include "tactile/evaluation/confirmation.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile {
namespace {

/// Forward and back, on a common core.
double common_images_per_s_and_thread(const ModelSettings& settings) {
  const bool fused = settings.training.engine == EngineKind::fast && settings.network == LeNetOptions{};
  return fused ? 1200 : 333;
}

}  // namespace

std::filesystem::path dataset_file(const std::string& data) {
  return std::filesystem::is_regular_file(data) ? std::filesystem::path(data) : std::filesystem::path(data) / "dataset.h5";
}

CLI::Validator is_confirmation() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        try {
          confirmation_in(text);
          return "";
        } catch (const Error& e) {
          return e.what();
        }
      },
      "k/n");
}

bool make_missing_dataset(const std::string& data, const CommonArguments& common) {
  const std::filesystem::path file = dataset_file(data);
  if (std::filesystem::exists(file)) return false;
  spdlog::info("{} is missing: it is made by the defaults of 'tactile windows'", file.string());
  const DatasetSummary summary = write_dataset(data, file, {}, common.threads, progress_line(common));
  for (const std::string& warning : summary.warnings) spdlog::warn("{}", warning);
  for (const std::string& error : summary.errors) spdlog::error("{}", error);
  spdlog::info("{}: {} samples", file.string(), summary.samples);
  return true;
}

std::vector<std::string> objects_to_hold_out(const std::vector<std::string>& named, const Dataset& dataset) {
  if (!named.empty()) return named;
  std::set<std::string> objects;
  for (const DatasetRun& run : dataset.runs()) objects.insert(run.object);
  std::vector<std::string> held_out;
  for (const std::string& object : default_held_out()) {
    if (objects.contains(object)) held_out.push_back(object);
  }
  if (held_out.empty() || held_out.size() == objects.size()) {
    throw Error(fmt::format("{}: {} of its objects is among the paper's five to hold out; expected --held-out with some of {}",
                            dataset.file().string(), held_out.empty() ? "none" : "every one", fmt::join(objects, ", ")));
  }
  return held_out;
}

std::string training_estimate(const Dataset& dataset, const ModelSettings& settings, std::optional<double> images_per_s,
                              unsigned threads) {
  const std::size_t samples = samples_of_runs(dataset, split_of(dataset, settings.split).train_runs).size();
  const double rate = images_per_s.value_or(common_images_per_s_and_thread(settings) * threads);
  return fmt::format("{}, {}, about {} (min:s)", counted(samples, "sample"), counted(settings.training.epochs, "epoch"),
                     clock_text(static_cast<double>(samples) * settings.training.epochs / rate));
}

void add_engine_option(CLI::App& command, std::string& engine) {
  command
      .add_option("--engine", engine,
                  "What runs the network: fast, tactile's own, or libtorch, which knows every activation and pooling")
      ->check(one_of({"fast", "libtorch"}))
      ->capture_default_str();
}

}  // namespace tactile
