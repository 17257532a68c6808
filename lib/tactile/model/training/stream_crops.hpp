#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/model/training/stream_runs.hpp"

namespace tactile::model {

/// What one step of a training learns from: `StreamCrops::crops` pieces of runs, of `StreamCrops::ticks` ticks each.
struct StreamBatch {
  std::vector<float> inputs;        ///< [crop, tick, place, 145]: ln(1 + n) of each cell, then of the place's sum
  std::vector<std::int64_t> truth;  ///< [crop, tick], the value of Touch
  std::vector<float> weights;       ///< [crop, tick]
};

/// Pieces of whole runs at random, changed at random: so few runs become many. The same seed and step give the same batch.
///
/// Where a piece begins: 6 of 10 hold the start of a touch, others lie anywhere.
///
/// Motion that is no touch, made from the run's own touches and put where the run is quiet, in 3 of 10:
///  - micro-slip: 1 to 4 patches of a touch, a quarter of a place each, for 8 to 50 ms;
///  - release: a press backwards in time with ON and OFF exchanged; in half of the cases the press again after it (re-contact);
///  - firm lift: the first 4 to 16 ms of a slip, which then dies out.
///
/// Changes of a whole piece: mirrored in each direction (1 of 2); moved by up to a place in each direction (1 of 2), events that
/// leave at a side return at the other; up to 6 patches replaced by quiet (3 of 10); made 0.6 to 1.6 times as fast (4 of 10);
/// events left out at random so that 0.4 to 1 of them stay, of each polarity 0.7 to 1 of these (1 of 2); noise of 0.002 to 0.06
/// events in a pixel of the image and tick (4 of 10).
class StreamCrops {
 public:
  static constexpr std::size_t crops = 10, ticks = 300;

  /// @param runs  must outlive it. @throws Error  if there is no run with a tick
  StreamCrops(std::span<const StreamRun> runs, std::uint64_t seed);

  StreamBatch batch(std::uint64_t step, unsigned threads) const;

 private:
  struct Crop {
    std::vector<std::uint8_t> counts;  ///< [tick, StreamImage::size]
    std::vector<Touch> truth;
    std::vector<float> weights;
  };
  Crop cut(const StreamRun& run, Random& random) const;
  void put_other_motion(const StreamRun& run, Crop& crop, Random& random) const;
  void change(Crop& crop, Random& random) const;
  void place_quiet(Crop& crop, Random& random) const;
  std::vector<std::uint8_t> quiet(std::size_t count, Random& random) const;

  std::span<const StreamRun> runs_;
  std::uint64_t seed_;
};

/// ln(1 + n) of each cell and of the place's sum. @param counts  [tick, StreamImage::size]  @param inputs  [tick, place, 145]
void stream_inputs(std::span<const std::uint8_t> counts, std::span<float> inputs);

}  // namespace tactile::model
