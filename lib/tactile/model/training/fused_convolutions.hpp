#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/model/inference/aligned_values.hpp"

namespace tactile {

/// Weights and biases of the two layers, or their gradients, as libtorch lays them out: [out][in][5][5].
template <class Float>
struct ConvolutionValues {
  Float* first_weight;   ///< 6 x 1 x 5 x 5
  Float* first_bias;     ///< 6
  Float* second_weight;  ///< 16 x 6 x 5 x 5
  Float* second_bias;    ///< 16
};

/// LeNet's two convolution layers with ReLU and max-pool 2, forward and backward for learning:
///
///   z = W * x + b,   p = the largest of each 2 x 2 of z (the first of equals),   y = max(p, 0)
///
/// A layer is one pass over strips that stay in the first-level cache, and keeps of each 2 x 2 which one was the largest. Back
/// through it goes a gradient of one in four positions, so only those are touched. The first layer's passes, both ways, go over
/// the heatmap's cells that are not 0; where the second layer sees nothing but empty cells its answer is known beforehand.
/// A sum's terms come in one order, so empty cells are left out without moving a bit.
///
/// For the paper's ReLU and max-pool alone. A NaN is passed on. Written for vectors of any width, chosen at run time.
class FusedConvolutions {
 public:
  explicit FusedConvolutions(const LeNetLayers& layers);

  /// Takes over the weights that the next passes work with.
  void set(const ConvolutionValues<const float>& values);

  /// What a heatmap's way back needs of its way forward.
  struct Kept {
    AlignedValues<float> pooled;               ///< the first layer's answer, [height][width][6]
    std::vector<std::uint8_t> first_largest;   ///< which of four, 0 to 3 row by row; 4: none, cut off by ReLU. As `pooled`
    std::vector<std::uint8_t> second_largest;  ///< as above, [height][width][16]
  };
  Kept make_kept() const;

  /// Sums of gradients, in the layout of the passes.
  struct Gradients {
    AlignedValues<float> first = AlignedValues<float>(25 * 8), first_bias = AlignedValues<float>(8);
    AlignedValues<float> second = AlignedValues<float>(std::size_t{16} * 5 * 32), second_bias = AlignedValues<float>(16);

    void clear();
    void add(const Gradients& other);
    void write(const ConvolutionValues<float>& values) const;
  };

  /// Memory to work in: one for each thread.
  struct Workspace {
    std::vector<std::uint32_t> row_begin;  ///< of the cells that are not 0
    std::vector<std::uint16_t> cell_x;
    std::vector<float> cell_value;
    AlignedValues<float> strip, pooled_gradient;
    std::vector<std::uint32_t> tiles;  ///< of the second layer, that see more than empty cells
    std::vector<std::uint8_t> lit;
    std::array<std::vector<std::uint32_t>, 16> places;  ///< of gradients, for each channel
    std::array<std::vector<float>, 16> slopes;
  };
  Workspace make_workspace() const;

  /// @param heatmap  [height, width]; the network sees it as H / 255
  /// @param flat     the second layer's answer, channel first: layers.flat values
  void forward(std::span<const std::uint8_t> heatmap, std::span<float> flat, Kept& kept, Workspace& workspace) const;

  /// Adds the gradients of one heatmap to `sums`.
  /// @param gradient  of the loss by `flat`
  void backward(std::span<const std::uint8_t> heatmap, const Kept& kept, std::span<const float> gradient, Gradients& sums,
                Workspace& workspace) const;

  /// The weights as the passes read them.
  struct Packed {
    AlignedValues<float> first = AlignedValues<float>(25 * 8), first_bias = AlignedValues<float>(8);  ///< [5][5][8 of 6 channels]
    AlignedValues<float> second = AlignedValues<float>(std::size_t{150} * 16),
                         second_bias = AlignedValues<float>(16);                        ///< [5][5 * 6][16 channels]
    AlignedValues<float> second_back = AlignedValues<float>(std::size_t{16} * 5 * 32);  ///< [16][5][32 of 5 * 6]
    std::array<float, 16> empty_answer{};  ///< the second layer's to an empty heatmap
    std::array<std::uint8_t, 16> empty_largest{};
  };

 private:
  LeNetLayers layers_;
  Packed packed_;
};

}  // namespace tactile
