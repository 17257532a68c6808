#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "tactile/evaluation/accuracy.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/model/training/training.hpp"
#include "tactile/windows/dataset.hpp"

// precision_benchmark DATASET SEEDS EPOCHS THREADS
//   Measures the effect of rounding. With each seed a network is trained three times with the same samples in the same order: in
//   float32 by the fast engine and by libtorch, and in float64. Prints their accuracies on the test runs, and their differences
//   with 95 % intervals.

namespace {

using namespace tactile;

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

  std::vector<std::vector<results::Cell>> judged(methods.size());  // of each method: the runs of each seed
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
      std::map<std::uint32_t, results::Cell> of_seed;
      for (const std::uint32_t run : split.test_runs) {
        results::Cell& cell = of_seed[run];
        cell.object = dataset.runs()[run].object;
        cell.run = dataset.runs()[run].run;
        cell.training = seed - 1;
      }
      results::Confusion all;
      for (std::size_t i = 0; i < logits.size(); ++i) {
        const Touch predicted = model::verdict_of(logits[i]);
        all.add(testing_truth[i], predicted);
        of_seed.at(dataset.samples()[testing[i]].run_index).samples.add(testing_truth[i], predicted);
      }
      for (const auto& [run, cell] : of_seed) judged[method].push_back(cell);
      fmt::print(" {:.6f} | {:.2f} |", trained.summary.history.back().loss, 100 * all.accuracy().value_or(0));
      std::fflush(stdout);
    }
    fmt::print("\n");
  }

  const auto of_seed = [&](unsigned seed) {
    std::vector<results::Cell> runs;
    for (const results::Cell& run : judged.back()) {
      if (run.training == seed) runs.push_back(run);
    }
    for (results::Cell& run : runs) run.training = 0;
    return runs;
  };
  fmt::print("\n| accuracy, mean over objects, difference [%] | | 95 % |\n| --- | ---: | ---: |\n");
  for (std::size_t method = 0; method + 1 < methods.size(); ++method)
    fmt::print("| {} minus float64, {} seeds together | {} |\n", methods[method].name, seeds,
               text_of(evaluation::accuracy_difference(judged.back(), judged[method]).mean));
  if (seeds > 1)
    fmt::print("| float64, seed 1 minus seed 2 | {} |\n", text_of(evaluation::accuracy_difference(of_seed(1), of_seed(0)).mean));
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
