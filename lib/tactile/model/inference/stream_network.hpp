#pragma once

#include <array>
#include <cstdint>

#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/stream_options.hpp"
#include "tactile/model/inference/aligned_values.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/model/inference/stream_counts.hpp"

namespace tactile::model {

/// What the network remembers from tick to tick. At the start all is 0.
struct StreamState {
  AlignedValues<float> means = AlignedValues<float>(StreamSizes::spans.size() * StreamLayout::places * StreamSizes::channels);
  AlignedValues<float> memory = AlignedValues<float>(StreamSizes::memory);
  Logits logits{};       ///< of the last tick
  bool at_rest = false;  ///< a tick without events changes nothing any more
};

/// The network's weights, with the outputs of an input side by side.
struct StreamPlan {
  AlignedValues<float> cells;                        ///< [cell of a place, channel]
  AlignedValues<float> cells_all, cells_bias;        ///< [channel], of the place's number of events
  AlignedValues<float> means, means_bias;            ///< [kept value, channel]
  AlignedValues<float> place, place_bias;            ///< [channel, channel]
  AlignedValues<float> gru_input, gru_input_bias;    ///< [pooled, 3 memory]
  AlignedValues<float> gru_memory, gru_memory_bias;  ///< [memory, 3 memory]
  AlignedValues<float> out, out_bias;                ///< [memory, 4 classes], the last one 0
  std::array<float, 256> log1p{};                    ///< ln(1 + n)
};

/// A recurrent network that reads the events of each tick once and remembers. With n_c events in cell c of place p:
///
///   a_p    = relu(b + sum over the place's cells of W_c ln(1 + n_c) + w ln(1 + sum of n_c))
///   m_T,p <- (1 - 1/T) m_T,p + a_p / T          for T = 5, 20, 80 ticks
///   u_p    = relu(place relu(means [a_p, m_5,p, m_20,p, m_80,p]))
///   v      = [mean, maximum, mean of x_p u_p, mean of y_p u_p] over the places, x_p and y_p from -1 to 1
///   h     <- GRU(v, h),   logits = out h
///
/// All places share their weights. The first sum is over cells with events only. Once a tick without events changes no mean and
/// no memory by more than `rest`, further ones are skipped until the next event. The logits agree with libtorch's within 1e-5 of
/// the largest. Immutable and thread-safe; `advance` allocates no memory.
///
/// Sources: Cho et al., arXiv:1406.1078 (the GRU, in the form of libtorch); Zaheer et al., arXiv:1703.06114 (shared weights and
/// pooling over a set). The inputs and sizes are ours.
class StreamNetwork {
 public:
  static constexpr float rest = 1e-7F;

  /// @throws Error  if the weights have other shapes, or are so large that a sum may exceed float32
  explicit StreamNetwork(const Weights& weights);

  const StreamGrid& grid() const { return grid_; }
  /// One tick. The logits of it are then in the state.
  void advance(const StreamCounts& counts, StreamState& state) const;

 private:
  StreamGrid grid_;
  StreamPlan plan_;
};

/// The rectangle of `weights`, which come first.
StreamGrid grid_of(const Weights& weights);

}  // namespace tactile::model
