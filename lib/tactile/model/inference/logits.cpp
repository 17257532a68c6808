#include "tactile/model/inference/logits.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::model {

Touch verdict_of(const Logits& logits) {
  return all_touches[static_cast<std::size_t>(std::max_element(logits.begin(), logits.end()) - logits.begin())];
}

bool is_close(const Logits& logits) {
  constexpr float apart = 1e-4F;
  Logits ascending = logits;
  std::sort(ascending.begin(), ascending.end());
  return ascending[touch_count - 1] - ascending[touch_count - 2] < apart;
}

Probabilities probabilities_of(const Logits& logits, double temperature) {
  const double largest = *std::max_element(logits.begin(), logits.end());
  std::array<double, touch_count> weights{};
  double sum = 0;
  for (std::size_t i = 0; i < touch_count; ++i)
    sum += weights[i] = std::exp((static_cast<double>(logits[i]) - largest) / temperature);
  Probabilities probabilities{};
  for (std::size_t i = 0; i < touch_count; ++i) probabilities[i] = static_cast<float>(weights[i] / sum);
  return probabilities;
}

}  // namespace tactile::model
