#include <cmath>
#include <numbers>

#include "tactile/core/random.hpp"
#include "tactile/recipes/recording_clock.hpp"
#include "tactile/recipes/step.hpp"

namespace tactile::recipes {
namespace {

using events::Event;
using events::SensorSize;

constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Appends the event at this place, unless that lies outside the sensor.
void append_at(double x, double y, const Event& event, SensorSize size, std::vector<Event>& out) {
  const double column = std::round(x), row = std::round(y);
  if (!(column >= 0 && row >= 0 && column < size.width && row < size.height)) return;
  Event moved = event;
  moved.x = static_cast<std::int16_t>(column);
  moved.y = static_cast<std::int16_t>(row);
  out.push_back(moved);
}

/// The middle between the first and the last pixel.
double middle_of(int pixels) { return (pixels - 1) / 2.0; }

}  // namespace

std::unique_ptr<Step> make_shift(const StepInput& input) {
  const double direction = radians(input.parameter("direction_deg"));
  const double right = std::round(input.recipe.severity * std::cos(direction)),
               down = std::round(input.recipe.severity * std::sin(direction));
  return event_step([right, down, size = input.size](const Event& event, std::vector<Event>& out) {
    append_at(event.x + right, event.y + down, event, size, out);
  });
}

std::unique_ptr<Step> make_rotate(const StepInput& input) {
  const double angle = radians(input.recipe.severity);
  return event_step([cosine = std::cos(angle), sine = std::sin(angle), middle_x = middle_of(input.size.width),
                     middle_y = middle_of(input.size.height), size = input.size](const Event& event, std::vector<Event>& out) {
    const double x = event.x - middle_x, y = event.y - middle_y;
    append_at(middle_x + cosine * x - sine * y, middle_y + sine * x + cosine * y, event, size, out);
  });
}

std::unique_ptr<Step> make_scale(const StepInput& input) {
  return event_step([factor = 1 + input.recipe.severity / 100, middle_x = middle_of(input.size.width),
                     middle_y = middle_of(input.size.height), size = input.size,
                     random = Random(input.seed)](const Event& event, std::vector<Event>& out) mutable {
    // A pixel covers factor x factor pixels, and each of these has as many events as the pixel had.
    const double area = factor * factor;
    double copies = std::floor(area);
    if (random.uniform() < area - copies) ++copies;
    for (; copies > 0; --copies) {
      const double x = middle_x + factor * (event.x - middle_x) + factor * (random.uniform() - 0.5);
      const double y = middle_y + factor * (event.y - middle_y) + factor * (random.uniform() - 0.5);
      append_at(x, y, event, size, out);
    }
  });
}

std::unique_ptr<Step> make_mirror_x(const StepInput& input) {
  return event_step([last = input.size.width - 1](Event event, std::vector<Event>& out) {
    event.x = static_cast<std::int16_t>(last - event.x);
    out.push_back(event);
  });
}

std::unique_ptr<Step> make_mirror_y(const StepInput& input) {
  return event_step([last = input.size.height - 1](Event event, std::vector<Event>& out) {
    event.y = static_cast<std::int16_t>(last - event.y);
    out.push_back(event);
  });
}

std::unique_ptr<Step> make_vibration(const StepInput& input) {
  const double direction = radians(input.parameter("direction_deg"));
  const double phase = Random(input.seed).uniform(0, 2 * std::numbers::pi);
  return event_step([right = input.recipe.severity * std::cos(direction), down = input.recipe.severity * std::sin(direction),
                     hz = input.parameter("hz"), phase, clock = RecordingClock(),
                     size = input.size](const Event& event, std::vector<Event>& out) mutable {
    const double periods = 1e-6 * static_cast<double>(clock.advance(event.t).count()) * hz;
    const double place = std::sin(2 * std::numbers::pi * (periods - std::floor(periods)) + phase);
    append_at(event.x + right * place, event.y + down * place, event, size, out);
  });
}

}  // namespace tactile::recipes
