#include <algorithm>
#include <cmath>
#include <numbers>

#include "tactile/core/random.hpp"
#include "tactile/recipes/added_events.hpp"

namespace tactile::recipes {
namespace {

/// Pixels that see the flicker of the light. The light is darkest at the start of a period and brightest in its middle. Each of
/// these pixels gives one ON event at each rise and one OFF event at each fall, when the light has done a share of its change
/// that is the pixel's own, from one half to all: where the flicker just exceeds a pixel's threshold, it does so at the end.
class Flicker final : public AddedEvents {
 public:
  Flicker(const StepInput& input, double hz) : period_us_(1e6 / hz), width_(input.size.width) {
    Random chosen(seed_for(input.seed, {"pixels"})), shares(seed_for(input.seed, {"phases"}));
    const int pixels = input.size.width * input.size.height;
    for (int pixel = 0; pixel < pixels; ++pixel) {
      if (chosen.uniform() >= input.recipe.severity / 100) continue;
      for (const bool on : {true, false}) {
        const double share = shares.uniform(0.5, 1.0);
        const double of_period = std::acos(1 - 2 * share) / (2 * std::numbers::pi);  // from 1/4 to 1/2
        flashes_.push_back({period_us_ * (of_period + (on ? 0.0 : 0.5)), pixel, on});
      }
    }
    std::sort(flashes_.begin(), flashes_.end(), [](const Flash& a, const Flash& b) {
      return a.phase_us != b.phase_us ? a.phase_us < b.phase_us : a.pixel < b.pixel;
    });
  }

 private:
  struct Flash {
    double phase_us;  ///< in the period
    int pixel;
    bool on;
  };

  void generate(microseconds now, const Fire& fire) override {
    if (flashes_.empty()) return;
    for (;;) {
      const Flash& flash = flashes_[next_];
      const microseconds at{static_cast<std::int64_t>(period_us_ * static_cast<double>(period_) + flash.phase_us)};
      if (at > now) return;
      fire(at, flash.pixel % width_, flash.pixel / width_, flash.on);
      if (++next_ == flashes_.size()) {
        next_ = 0;
        ++period_;
      }
    }
  }

  double period_us_;
  int width_;
  std::vector<Flash> flashes_;  ///< of one period, ascending
  std::size_t next_ = 0;
  std::int64_t period_ = 0;
};

}  // namespace

std::unique_ptr<Step> make_flicker_100(const StepInput& input) { return std::make_unique<Flicker>(input, 100.0); }

std::unique_ptr<Step> make_flicker_120(const StepInput& input) { return std::make_unique<Flicker>(input, 120.0); }

}  // namespace tactile::recipes
