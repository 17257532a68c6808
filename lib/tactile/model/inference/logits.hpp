#pragma once

#include <array>

#include "tactile/core/touch.hpp"

namespace tactile {

/// What the network says of a heatmap, one number for each of none, press, slip.
using Logits = std::array<float, touch_count>;

/// How likely each of none, press, slip is, by the network; in [0, 1], their sum is 1 but for rounding.
using Probabilities = std::array<float, touch_count>;

/// The touch with the largest logit; the earlier one of equals.
Touch verdict_of(const Logits& logits);

/// Whether the two largest logits differ by under 1e-4: so little that another engine, which adds up in another order, may give
/// another verdict.
bool is_close(const Logits& logits);

/// exp(logit) / sum of exp(logits), right for logits of any finite size.
Probabilities probabilities_of(const Logits& logits);

}  // namespace tactile
