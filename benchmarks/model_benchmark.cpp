#include <fmt/core.h>

#include <chrono>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/onnx_model.hpp"
#include "tactile/model/training/lenet.hpp"

// model_benchmark train|train-libtorch|infer THREADS IMAGES [SHARE]: for each line that comes, learns from or judges IMAGES
// heatmaps, a SHARE [0.2] of whose cells is active, and prints how many a second that were. train-libtorch: by its layers.
// benchmarks/model_peers.py runs it beside the same network in other frameworks. model_benchmark onnx FILE: writes that network
// for them.
//
// As in `tactile train` and `eval`: batches of 32 to learn from, 256 to a call to judge.

namespace {

using namespace tactile;
using Clock = std::chrono::steady_clock;

constexpr SensorSize size{128, 96};
constexpr std::size_t batch = 32, call = 256;
constexpr std::size_t batches =
    64;  // so many different ones that a run does not learn them by heart, which is work of another kind
constexpr std::size_t cells = 128 * 96;

std::vector<std::uint8_t> heatmaps_at_random(std::size_t count, double share) {
  Random random(1);
  std::vector<std::uint8_t> heatmaps(count * cells);
  for (std::uint8_t& cell : heatmaps)
    cell = random.below(1'000'000) < static_cast<std::uint64_t>(share * 1e6) ? static_cast<std::uint8_t>(random.below(256))
                                                                             : std::uint8_t{0};
  return heatmaps;
}

template <class Work>
void answer_each_line(std::size_t images, std::size_t at_once, const Work& work) {
  work();  // memory is allocated, threads are made
  fmt::print("ready\n");
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    const auto begun = Clock::now();
    std::size_t done = 0;
    for (; done < images; done += at_once) work();
    fmt::print("{:.3f}\n", static_cast<double>(done) / std::chrono::duration<double>(Clock::now() - begun).count());
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc == 4 || argc == 5 ? argv[1] : "";
  if (argc == 3 && argv[1] == std::string("onnx")) {
    const LeNet network(size, 1);
    write_whole(argv[2], onnx_model(network.layers(), {}, network.weights(), "benchmark", {}));
    return 0;
  }
  if (what != "train" && what != "train-libtorch" && what != "infer") {
    fmt::print(stderr, "model_benchmark: expected train|train-libtorch|infer THREADS IMAGES [SHARE], or onnx FILE\n");
    return 1;
  }
  const auto threads = static_cast<unsigned>(std::stoul(argv[2]));
  const std::size_t images = std::stoul(argv[3]);
  const double share = argc == 5 ? std::stod(argv[4]) : 0.2;
  LeNet network(size, 1);
  if (what == "infer") {
    const auto heatmaps = heatmaps_at_random(call, share);
    answer_each_line(images, call, [&] { network.logits(heatmaps, threads); });
    return 0;
  }
  const auto heatmaps = heatmaps_at_random(batches * batch, share);
  std::vector<Touch> truth(batches * batch);
  for (std::size_t i = 0; i < truth.size(); ++i) truth[i] = all_touches[i % touch_count];
  const auto engine = what == "train" ? EngineKind::fast : EngineKind::libtorch;
  LeNetTrainer trainer(network, OptimizerKind::adam, {1, 1, 1}, threads, {.engine = engine});
  std::size_t next = 0;
  answer_each_line(images, batch, [&] {
    const std::size_t first = next++ % batches * batch;
    trainer.learn(std::span(heatmaps).subspan(first * cells, batch * cells), std::span(truth).subspan(first, batch), 1e-3);
  });
}
