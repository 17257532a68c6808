#pragma once

#include <cstddef>
#include <span>

namespace tactile::model {

/// A fully connected layer for a batch, forward and backward, in float32. All arrays are row by row. The work is divided in the
/// same way for any number of threads, and each value is summed in the same order, so results do not depend on the threads.
/// OpenBLAS's do on some processors (seen with AVX-512 and AMX, OpenBLAS 0.3.21): they change with the part of a matrix that a
/// call computes.
class FullyConnected {
 public:
  /// @param inputs  values of a sample, > 0  @param units  > 0
  FullyConnected(std::size_t inputs, std::size_t units) : inputs_(inputs), units_(units) {}

  /// output[n, u] = bias[u] + sum over k of input[n, k] weight[u, k]
  /// @param input   [n, inputs]  @param weight  [units, inputs]  @param bias  [units]  @param output  [n, units]
  void forward(std::span<const float> input, std::span<const float> weight, std::span<const float> bias, std::span<float> output,
               unsigned threads) const;

  /// The derivatives of a loss by the input and by the weights:
  ///   of_input[n, k] = sum over u of gradient[n, u] weight[u, k],  of_weight[u, k] = sum over n of gradient[n, u] input[n, k]
  /// @param gradient  of the loss by the output, [n, units]
  void backward(std::span<const float> input, std::span<const float> weight, std::span<const float> gradient,
                std::span<float> of_input, std::span<float> of_weight, unsigned threads) const;

 private:
  std::size_t inputs_, units_;
};

}  // namespace tactile::model
