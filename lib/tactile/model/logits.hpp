#pragma once

#include <array>

#include "tactile/core/touch.hpp"

namespace tactile {

/// What the network says of a heatmap, one number for each of none, press, slip.
using Logits = std::array<float, touch_count>;

/// The touch with the largest logit; the earlier one of equals.
Touch verdict_of(const Logits& logits);

}  // namespace tactile
