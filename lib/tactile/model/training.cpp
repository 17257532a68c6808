#include "tactile/model/training.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/random.hpp"

namespace tactile {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

void check_samples(std::size_t heatmap_bytes, std::size_t cells, std::span<const Touch> truth) {
  if (truth.empty() || heatmap_bytes != truth.size() * cells) {
    throw Error(fmt::format("training: {} bytes of heatmaps for {} samples; expected at least one sample and {} bytes for each",
                            heatmap_bytes, truth.size(), cells));
  }
  for (const Touch touch : all_touches) {
    if (std::find(truth.begin(), truth.end(), touch) == truth.end()) {
      throw Error(fmt::format("training: no sample of '{}'; expected samples of none, press and slip", name_of(touch)));
    }
  }
}

/// The order of an epoch depends on the seed and the epoch alone.
std::vector<std::uint32_t> shuffled(std::size_t count, std::uint64_t seed, unsigned epoch) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  Random random(seed_for(seed, {"order of samples", std::to_string(epoch)}));
  random.shuffle(order);
  return order;
}

}  // namespace

void to_json(nlohmann::json& json, const TrainingOptions& options) {
  json = {{"seed", options.seed}, {"epochs", options.epochs}, {"batch", options.batch}, {"learning_rate", options.learning_rate}};
}

void from_json(const nlohmann::json& json, TrainingOptions& options) {
  options.seed = member<std::uint64_t>(json, "seed", "training settings");
  options.epochs = member<unsigned>(json, "epochs", "training settings");
  options.batch = member<unsigned>(json, "batch", "training settings");
  options.learning_rate = member<double>(json, "learning_rate", "training settings");
}

void check(const TrainingOptions& options) {
  if (options.epochs == 0 || options.batch == 0) {
    throw Error(fmt::format("training: {} epochs in batches of {}; expected at least 1 of each", options.epochs, options.batch));
  }
  if (!(options.learning_rate > 0) || !std::isfinite(options.learning_rate)) {
    throw Error(fmt::format("training: a learning rate of {}; expected more than 0", options.learning_rate));
  }
}

TrainedNetwork train_lenet(SensorSize size, std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth,
                           const TrainingOptions& options, unsigned threads, const ProgressCallback& progress) {
  check(options);
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  TrainedNetwork trained{LeNet(size, options.seed), {}};
  const std::size_t cells = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  check_samples(heatmaps.size(), cells, truth);
  const auto begun = Clock::now();
  trained.summary.samples = truth.size();
  LeNetTrainer trainer(trained.network, options.learning_rate, threads);
  std::vector<std::uint8_t> batch_heatmaps;
  std::vector<Touch> batch_truth;
  for (unsigned epoch = 1; epoch <= options.epochs; ++epoch) {
    const auto epoch_begun = Clock::now();
    const auto order = shuffled(truth.size(), options.seed, epoch);
    double loss = 0;
    std::size_t correct = 0, done = 0;
    while (done < order.size()) {
      const std::size_t count = std::min<std::size_t>(options.batch, order.size() - done);
      batch_heatmaps.resize(count * cells);
      batch_truth.resize(count);
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t sample = order[done + i];
        std::copy_n(heatmaps.begin() + static_cast<std::ptrdiff_t>(sample * cells), cells,
                    batch_heatmaps.begin() + static_cast<std::ptrdiff_t>(i * cells));
        batch_truth[i] = truth[sample];
      }
      const BatchResult result = trainer.learn(batch_heatmaps, batch_truth);
      if (!std::isfinite(result.loss)) {
        throw Error(fmt::format(
            "training: the loss is {} in epoch {}, behind {} samples; expected a finite one (try a smaller --lr than {})",
            result.loss, epoch, done, options.learning_rate));
      }
      loss += result.loss * static_cast<double>(count);
      correct += result.correct;
      done += count;
      const auto seen = static_cast<double>(done);
      tell(progress, (epoch - 1) * truth.size() + done, options.epochs * truth.size(),
           fmt::format("epoch {}/{}: loss {:.4f}, accuracy {:.1f} %, {:.0f} images/s", epoch, options.epochs, loss / seen,
                       100.0 * static_cast<double>(correct) / seen, seen / seconds_since(epoch_begun)));
    }
    const double seconds = seconds_since(epoch_begun);
    const auto samples = static_cast<double>(truth.size());
    trained.summary.history.push_back(
        {epoch, loss / samples, static_cast<double>(correct) / samples, samples / seconds, seconds});
  }
  check_finite(trained.network.weights(), "training");
  trained.summary.seconds = seconds_since(begun);
  return trained;
}

}  // namespace tactile
