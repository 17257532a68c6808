#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "tactile/evaluation/statistic.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/model/training/training.hpp"
#include "tactile/windows/dataset.hpp"

// precision_benchmark DATASET SEEDS EPOCHS THREADS
//   Measures the effect of rounding. With each seed a network is trained three times with the same samples in the same order: in
//   float32 by the fast engine and by libtorch, and in float64. Prints their accuracies on the test runs, and their differences
//   with 95 % intervals.

namespace {

using namespace tactile;

/// Numbers of samples of a run that were predicted correctly, and of all its samples.
struct RunCounts {
  double right = 0, all = 0;
};

struct Method {
  const char* name;
  model::EngineKind engine;
  bool float64;
};
constexpr std::array methods{Method{"float32, fast", model::EngineKind::fast, false},
                             Method{"float32, libtorch", model::EngineKind::libtorch, false},
                             Method{"float64", model::EngineKind::libtorch, true}};

std::vector<Touch> truth_of(const windows::Dataset& dataset, const std::vector<std::uint32_t>& samples) {
  std::vector<Touch> truth;
  for (const std::uint32_t sample : samples) truth.push_back(dataset.samples()[sample].touch);
  return truth;
}

std::string text_of(const results::Figure& figure) {
  if (!figure.low) return fmt::format("{:+.2f} | -", 100 * figure.value);
  return fmt::format("{:+.2f} | {:+.2f} to {:+.2f}", 100 * figure.value, 100 * *figure.low, 100 * *figure.high);
}

void measure(const windows::Dataset& dataset, unsigned seeds, unsigned epochs, unsigned threads) {
  model::ModelSettings settings;
  settings.training.epochs = epochs;
  const windows::Split split = model::split_of(dataset, settings.split);
  const auto training = model::samples_of_runs(dataset, split.train_runs),
             testing = model::samples_of_runs(dataset, split.test_runs);
  const auto training_maps = model::sample_heatmaps(dataset, settings.rendering, training, threads);
  const auto testing_maps = model::sample_heatmaps(dataset, settings.rendering, testing, threads);
  const auto training_truth = truth_of(dataset, training), testing_truth = truth_of(dataset, testing);

  std::map<std::string, std::vector<std::size_t>> runs_of_objects;
  for (const std::uint32_t run : split.test_runs) runs_of_objects[dataset.runs()[run].object].push_back(run);
  evaluation::RunsByObject runs;
  for (const auto& [object, its_runs] : runs_of_objects) runs.push_back(its_runs);

  // Of each method and seed; the last element is the sum over all seeds.
  std::vector<std::vector<std::vector<RunCounts>>> counts(
      methods.size(), std::vector<std::vector<RunCounts>>(seeds + 1, std::vector<RunCounts>(dataset.runs().size())));
  fmt::print("| seed |");
  for (const Method& method : methods) fmt::print(" {}: loss | accuracy [%] |", method.name);
  fmt::print("\n| ---: |");
  for (std::size_t i = 0; i < 2 * methods.size(); ++i) fmt::print(" ---: |");
  fmt::print("\n");
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    fmt::print("| {} |", seed);
    for (std::size_t method = 0; method < methods.size(); ++method) {
      settings.training.seed = seed;
      settings.training.engine = methods[method].engine;
      const auto trained = model::train_lenet({.size = heatmaps::heatmap_size(dataset.sensor(), settings.rendering.factor),
                                               .training = {training_maps, training_truth},
                                               .options = settings.training,
                                               .threads = threads,
                                               .float64 = methods[method].float64});
      const auto logits = trained.network.logits(testing_maps, threads);
      double right = 0;
      for (std::size_t i = 0; i < logits.size(); ++i) {
        const double hit = model::verdict_of(logits[i]) == testing_truth[i] ? 1 : 0;
        right += hit;
        for (const std::size_t place : {std::size_t{seed} - 1, std::size_t{seeds}}) {
          RunCounts& of_run = counts[method][place][dataset.samples()[testing[i]].run_index];
          of_run.right += hit;
          of_run.all += 1;
        }
      }
      fmt::print(" {:.6f} | {:.2f} |", trained.summary.history.back().loss, 100 * right / static_cast<double>(logits.size()));
      std::fflush(stdout);
    }
    fmt::print("\n");
  }

  const auto accuracy = [&](std::size_t method, std::size_t place, std::span<const std::size_t> of_runs) {
    RunCounts sum;
    for (const std::size_t run : of_runs) {
      sum.right += counts[method][place][run].right;
      sum.all += counts[method][place][run].all;
    }
    return sum.all > 0 ? std::optional(sum.right / sum.all) : std::nullopt;
  };
  const auto difference = [&](std::size_t method, std::size_t place, std::size_t other_method, std::size_t other_place) {
    return evaluation::figure_over_objects(
        runs, evaluation::mean_over_objects([&](std::span<const std::size_t> of_runs) -> std::optional<double> {
          const auto ours = accuracy(method, place, of_runs), theirs = accuracy(other_method, other_place, of_runs);
          return ours && theirs ? std::optional(*ours - *theirs) : std::nullopt;
        }));
  };
  fmt::print("\n| accuracy, mean over {} objects, difference [%] | | 95 % |\n| --- | ---: | ---: |\n", runs.size());
  for (std::size_t method = 0; method + 1 < methods.size(); ++method)
    fmt::print("| {} minus float64, {} seeds together | {} |\n", methods[method].name, seeds,
               text_of(difference(method, seeds, methods.size() - 1, seeds)));
  if (seeds > 1)
    fmt::print("| float64, seed 1 minus seed 2 | {} |\n", text_of(difference(methods.size() - 1, 0, methods.size() - 1, 1)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    fmt::print(stderr, "precision_benchmark: expected DATASET SEEDS EPOCHS THREADS\n");
    return 1;
  }
  try {
    const auto number = [&](int i) { return static_cast<unsigned>(std::stoul(argv[i])); };
    measure(windows::Dataset(argv[1]), number(2), number(3), number(4));
  } catch (const std::exception& error) {
    fmt::print(stderr, "precision_benchmark: {}\n", error.what());
    return 1;
  }
  return 0;
}
