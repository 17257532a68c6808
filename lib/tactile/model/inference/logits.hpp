#pragma once

#include <array>

#include "tactile/core/touch.hpp"

namespace tactile::model {

/// The output of the network for a heatmap: one number for each of none, press, slip.
using Logits = std::array<float, touch_count>;

/// The probabilities of none, press, slip; in [0, 1], with the sum 1 except for rounding.
using Probabilities = std::array<float, touch_count>;

/// The touch with the largest logit; the first one if several are equal.
Touch verdict_of(const Logits& logits);

/// Whether the two largest logits differ by less than 1e-4. Then another engine, which sums in another order, may give another
/// verdict.
bool is_close(const Logits& logits);

/// exp(logit / temperature) / sum of exp(logits / temperature), valid for all finite logits.
/// @param temperature  > 0
Probabilities probabilities_of(const Logits& logits, double temperature = 1);

}  // namespace tactile::model
