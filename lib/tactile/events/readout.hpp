#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/measured.hpp"
#include "tactile/events/event.hpp"

namespace tactile::events {

/// What a read-out passes through one after the other, with a time stamp for each: nothing (all its events share one stamp), or
/// the columns or rows of the sensor.
enum class Scan : std::uint8_t { none, columns, rows };

/// How a sensor is read out, as its time stamps show it:
///
///   t = begin + k * period + step * line + jitter,   k whole, line = x (columns) or y (rows)
struct Readout {
  /// steady: the formula holds over the whole recording. unsteady: read-outs share stamps but are stretched, and the period is
  /// the shortest. none: events have times of their own (asynchronous sensors), or too few events to decide.
  enum class Kind : std::uint8_t { none, unsteady, steady };
  Kind kind = Kind::none;
  Measured period_us;                   ///< meaningless if there is none
  double begin_us = 0;                  ///< after the recording's first event; for steady read-outs only, as all that follows
  Scan scan = Scan::none;               ///< of the stamps
  Measured step_us;                     ///< from one line to the next, below 0 if the scan begins at the highest line
  std::size_t lines = 0;                ///< that are scanned
  Measured jitter_us;                   ///< of a stamp, standard deviation, without the rounding to whole us
  Measured wander_us;                   ///< of the read-outs around a steady clock, standard deviation, slower than 0.1 s
  double wander_s = 0;                  ///< after this time the wander correlates with itself by less than 1 / e, about
  double coherence = 0;                 ///< |mean of exp(2 pi i t / period)| within such times, by line: 1 without jitter
  std::vector<double> line_offsets_us;  ///< of each line, its stamps minus the formula's; NaN where nothing fired
  std::int64_t stamp_step_us = 0;       ///< greatest common divisor of all differences of stamps; 0: fewer than two stamps
  std::uint64_t events = 0;             ///< looked at

  /// A change of brightness is stamped at the next read-out of its line, so a stamp is late by up to one period; without
  /// read-outs the stamps' own step counts. The digits below say nothing about when the change took place.
  double precision_us() const { return kind == Kind::none ? static_cast<double>(stamp_step_us) : period_us.value; }
};

/// Measures the read-out of one event stream. The first 2^19 events are kept and searched for a period: by column, by row, and
/// over all pixels. A period that is found is then followed over all further events, so that memory follows the sensor and the
/// length of the recording (some hundred bytes per second).
class ReadoutMeter {
 public:
  enum class Extent : std::uint8_t {
    beginning,  ///< only the kept events count
    all
  };

  /// @param size  nothing or invalid: no columns and rows are compared
  ReadoutMeter(std::optional<SensorSize> size, Extent extent);

  /// Events in file order. Those outside the sensor are passed over.
  void add(std::span<const Event> events);
  Readout readout() const;

  /// One event. `t_us` counts from the first.
  struct Stamp {
    std::int64_t t_us = 0;
    std::int16_t x = 0, y = 0;
  };
  /// The formula of `Readout`.
  struct Line {
    double period_us = 0, begin_us = 0, step_us = 0;
    Scan scan = Scan::none;

    std::size_t line_of(const Stamp& s) const {
      return scan == Scan::none ? 0 : static_cast<std::size_t>(scan == Scan::columns ? s.x : s.y);
    }
    double after_begin_us(const Stamp& s) const {
      return static_cast<double>(s.t_us) - begin_us - step_us * static_cast<double>(line_of(s));
    }
  };

 private:
  /// Sums over some time of the residuals r around the formula, at lines c.
  struct Block {
    double n = 0, t = 0, r = 0, rr = 0, c = 0, cc = 0, cr = 0;
    double shift_us = 0;  ///< the residuals are relative to it
  };
  /// Follows the read-outs from block to block.
  class Follower {
   public:
    Follower(const Line& line, std::size_t lines, double block_us) : line_(line), lines_(lines), block_us_(block_us) {
      line_sums_.resize(lines);
      line_counts_.resize(lines);
    }
    void add(const Stamp& stamp);
    Readout readout() const;

   private:
    void measure_period(Readout& readout, const std::vector<Block>& blocks) const;
    void measure_scan(Readout& readout, const std::vector<Block>& blocks) const;
    void measure_jitter(Readout& readout, const std::vector<Block>& blocks) const;

    Line line_;
    std::size_t lines_;
    double block_us_;
    double block_end_us_ = 0;
    double expected_us_ = 0;  ///< residual, of the last block
    Block block_;
    std::vector<Block> blocks_;
    std::vector<double> line_sums_, line_counts_;
  };

  std::optional<Follower> found() const;
  std::optional<Line> line_along(Scan scan, double& coherence) const;
  std::size_t lines_along(Scan scan) const;

  static constexpr std::size_t most_kept = std::size_t{1} << 19;
  SensorSize size_;
  Extent extent_;
  std::optional<CameraTime> first_;
  std::vector<Stamp> kept_;
  std::optional<Follower> follower_;
  bool searched_ = false;
  std::int64_t step_us_ = 0;
  std::uint64_t events_ = 0;
};

}  // namespace tactile::events
