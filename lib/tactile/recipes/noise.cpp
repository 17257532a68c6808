#include <fmt/core.h>

#include <optional>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/recipes/added_events.hpp"
#include "tactile/simulation/background_noise.hpp"
#include "tactile/simulation/camera_pixels.hpp"

namespace tactile::recipes {
namespace {

constexpr double most_hz_per_pixel = 500;  ///< a tenth of the read-outs, so that a pixel seldom waits for the next one
constexpr microseconds readout{200};

const SensorNoise& sensor_of(const Recipe& recipe) { return recipe.sensor ? *recipe.sensor : measured_noise(); }

/// A camera without anything that fires.
simulation::EventCameraOptions silent_camera(events::SensorSize size) {
  simulation::EventCameraOptions camera;
  camera.size = size;
  camera.readout_us = static_cast<double>(readout.count());
  camera.leak_hz = camera.shot_hz = camera.background_hz = 0;
  camera.hot_pixels = camera.dead_pixels = camera.stuck_pixels = 0;
  return camera;
}

class Noise final : public AddedEvents {
 public:
  explicit Noise(const StepInput& input) : camera_(silent_camera(input.size)), seed_(input.seed) {
    const SensorNoise& sensor = sensor_of(input.recipe);
    camera_.background_hz = 1000 * input.recipe.severity / static_cast<double>(simulation::pixel_count(input.size));
    if (camera_.background_hz > most_hz_per_pixel) {
      throw Error(fmt::format("recipe noise: {} kev/s on {} x {} pixels; expected at most {} events/s per pixel",
                              input.recipe.severity, input.size.width, input.size.height, most_hz_per_pixel));
    }
    camera_.background_spread_decades = sensor.spread_decades;
    camera_.background_regularity = sensor.regularity;
    camera_.background_on_share = sensor.on_share;
    camera_.background_on_spread = sensor.on_spread;
    pixels_ = simulation::draw_camera_pixels(camera_, seed_for(seed_, {"pixels"}));
  }

 private:
  void generate(microseconds now, const Fire& fire) override {
    for (; next_ <= now; next_ += readout, ++number_) {
      if (number_ == readouts_at_once) noise_.reset();
      if (!noise_) {  // its read-outs have 32 bits, which last for days
        noise_.emplace(pixels_, camera_, seed_for(seed_, {"events", std::to_string(next_.count())}));
        number_ = 0;
      }
      noise_->advance(number_, [&](std::uint32_t index, bool on) {
        const auto place = static_cast<int>(index);
        fire(next_, place % camera_.size.width, place / camera_.size.width, on);
      });
    }
  }

  static constexpr std::uint32_t readouts_at_once = 1U << 30;

  simulation::EventCameraOptions camera_;
  std::uint64_t seed_;
  simulation::CameraPixels pixels_;
  std::optional<simulation::BackgroundNoise> noise_;
  microseconds next_{0};  ///< the next read-out, since the first event
  std::uint32_t number_ = 0;
};

/// Pixels that fire by themselves. Part of an interval is fixed, the rest exponential.
class HotPixels final : public AddedEvents {
 public:
  explicit HotPixels(const StepInput& input) : width_(input.size.width), random_(seed_for(input.seed, {"events"})) {
    const SensorNoise& sensor = sensor_of(input.recipe);
    const auto count = static_cast<std::size_t>(input.recipe.severity), pixels = simulation::pixel_count(input.size);
    if (count > pixels) {
      throw Error(fmt::format("recipe hot-pixels: {} of {} x {} pixels; expected at most all", count, input.size.width,
                              input.size.height));
    }
    draw_pixels(sensor, count, pixels, input.seed);
    regularity_ = sensor.hot_regularity;
    for (std::uint32_t i = 0; i < pixels_.size(); ++i) due_.emplace_back(first_interval_us(pixels_[i]), i);
    std::make_heap(due_.begin(), due_.end(), std::greater<>());
  }

 private:
  struct Pixel {
    std::uint32_t index;
    double interval_us, on_share;
  };

  /// The first of a random order of all pixels, each with its rate: more hot pixels contain fewer ones.
  void draw_pixels(const SensorNoise& sensor, std::size_t count, std::size_t pixels, std::uint64_t seed) {
    std::vector<double> log_hz;
    for (const double hz : sensor.hot_hz) log_hz.push_back(std::log(hz));
    std::vector<std::uint32_t> order(pixels);
    std::iota(order.begin(), order.end(), 0U);
    Random random(seed_for(seed, {"pixels"}));
    for (std::size_t i = 0; i < count; ++i) {
      std::swap(order[i], order[i + random.below(pixels - i)]);
      const double hz = std::exp(simulation::quantile_at(log_hz, random.uniform()));
      pixels_.push_back({order[i], 1e6 / hz, simulation::quantile_at(sensor.hot_on_shares, random.uniform())});
    }
  }

  /// The pixel has fired long before: the rest of the interval that contains the first event.
  double first_interval_us(const Pixel& pixel) {
    if (random_.uniform() < regularity_) return pixel.interval_us * regularity_ * random_.uniform();
    return pixel.interval_us * (regularity_ + (1 - regularity_) * random_.exponential());
  }

  void generate(microseconds now, const Fire& fire) override {
    const auto end = static_cast<double>(now.count());
    while (!due_.empty() && due_.front().first <= end) {
      std::pop_heap(due_.begin(), due_.end(), std::greater<>());
      auto& [due_us, number] = due_.back();
      const Pixel& pixel = pixels_[number];
      const auto place = static_cast<int>(pixel.index);
      fire(microseconds{static_cast<std::int64_t>(due_us)}, place % width_, place / width_, random_.uniform() < pixel.on_share);
      due_us += std::max(1.0, pixel.interval_us * (regularity_ + (1 - regularity_) * random_.exponential()));
      std::push_heap(due_.begin(), due_.end(), std::greater<>());
    }
  }

  int width_;
  double regularity_ = 0;
  Random random_;
  std::vector<Pixel> pixels_;
  std::vector<std::pair<double, std::uint32_t>> due_;  ///< a heap of the next event of each, the earliest on top
};

}  // namespace

std::unique_ptr<Step> make_noise(const StepInput& input) { return std::make_unique<Noise>(input); }

std::unique_ptr<Step> make_hot_pixels(const StepInput& input) { return std::make_unique<HotPixels>(input); }

}  // namespace tactile::recipes
