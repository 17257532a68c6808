#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/model/inference/aligned_values.hpp"

namespace tactile::model {

/// Weights and biases of the two layers, or their gradients, in libtorch's layout: [out][in][5][5].
template <class Float>
struct ConvolutionValues {
  Float* first_weight;   ///< 6 x 1 x 5 x 5
  Float* first_bias;     ///< 6
  Float* second_weight;  ///< 16 x 6 x 5 x 5
  Float* second_bias;    ///< 16
};

/// LeNet's two convolution layers with ReLU and max-pool 2, forward and backward:
///
///   z = W * x + b,   p = the largest of each 2 x 2 of z (the first of equal ones),   y = max(p, 0)
///
/// A layer is one pass over strips that stay in the first-level cache. It stores which of each 2 x 2 was the largest. The
/// backward pass has a gradient at one of four positions, and only visits those. Both passes of the first layer only visit the
/// nonzero cells of the heatmap. If the second layer sees only empty cells, its output is known. The terms of a sum have a fixed
/// order, so omitting empty cells does not change a bit.
///
/// Only for the paper's ReLU and max-pool. NaN is propagated. Written for vectors of any width, chosen at run time.
class FusedConvolutions {
 public:
  explicit FusedConvolutions(const LeNetLayers& layers);

  /// Sets the weights for the next passes.
  void set(const ConvolutionValues<const float>& values);

  /// Values of the forward pass that the backward pass needs.
  struct Kept {
    AlignedValues<float> pooled;               ///< output of the first layer, [height][width][6]
    std::vector<std::uint8_t> first_largest;   ///< which of four, 0 to 3 row by row; 4: none, because of ReLU. Shape of `pooled`
    std::vector<std::uint8_t> second_largest;  ///< the same, [height][width][16]
  };
  Kept make_kept() const;

  /// Sums of gradients, in the layout of the passes.
  struct Gradients {
    AlignedValues<float> first = AlignedValues<float>(std::size_t{25} * 8), first_bias = AlignedValues<float>(8);
    AlignedValues<float> second = AlignedValues<float>(std::size_t{16} * 5 * 32), second_bias = AlignedValues<float>(16);

    void clear();
    void add(const Gradients& other);
    void write(const ConvolutionValues<float>& values) const;
  };

  /// Working memory of one thread.
  struct Workspace {
    std::vector<std::uint32_t> row_begin;  ///< of the nonzero cells
    std::vector<std::uint16_t> cell_x;
    std::vector<float> cell_value;
    AlignedValues<float> strip, pooled_gradient;
    std::vector<std::uint32_t> tiles;  ///< of the second layer, that see nonzero cells
    std::vector<std::uint8_t> lit;
    std::array<std::vector<std::uint32_t>, 16> places;  ///< of gradients, for each channel
    std::array<std::vector<float>, 16> gradients;
  };
  Workspace make_workspace() const;

  /// @param heatmap  [height, width]; the network's input is H / 255
  /// @param flat     output of the second layer, channel first: layers.flat values
  void forward(std::span<const std::uint8_t> heatmap, std::span<float> flat, Kept& kept, Workspace& workspace) const;

  /// Adds the gradients of one heatmap to `sums`.
  /// @param gradient  of the loss with respect to `flat`
  void backward(std::span<const std::uint8_t> heatmap, const Kept& kept, std::span<const float> gradient, Gradients& sums,
                Workspace& workspace) const;

  /// The weights in the layout of the passes.
  struct Packed {
    AlignedValues<float> first = AlignedValues<float>(std::size_t{25} * 8),
                         first_bias = AlignedValues<float>(8);  ///< [5][5][8 of 6 channels]
    AlignedValues<float> second = AlignedValues<float>(std::size_t{150} * 16),
                         second_bias = AlignedValues<float>(16);                        ///< [5][5 * 6][16 channels]
    AlignedValues<float> second_back = AlignedValues<float>(std::size_t{16} * 5 * 32);  ///< [16][5][32 of 5 * 6]
    std::array<float, 16> empty_answer{};  ///< output of the second layer for an empty heatmap
    std::array<std::uint8_t, 16> empty_largest{};
  };

 private:
  LeNetLayers layers_;
  Packed packed_;
};

}  // namespace tactile::model
