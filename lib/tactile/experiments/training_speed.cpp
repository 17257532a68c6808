#include "tactile/experiments/training_speed.hpp"

#include <cstdint>
#include <ctime>
#include <optional>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/model/training/training.hpp"

namespace tactile::experiments {
namespace {

/// Thrown by a progress callback: enough was measured.
struct Measured {};

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

double measured_training_speed(model::EngineKind engine) {
  constexpr std::size_t images = 96, cells = std::size_t{128} * 96;
  constexpr double wanted_s = 1;
  Random random(1);
  std::vector<std::uint8_t> heatmaps(images * cells);
  // A quarter of the cells have events, as in a press.
  for (std::uint8_t& cell : heatmaps) cell = random.below(4) == 0 ? static_cast<std::uint8_t>(random.below(256)) : 0;
  std::vector<Touch> truth;
  for (std::size_t i = 0; i < images; ++i) truth.push_back(static_cast<Touch>(i % touch_count));

  // The first batch also allocates: it is not counted.
  std::optional<Progress> first, last;
  double begun = 0, ended = 0;
  const auto watch = [&](const Progress& progress) {
    const double now = processor_seconds();
    if (!first) first = progress, begun = now;
    last = progress, ended = now;
    if (ended - begun >= wanted_s) throw Measured{};
  };
  try {
    // So small a learning rate changes nothing: noise cannot be learned.
    model::train_lenet({.size = {128, 96},
                        .training = {heatmaps, truth},
                        .options = {.epochs = 1000, .learning_rate = 1e-9, .engine = engine},
                        .threads = 1},
                       {.progress = watch});
  } catch (const Measured&) {
  }
  return static_cast<double>(last->done - first->done) / (ended - begun);
}

}  // namespace tactile::experiments
