#include "tactile/model/definition/stream_options.hpp"

#include "tactile/core/touch.hpp"

namespace tactile::model {

std::vector<ParameterShape> stream_parameters() {
  constexpr std::int64_t channels = StreamSizes::channels, memory = StreamSizes::memory, pooled = StreamSizes::pooled;
  constexpr std::int64_t inputs = StreamLayout::inputs_of_place, kept = StreamSizes::kept, classes = touch_count;
  return {{"grid", {4}},
          {"cells.weight", {channels, inputs}},
          {"cells.bias", {channels}},
          {"means.weight", {channels, kept * channels}},
          {"means.bias", {channels}},
          {"place.weight", {channels, channels}},
          {"place.bias", {channels}},
          {"gru.weight_ih", {3 * memory, pooled}},
          {"gru.weight_hh", {3 * memory, memory}},
          {"gru.bias_ih", {3 * memory}},
          {"gru.bias_hh", {3 * memory}},
          {"out.weight", {classes, memory}},
          {"out.bias", {classes}}};
}

}  // namespace tactile::model
