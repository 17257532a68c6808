#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/model/inference/aligned_values.hpp"

namespace tactile::model {

/// Sizes that the layers have whatever the heatmap is, and those that vectors round them up to.
struct LeNetSizes {
  static constexpr std::size_t taps = 5;  ///< of a kernel, each way
  static constexpr std::size_t first_channels = LeNetLayers::first_channels;
  static constexpr std::size_t second_channels = LeNetLayers::second_channels;  ///< one vector of the widest
  static constexpr std::size_t first_hidden = LeNetLayers::first_hidden, second_hidden = LeNetLayers::second_hidden, classes = 3;
  static constexpr std::size_t lanes = 16;        ///< float32 in the widest vector
  static constexpr std::size_t points = 6;        ///< that the second convolution takes polynomials at
  static constexpr std::size_t block = 8;         ///< columns of the second pooled layer whose values lie together
  static constexpr std::size_t hidden_row = 128;  ///< outputs of the first two fully connected layers, rounded up
};

/// A network's weights as the kernel reads them, and what it gives for an empty heatmap.
struct LeNetPlan {
  LeNetLayers layers;
  std::size_t input_rows = 0, input_pairs = 0;  ///< of the heatmap: rows, and pairs of columns, that any output depends on
  std::size_t pair_stride = 0;                  ///< of a row of pairs [values]
  std::size_t pair_chunks = 0;                  ///< of 16 pairs in a row, including the one after the last
  std::size_t pooled_stride = 0;                ///< of a row of the first pooled layer's channel [values]
  std::size_t blocks = 0;                       ///< of columns of the second pooled layer

  AlignedValues<float> first_weights;   ///< [ky][kx][channel]
  AlignedValues<float> first_bias;      ///< [channel]
  AlignedValues<float> second_weights;  ///< [point][channel in][ky][channel out]
  AlignedValues<float> second_bias;     ///< [channel out]

  /// [row][column][channel] of the second pooled layer, each with 128 outputs: what an input adds lies together.
  AlignedValues<float> hidden_weights;
  AlignedValues<std::uint16_t> hidden_bf16;  ///< the same in bfloat16, the upper half of float32, in place of them
  AlignedValues<std::int8_t> hidden_bytes;   ///< the same as whole numbers, in place of them
  AlignedValues<float> hidden_scale;         ///< of each output's whole numbers; empty without them
  AlignedValues<float> hidden_empty;         ///< the first fully connected layer's sums for an empty heatmap

  AlignedValues<float> inner_weights;  ///< [input][128 outputs]
  AlignedValues<float> inner_bias;
  AlignedValues<float> last_weights;  ///< [input][16 outputs]
  AlignedValues<float> last_bias;

  std::array<float, LeNetSizes::first_channels> first_empty{};  ///< a value of each channel of the pooled layers
  AlignedValues<float> second_empty;
  std::array<float, LeNetSizes::classes> logits_empty{};
};

/// What the kernel writes on its way.
struct LeNetMemory {
  AlignedValues<float> even, odd;         ///< [row][pair], the heatmap's even and odd columns / 255
  AlignedValues<std::uint8_t> lit;        ///< [pair of rows][pair of columns], not 0 where a cell is not
  AlignedValues<std::uint8_t> lit_chunk;  ///< [pair of rows][16 pairs], whether any is lit
  AlignedValues<std::uint8_t> lit_row;    ///< one row of it
  AlignedValues<float> pooled;            ///< [row][channel][column] of the first pooled layer
  AlignedValues<float> at_points;         ///< [row][block of columns][point][channel][column], of the first pooled layer
  AlignedValues<std::uint8_t> computed;   ///< [row][16 columns], whether they hold other values than an empty heatmap's
  AlignedValues<std::uint32_t> columns;   ///< of the second pooled layer's row that are computed
  std::array<AlignedValues<float>, 2> differences;   ///< to the empty heatmap's, but for those that are 0
  std::array<AlignedValues<std::uint32_t>, 2> rows;  ///< of `hidden_weights` that they belong to
  AlignedValues<float> hidden, row_sum, inner, last;
};

LeNetMemory memory_for(const LeNetPlan& plan);

/// The forward pass for one set of vector instructions.
struct LeNetKernel {
  const char* name = "";  ///< "AVX2"

  /// @param logits  where not null: of the heatmap
  /// @param second  where not null: the second pooled layer, [row][column][channel], less `second_empty`
  using Run = void (*)(const LeNetPlan& plan, LeNetMemory& memory, const std::uint8_t* heatmap, bool skip_empty, float* logits,
                       float* second);
  Run run = nullptr;
};

/// The fastest that this processor can.
LeNetKernel best_kernel();

/// All that this processor can, the fastest first.
std::vector<LeNetKernel> kernels();

}  // namespace tactile::model
