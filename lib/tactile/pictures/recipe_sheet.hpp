#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "tactile/events/event.hpp"
#include "tactile/recipes/recipe.hpp"

namespace tactile::pictures {

/// What a recipe does to a recording: the events of [t - 40 ms, t) without it on the left and with it on the right, as pixels
/// (ON blue, OFF red, the last one counts), under the recipe's title and severity. Only the second before `t` and the 40 ms after
/// it are worsened.
/// @param events  of the recording, ascending in time and inside the sensor
/// @return        BGR of 8 bits: two sensors wide, with 8 px between them and 44 px of text above
/// @throws Error  as `recipes::RecipeStream`
cv::Mat recipe_sheet(std::span<const events::Event> events, events::SensorSize size, const recipes::Recipe& recipe, CameraTime t);

}  // namespace tactile::pictures
