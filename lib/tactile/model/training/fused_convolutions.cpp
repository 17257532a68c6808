#include "tactile/model/training/fused_convolutions.hpp"

#include <algorithm>

// Highway compiles the following once for each kind of processor and selects the best at run time. Vectors of unknown size are
// not supported, because arrays of them are impossible.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tactile/model/training/fused_convolutions.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tactile/model/training/fused_forward-inl.hpp"
//
#include "tactile/model/training/fused_backward-inl.hpp"

#if HWY_ONCE
namespace tactile::model {
namespace {

HWY_EXPORT(forward);
HWY_EXPORT(backward);
HWY_EXPORT(answer_empty);

constexpr std::size_t channels_1 = 6, channels_2 = 16, side = 5,
                      beyond = 64;  // floats that a vector may read or write beyond the end

std::size_t cells_of(events::SensorSize size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

/// Calls `pair(ours, theirs)` for each weight of the first and of the second layer: its index in the layout of the passes and in
/// libtorch's.
template <class First, class Second>
void for_weights(const First& first, const Second& second) {
  for (std::size_t c = 0; c < channels_1; ++c) {
    for (std::size_t tap = 0; tap < side * side; ++tap) first(tap, c);
  }
  for (std::size_t c = 0; c < channels_2; ++c) {
    for (std::size_t in = 0; in < channels_1; ++in) {
      for (std::size_t dy = 0; dy < side; ++dy) {
        for (std::size_t dx = 0; dx < side; ++dx)
          second(c, dy, dx * channels_1 + in, ((c * channels_1 + in) * side + dy) * side + dx);
      }
    }
  }
}

}  // namespace

FusedConvolutions::FusedConvolutions(const LeNetLayers& layers) : layers_(layers) {}

void FusedConvolutions::set(const ConvolutionValues<const float>& values) {
  for_weights([&](std::size_t tap, std::size_t c) { packed_.first[tap * 8 + c] = values.first_weight[c * side * side + tap]; },
              [&](std::size_t c, std::size_t dy, std::size_t k, std::size_t theirs) {
                packed_.second[(dy * 30 + k) * channels_2 + c] = values.second_weight[theirs];
                packed_.second_back[(c * side + dy) * 32 + k] = values.second_weight[theirs];
              });
  std::copy_n(values.first_bias, channels_1, packed_.first_bias.begin());
  std::copy_n(values.second_bias, channels_2, packed_.second_bias.begin());
  HWY_DYNAMIC_DISPATCH(answer_empty)(packed_);
}

FusedConvolutions::Kept FusedConvolutions::make_kept() const {
  const std::size_t first = cells_of(layers_.first_pooled) * channels_1 + beyond;
  return {AlignedValues<float>(first), std::vector<std::uint8_t>(first), std::vector<std::uint8_t>(layers_.flat)};
}

FusedConvolutions::Workspace FusedConvolutions::make_workspace() const {
  const std::size_t cells = cells_of(layers_.input), tiles = cells_of(layers_.second_pooled);
  Workspace work;
  work.row_begin.resize(static_cast<std::size_t>(layers_.input.height) + 1);
  work.cell_x.resize(cells + 1);  // one extra is written
  work.cell_value.resize(cells + 1);
  work.strip.resize(2 * (static_cast<std::size_t>(layers_.input.width) + 4) * 8);
  work.pooled_gradient.resize(cells_of(layers_.first_pooled) * channels_1 + beyond);
  work.tiles.reserve(tiles);
  work.lit.resize(static_cast<std::size_t>(layers_.input.width));
  for (std::size_t c = 0; c < channels_2; ++c) {
    work.places[c].resize(tiles);
    work.gradients[c].resize(tiles);
  }
  return work;
}

void FusedConvolutions::forward(std::span<const std::uint8_t> heatmap, std::span<float> flat, Kept& kept,
                                Workspace& workspace) const {
  HWY_DYNAMIC_DISPATCH(forward)(layers_, packed_, heatmap.data(), flat.data(), kept, workspace);
}

void FusedConvolutions::backward(std::span<const std::uint8_t> heatmap, const Kept& kept, std::span<const float> gradient,
                                 Gradients& sums, Workspace& workspace) const {
  HWY_DYNAMIC_DISPATCH(backward)(layers_, packed_, heatmap.data(), kept, gradient.data(), sums, workspace);
}

void FusedConvolutions::Gradients::clear() {
  for (AlignedValues<float>* values : {&first, &first_bias, &second, &second_bias})
    std::fill(values->begin(), values->end(), 0.0F);
}

void FusedConvolutions::Gradients::add(const Gradients& other) {
  const auto add_all = [](AlignedValues<float>& to, const AlignedValues<float>& from) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
  };
  add_all(first, other.first);
  add_all(first_bias, other.first_bias);
  add_all(second, other.second);
  add_all(second_bias, other.second_bias);
}

void FusedConvolutions::Gradients::write(const ConvolutionValues<float>& values) const {
  for_weights([&](std::size_t tap, std::size_t c) { values.first_weight[c * side * side + tap] = first[tap * 8 + c]; },
              [&](std::size_t c, std::size_t dy, std::size_t k, std::size_t theirs) {
                values.second_weight[theirs] = second[(c * side + dy) * 32 + k];
              });
  std::copy_n(first_bias.begin(), channels_1, values.first_bias);
  std::copy_n(second_bias.begin(), channels_2, values.second_bias);
}

}  // namespace tactile::model
#endif
