#include <fmt/core.h>

#include <span>
#include <string>
#include <vector>

#include "answer_each_line.hpp"
#include "measured_time.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/onnx_model.hpp"
#include "tactile/model/training/lenet.hpp"

// model_benchmark train|train-libtorch|infer THREADS IMAGES [SHARE]
//   For each line of standard input: trains with IMAGES heatmaps, or classifies them, and prints the heatmaps/s. A SHARE (0.2) of
//   the cells is active. train-libtorch uses the layers of libtorch.
// model_benchmark onnx FILE
//   Writes the network for other frameworks.
//
// benchmarks/model_peers.py compares it with the same network in other frameworks. As in `tactile train` and `eval`, a batch has
// 32 heatmaps and a call for inference 256.

namespace {

using namespace tactile;
using namespace tactile::bench;

constexpr events::SensorSize size{128, 96};
constexpr std::size_t batch = 32, call = 256;
constexpr std::size_t batches = 64;  // enough that the network cannot learn them by heart, which takes another time
constexpr std::size_t cells = 128 * 96;

std::vector<std::uint8_t> random_heatmaps(std::size_t count, double share) {
  Random random(1);
  std::vector<std::uint8_t> heatmaps(count * cells);
  for (std::uint8_t& cell : heatmaps)
    cell = random.below(1'000'000) < static_cast<std::uint64_t>(share * 1e6) ? static_cast<std::uint8_t>(random.below(256))
                                                                             : std::uint8_t{0};
  return heatmaps;
}

template <class Call>
void answer_with_rate(std::size_t images, std::size_t images_per_call, const Call& call) {
  call();  // the first call allocates memory and starts threads
  answer_each_line([&](const std::string&) {
    const double begin = wall_seconds();
    std::size_t done = 0;
    for (; done < images; done += images_per_call) call();
    return fmt::format("{:.3f}", static_cast<double>(done) / (wall_seconds() - begin));
  });
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc == 4 || argc == 5 ? argv[1] : "";
  if (argc == 3 && argv[1] == std::string("onnx")) {
    const model::LeNet network(size, 1);
    write_whole(argv[2], model::onnx_model(network.layers(), {}, network.weights(), "benchmark", {}));
    return 0;
  }
  if (what != "train" && what != "train-libtorch" && what != "infer") {
    fmt::print(stderr, "model_benchmark: expected train|train-libtorch|infer THREADS IMAGES [SHARE], or onnx FILE\n");
    return 1;
  }
  const auto threads = static_cast<unsigned>(std::stoul(argv[2]));
  const std::size_t images = std::stoul(argv[3]);
  const double share = argc == 5 ? std::stod(argv[4]) : 0.2;
  model::LeNet network(size, 1);
  if (what == "infer") {
    const auto heatmaps = random_heatmaps(call, share);
    answer_with_rate(images, call, [&] { network.logits(heatmaps, threads); });
    return 0;
  }
  const auto heatmaps = random_heatmaps(batches * batch, share);
  std::vector<Touch> truth(batches * batch);
  for (std::size_t i = 0; i < truth.size(); ++i) truth[i] = all_touches[i % touch_count];
  const auto engine = what == "train" ? model::EngineKind::fast : model::EngineKind::libtorch;
  model::LeNetTrainer trainer(network, model::OptimizerKind::adam, {1, 1, 1}, threads, {.engine = engine});
  std::size_t next = 0;
  answer_with_rate(images, batch, [&] {
    const std::size_t first = next++ % batches * batch;
    trainer.learn(std::span(heatmaps).subspan(first * cells, batch * cells), std::span(truth).subspan(first, batch), 1e-3);
  });
}
