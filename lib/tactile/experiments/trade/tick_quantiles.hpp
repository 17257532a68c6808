#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/judged_run.hpp"

namespace tactile::trade {

/// The timed ticks of one run.
struct TimedRun : results::JudgedRun {
  std::vector<float> tick_us{};   ///< duration of each tick of each turn
  std::uint64_t interrupted = 0;  ///< of these, the ones in which another program had the processor
};

/// Quantiles of the durations of all ticks of drawn runs. Runs are sorted once, so that a draw costs no sorting.
class TickQuantiles {
 public:
  explicit TickQuantiles(std::span<const TimedRun> runs);

  /// The least duration that the share `q` of the ticks does not exceed; a run counts as often as its weight says.
  /// @param weights  of each run   @param q  in [0, 1]   @return  nothing if there is no tick
  std::optional<double> of(std::span<const std::uint32_t> weights, double q) const;
  std::optional<double> of(const evaluation::RunsByObject& drawn, double q) const;

 private:
  struct Tick {
    float us;
    std::uint32_t run;
  };
  std::vector<Tick> ticks_;            ///< ascending
  std::vector<std::uint64_t> counts_;  ///< of each run
};

}  // namespace tactile::trade
