#include "model_arguments.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "option_checks.hpp"
#include "tactile/core/error.hpp"
#include "tactile/evaluation/confirmation.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile {
namespace {

constexpr double common_images_per_s_and_thread = 333;  // 3 ms for each, forward and back

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
  spdlog::info("{}: {} samples", file.string(), summary.samples);
  return true;
}

std::string training_estimate(const Dataset& dataset, const ModelSettings& settings, std::optional<double> images_per_s,
                              unsigned threads) {
  const std::size_t samples = samples_of_runs(dataset, split_of(dataset, settings.split).train_runs).size();
  const double rate = images_per_s.value_or(common_images_per_s_and_thread * threads);
  return fmt::format("{} samples, {} epochs, about {} (min:s)", samples, settings.training.epochs,
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
