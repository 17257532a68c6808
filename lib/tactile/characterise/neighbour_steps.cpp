#include "tactile/characterise/neighbour_steps.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::characterise {

void NeighbourSteps::add(std::span<const events::Event> events) {
  constexpr microseconds step = QuietMeter::reference / static_cast<std::int64_t>(steps);
  for (const events::Event& event : events) {
    if (event.t < begin_ || event.t >= after(begin_, QuietMeter::reference)) continue;
    const auto index = static_cast<std::size_t>(between(begin_, event.t) / step);
    fired_[static_cast<std::size_t>(event.y) * width_ + static_cast<std::size_t>(event.x)].set(index);
  }
}

template <class Use>
void NeighbourSteps::for_pairs(const Use& use) const {
  for (std::size_t pixel = 0; pixel < fired_.size(); ++pixel) {
    if (fired_[pixel].none()) continue;
    if ((pixel + 1) % width_ != 0) use(fired_[pixel], fired_[pixel + 1]);
    if (pixel + width_ < fired_.size()) use(fired_[pixel], fired_[pixel + width_]);
  }
}

double NeighbourSteps::correlation(std::size_t lag) const {
  const Fired until = Fired().set() >> lag;
  const auto in_common = static_cast<double>(steps - lag);
  double covariance = 0, variance = 0;
  const auto add_pair = [&](const Fired& a, const Fired& b) {
    const Fired first = a & until, second = b >> lag;
    const auto expected = static_cast<double>(first.count()) * static_cast<double>(second.count()) / in_common;
    covariance += (static_cast<double>((first & second).count()) - expected) / in_common;
  };
  for_pairs([&](const Fired& a, const Fired& b) {
    if (b.none()) return;
    add_pair(a, b);
    add_pair(b, a);
  });
  for (const Fired& fired : fired_) {
    const double mean = static_cast<double>(fired.count()) / static_cast<double>(steps);
    variance += mean * (1 - mean);
  }
  return variance > 0 ? covariance / (4 * variance) : 0;
}

bool NeighbourSteps::is_motion() const {
  constexpr double of_noise = 0.003, errors = 4;
  double together = 0, events = 0;
  for_pairs([&](const Fired& a, const Fired& b) { together += static_cast<double>((a & b).count()); });
  for (const Fired& fired : fired_) events += static_cast<double>(fired.count());
  // Coincidences of noise are Poisson-distributed.
  const double now = correlation(0), error = std::sqrt(together + 1) / std::max(1.0, 2 * events);
  if (now <= of_noise + errors * error) return false;
  for (std::size_t lag = steps / 4; lag <= steps / 2; ++lag) {
    if (correlation(lag) >= now / 2) return false;
  }
  return true;
}

}  // namespace tactile::characterise
