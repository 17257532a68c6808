#include "tactile/model/training/training.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/model/training/augmentation.hpp"

namespace tactile::model {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

std::size_t cells_of(events::SensorSize size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

void check_samples(const TrainingTask& task) {
  const auto& [heatmaps, truth] = task.training;
  const std::size_t cells = cells_of(task.size);
  if (truth.empty() || heatmaps.size() != truth.size() * cells) {
    throw Error(fmt::format("training: {} bytes of heatmaps for {} samples; expected at least one sample and {} bytes for each",
                            heatmaps.size(), truth.size(), cells));
  }
  for (const Touch touch : all_touches) {
    if (std::find(truth.begin(), truth.end(), touch) == truth.end()) {
      throw Error(fmt::format("training: no sample of '{}'; expected samples of none, press and slip", name_of(touch)));
    }
  }
  const LabelledHeatmaps& validation = task.validation;
  if (validation.heatmaps.size() != validation.truth.size() * cells) {
    throw Error(fmt::format("training: {} bytes of heatmaps for {} validation samples; expected {} bytes for each",
                            validation.heatmaps.size(), validation.truth.size(), cells));
  }
  if (task.options.early_stop > 0 && validation.truth.empty()) {
    throw Error(
        "training: the validation part for early stop has no sample; expected a larger validation part, or no early stop");
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

LeNet first_network(const TrainingTask& task, const TrainingState* resumed) {
  if (resumed != nullptr) return {task.size, resumed->weights, task.network};
  if (task.from != nullptr) return {task.size, *task.from, task.network};
  return {task.size, task.options.seed, task.network};
}

/// A running training.
class Training {
 public:
  Training(const TrainingTask& task, const TrainingControl& control, unsigned threads)
      : task_(task),
        control_(control),
        threads_(threads),
        cells_(cells_of(task.size)),
        network_(first_network(task, control.resumed)),
        class_weights_(weights_of_classes(task.options.class_weights, task.training.truth)),
        trainer_(network_, task.options.optimizer, class_weights_, threads, {task.options.engine, task.float64}) {
    if (control.resumed != nullptr) resume(*control.resumed);
  }

  TrainedNetwork run() {
    while (state_.epoch <= task_.options.epochs && !stops_early()) run_epoch();
    TrainingSummary summary{.history = state_.history,
                            .samples = samples(),
                            .validation_samples = task_.validation.truth.size(),
                            .seconds = state_.seconds,
                            .best_epoch = state_.best ? state_.best->epoch : 0,
                            .stopped_early = state_.epoch <= task_.options.epochs};
    const bool best_is_last = state_.best && state_.best->epoch + 1 == state_.epoch;
    if (best_is_last || !state_.best) return {std::move(network_), {}, std::move(summary)};
    if (task_.options.early_stop == 0) return {std::move(network_), std::move(state_.best->weights), std::move(summary)};
    return {LeNet(task_.size, state_.best->weights, task_.network), network_.weights(), std::move(summary)};
  }

 private:
  std::size_t samples() const { return task_.training.truth.size(); }

  void resume(const TrainingState& resumed) {
    if (resumed.epoch == 0 || resumed.epoch > task_.options.epochs + 1 || resumed.done >= samples() ||
        resumed.history.size() + 1 != resumed.epoch) {
      throw Error("training: the state to resume belongs to another training; expected a state saved by this one");
    }
    state_ = resumed;
    if (resumed.optimizer.step > 0) trainer_.restore(resumed.optimizer);
  }

  bool stops_early() const {
    return task_.options.early_stop > 0 && state_.best && state_.epoch > state_.best->epoch + task_.options.early_stop;
  }

  void run_epoch() {
    const auto order = shuffled(samples(), task_.options.seed, state_.epoch);
    const auto prepared = Clock::now();
    training_heatmaps_ = task_.heatmaps_of_epoch ? task_.heatmaps_of_epoch(state_.epoch) : task_.training.heatmaps;
    state_.epoch_seconds += seconds_since(prepared);
    state_.seconds += seconds_since(prepared);
    for (const unsigned epoch = state_.epoch; state_.epoch == epoch; report()) {
      const auto begun = Clock::now();
      const std::size_t count = std::min<std::size_t>(task_.options.batch, order.size() - state_.done);
      learn(std::span(order).subspan(state_.done, count));
      const double seconds = seconds_since(begun);
      state_.epoch_seconds += seconds;
      state_.seconds += seconds;
      if (state_.done == order.size()) end_epoch();
    }
  }

  void learn(std::span<const std::uint32_t> batch) {
    heatmaps_.resize(batch.size() * cells_);
    truth_.resize(batch.size());
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const auto heatmap = std::span(heatmaps_).subspan(i * cells_, cells_);
      std::copy_n(training_heatmaps_.begin() + static_cast<std::ptrdiff_t>(batch[i] * cells_), cells_, heatmap.begin());
      truth_[i] = task_.training.truth[batch[i]];
      if (!task_.options.augmentation.flip && !task_.options.augmentation.shift) continue;
      Random random(seed_for(task_.options.seed, {"augmentation", std::to_string(state_.epoch), std::to_string(batch[i])}));
      augment(heatmap, task_.size, task_.options.augmentation, random);
    }
    const std::uint64_t steps_an_epoch = (samples() + task_.options.batch - 1) / task_.options.batch;
    const std::uint64_t step = (state_.epoch - 1) * steps_an_epoch + state_.done / task_.options.batch;
    learning_rate_ = learning_rate_at(task_.options, step, steps_an_epoch * task_.options.epochs);
    const BatchResult result = trainer_.learn(heatmaps_, truth_, learning_rate_);
    if (!result.moved) throw_diverged(result);
    state_.loss += result.loss * result.weight;
    state_.weight += result.weight;
    state_.correct += result.correct;
    state_.gradient_norm = std::max(state_.gradient_norm, result.gradient_norm);
    state_.done += batch.size();
  }

  std::string where() const { return fmt::format("in epoch {}, after {} samples", state_.epoch, state_.done); }
  std::string advice() const { return fmt::format("(try a smaller --lr than {})", task_.options.learning_rate); }

  [[noreturn]] void throw_diverged(const BatchResult& result) const {
    if (!std::isfinite(result.loss))
      throw Error(fmt::format("training: the loss is {} {}; expected a finite one {}", result.loss, where(), advice()));
    throw Error(fmt::format("training: the gradient's norm is {:.3g} {}; expected at most {:.0e} {}", result.gradient_norm,
                            where(), largest_gradient_norm, advice()));
  }

  /// The result of `work`, which throws if a step made the weights too large.
  template <class Work>
  auto unless_diverged(const Work& work) const {
    try {
      return work();
    } catch (const Error& e) {
      throw Error(fmt::format("training: {}, {} {}", e.what(), where(), advice()));
    }
  }

  Weights finite_weights() const {
    return unless_diverged([this] {
      Weights weights = network_.weights();
      check_finite(weights, "weights");
      return weights;
    });
  }

  void end_epoch() {
    EpochResult epoch{.epoch = state_.epoch,
                      .loss = state_.loss / state_.weight,
                      .accuracy = static_cast<double>(state_.correct) / static_cast<double>(samples()),
                      .validation_loss = std::nullopt,
                      .validation_accuracy = std::nullopt,
                      .learning_rate = learning_rate_,
                      .gradient_norm = state_.gradient_norm};
    const auto begun = Clock::now();
    const Weights weights = finite_weights();
    if (!task_.validation.truth.empty()) judge(epoch);
    const double seconds = seconds_since(begun);
    state_.seconds += seconds;
    epoch.images_per_s = static_cast<double>(samples()) / state_.epoch_seconds;
    epoch.seconds = state_.epoch_seconds + seconds;
    const double judged_by = epoch.validation_loss.value_or(epoch.loss);
    if (!state_.best || judged_by < state_.best->loss) state_.best = BestEpoch{epoch.epoch, judged_by, weights};
    state_.history.push_back(epoch);
    ++state_.epoch;
    state_.done = state_.correct = 0;
    state_.loss = state_.weight = state_.gradient_norm = state_.epoch_seconds = 0;
  }

  /// Evaluates the validation part with the weights at the end of the epoch. Samples are weighted as in training.
  void judge(EpochResult& epoch) const {
    const auto logits = unless_diverged([this] { return network_.logits(task_.validation.heatmaps, threads_); });
    double loss = 0, weight = 0, correct = 0;
    for (std::size_t i = 0; i < logits.size(); ++i) {
      const auto truth = static_cast<std::size_t>(task_.validation.truth[i]);
      const auto largest = static_cast<double>(*std::max_element(logits[i].begin(), logits[i].end()));
      double sum = 0;
      for (const float logit : logits[i]) sum += std::exp(static_cast<double>(logit) - largest);
      loss += class_weights_[truth] * (std::log(sum) + largest - static_cast<double>(logits[i][truth]));
      weight += class_weights_[truth];
      correct += verdict_of(logits[i]) == task_.validation.truth[i] ? 1 : 0;
    }
    epoch.validation_loss = loss / weight;
    epoch.validation_accuracy = correct / static_cast<double>(logits.size());
  }

  void report() {
    if (state_.done == 0 || seconds_since(saved_) >= control_.save_every.count()) save();
    const std::uint64_t done = (state_.epoch - 1) * samples() + state_.done;
    const bool between_epochs = state_.done == 0;
    const EpochResult last = between_epochs ? state_.history.back() : EpochResult{};
    const auto seen = static_cast<double>(state_.done);
    std::string text =
        fmt::format("epoch {}/{}: loss {:.4f}, accuracy {:.1f} %, {:.0f} images/s", between_epochs ? last.epoch : state_.epoch,
                    task_.options.epochs, between_epochs ? last.loss : state_.loss / state_.weight,
                    100 * (between_epochs ? last.accuracy : static_cast<double>(state_.correct) / seen),
                    between_epochs ? last.images_per_s : seen / state_.epoch_seconds);
    if (last.validation_accuracy) text += fmt::format(", validation {:.1f} %", 100 * *last.validation_accuracy);
    try {
      report_progress(control_.progress, done, std::uint64_t{task_.options.epochs} * samples(), text);
    } catch (...) {
      if (state_.done > 0) save();
      throw;
    }
  }

  /// Keeps the last saved state if the weights are not finite.
  void save() {
    if (!control_.save) return;
    state_.weights = finite_weights();
    state_.optimizer = trainer_.state();
    control_.save(state_);
    saved_ = Clock::now();
  }

  const TrainingTask& task_;
  const TrainingControl& control_;
  unsigned threads_;
  std::size_t cells_;
  LeNet network_;
  std::array<double, touch_count> class_weights_;
  LeNetTrainer trainer_;
  TrainingState state_;
  double learning_rate_ = 0;
  Clock::time_point saved_ = Clock::now();
  std::span<const std::uint8_t> training_heatmaps_;  ///< of this epoch
  std::vector<std::uint8_t> heatmaps_;
  std::vector<Touch> truth_;
};

}  // namespace

std::array<double, touch_count> weights_of_classes(const ClassWeights& weights, std::span<const Touch> truth) {
  if (!weights.balanced) return weights.given;
  std::array<double, touch_count> balanced{};
  for (const Touch touch : all_touches) {
    const auto count = std::count(truth.begin(), truth.end(), touch);
    if (count == 0)
      throw Error(fmt::format("class weights: no sample of '{}' to balance; expected some of each class", name_of(touch)));
    balanced[static_cast<std::size_t>(touch)] =
        static_cast<double>(truth.size()) / (static_cast<double>(touch_count) * static_cast<double>(count));
  }
  return balanced;
}

TrainedNetwork train_lenet(const TrainingTask& task, const TrainingControl& control) {
  check(task.options);
  lenet_layers(task.size);
  check_samples(task);
  return Training(task, control, threads_or_all(task.threads)).run();
}

}  // namespace tactile::model
