#include <cmath>

#include "tactile/core/random.hpp"
#include "tactile/recipes/step.hpp"

namespace tactile::recipes {
namespace {

using events::Event;

/// A pixel's events between two changes of polarity are one change of its brightness, in steps of the old threshold. The new
/// threshold divides that change. What is left of a step at the start is drawn, so that n events become n / factor in the mean.
class ScaledThreshold {
 public:
  ScaledThreshold(double factor, events::SensorSize size, std::uint64_t seed)
      : factor_(factor),
        width_(static_cast<std::size_t>(size.width)),
        pixels_(width_ * static_cast<std::size_t>(size.height)),
        random_(seed) {}

  void operator()(const Event& event, std::vector<Event>& out) {
    Pixel& pixel = pixels_[static_cast<std::size_t>(event.y) * width_ + static_cast<std::size_t>(event.x)];
    const Direction direction = event.on != 0 ? Direction::brighter : Direction::darker;
    if (pixel.direction != direction) {
      pixel.direction = direction;
      pixel.rest = static_cast<float>(factor_ * random_.uniform());
    }
    double change = static_cast<double>(pixel.rest) + 1;
    for (; change >= factor_; change -= factor_) out.push_back(event);
    pixel.rest = static_cast<float>(change);
  }

 private:
  enum class Direction : std::uint8_t { unknown, brighter, darker };
  struct Pixel {
    float rest = 0;  ///< of the change that has not given an event yet, in old thresholds, in [0, factor)
    Direction direction = Direction::unknown;
  };

  double factor_;
  std::size_t width_;
  std::vector<Pixel> pixels_;
  Random random_;
};

}  // namespace

std::unique_ptr<Step> make_polarity(const StepInput& input) {
  return event_step(
      [random = Random(input.seed), share = input.recipe.severity / 100](Event event, std::vector<Event>& out) mutable {
        if (random.uniform() < share) event.on = event.on != 0 ? 0 : 1;
        out.push_back(event);
      });
}

std::unique_ptr<Step> make_threshold(const StepInput& input) {
  return event_step(ScaledThreshold(1 + input.recipe.severity / 100, input.size, input.seed));
}

}  // namespace tactile::recipes
