#include "tactile/model/train_model.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/version.hpp"
#include "tactile/heatmaps/render_samples.hpp"

namespace tactile {
namespace {

std::string now_utc() {
  const auto now = std::chrono::time_point_cast<microseconds>(std::chrono::system_clock::now());
  const std::time_t second = std::chrono::system_clock::to_time_t(now);
  std::tm utc{};
  gmtime_r(&second, &utc);
  const auto fraction = now.time_since_epoch().count() % 1'000'000;
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
                     utc.tm_min, utc.tm_sec, fraction);
}

std::vector<std::string> names_of(const Dataset& dataset, std::span<const std::uint32_t> run_indexes) {
  std::vector<std::string> names;
  for (const std::uint32_t run : run_indexes) names.push_back(name_of(dataset.runs()[run]));
  return names;
}

}  // namespace

std::string name_of(const DatasetRun& run) { return run.object + "/" + run.run; }

Split split_of(const Dataset& dataset, const SplitOptions& options) {
  std::vector<RunName> names;
  for (const DatasetRun& run : dataset.runs()) names.push_back({run.object, run.run, false});
  for (const Sample& sample : dataset.samples()) names[sample.run_index].has_samples = true;
  return split_runs(names, options);
}

std::vector<std::uint32_t> samples_of_runs(const Dataset& dataset, std::span<const std::uint32_t> run_indexes) {
  std::vector<std::uint32_t> samples;
  for (std::uint32_t i = 0; i < dataset.samples().size(); ++i) {
    if (std::find(run_indexes.begin(), run_indexes.end(), dataset.samples()[i].run_index) != run_indexes.end())
      samples.push_back(i);
  }
  return samples;
}

std::vector<std::uint8_t> sample_heatmaps(const Dataset& dataset, const HeatmapOptions& options,
                                          std::span<const std::uint32_t> sample_indexes, unsigned threads,
                                          const ProgressCallback& progress) {
  const std::string name = stored_name(options);
  const auto stored = dataset.find_heatmaps(name);
  if (stored && stored->settings == nlohmann::json(options)) return dataset.read_heatmaps(name, sample_indexes);
  return render_samples(dataset, options, sample_indexes, threads, progress);
}

BundleState state_of(const ModelBundle& bundle, const Dataset& dataset, const ModelSettings& settings) {
  if (!std::filesystem::exists(bundle.folder)) return BundleState::missing;
  try {
    const ModelDescription description = read_description(bundle);
    read_bundle_weights(bundle, description);
    const bool same = description.manifest_hash == dataset.manifest_hash() && same_settings(description.settings, settings);
    return same ? BundleState::unchanged : BundleState::changed;
  } catch (const Error&) {
    return BundleState::changed;
  }
}

TrainingSummary train_model(const Dataset& dataset, const ModelSettings& settings, const ModelBundle& bundle, unsigned threads,
                            const ProgressCallback& progress) {
  check(settings.training);
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  const Split split = split_of(dataset, settings.split);
  const std::vector<std::uint32_t> samples = samples_of_runs(dataset, split.train_runs);
  std::vector<Touch> truth;
  for (const std::uint32_t sample : samples) truth.push_back(dataset.samples()[sample].touch);
  const SensorSize size = heatmap_size(dataset.sensor(), settings.rendering.factor);
  lenet_layers(size);  // too small a heatmap is told before any is rendered
  const auto heatmaps = sample_heatmaps(dataset, settings.rendering, samples, threads, progress);
  const TrainedNetwork trained = train_lenet(size, heatmaps, truth, settings.training, threads, progress);

  ModelDescription description;
  description.settings = settings;
  description.input = size;
  description.dataset = dataset.file().string();
  description.manifest_hash = dataset.manifest_hash();
  description.manifest = dataset.settings();
  description.simulated = dataset.simulated();
  description.train_runs = names_of(dataset, split.train_runs);
  description.test_runs = names_of(dataset, split.test_runs);
  description.samples = samples.size();
  description.threads = threads;
  description.trained_at = now_utc();
  description.version = version();
  description.revision = revision();
  write_bundle(bundle, description, trained.network.weights(), trained.summary);
  return trained.summary;
}

}  // namespace tactile
