#include "model_arguments.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "tactile/windows/write_dataset.hpp"

namespace tactile {
namespace {

/// Forward and back, on a common core.
double common_images_per_s_and_thread(const ModelSettings& settings) {
  const bool fused = settings.training.engine == TrainingEngine::fast && settings.network == LeNetOptions{};
  return fused ? 1200 : 333;
}

}  // namespace

std::filesystem::path dataset_file(const std::string& data) {
  return std::filesystem::is_regular_file(data) ? std::filesystem::path(data) : std::filesystem::path(data) / "dataset.h5";
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
  const double rate = images_per_s.value_or(common_images_per_s_and_thread(settings) * threads);
  return fmt::format("{} samples, {} epochs, about {} (min:s)", samples, settings.training.epochs,
                     clock_text(static_cast<double>(samples) * settings.training.epochs / rate));
}

}  // namespace tactile
