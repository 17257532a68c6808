#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tactile/core/measured.hpp"
#include "tactile/events/event.hpp"

namespace tactile::characterise {

/// Events that a pixel gives while the edge of a marker passes it, by polarity.
struct Passages {
  Measured on, off;                    ///< events per passage
  double on_count = 0, off_count = 0;  ///< passages, without those that the quiet recordings have too
};

/// A passage is a row of events of one pixel and one polarity, each at most 40 ms after the one before. An edge passes neighbours
/// too: at one of its events at least two of the eight neighbours have fired with its polarity within the last 5 ms.
class PassageMeter {
 public:
  static constexpr std::int64_t longest_pause_us = 40'000, together_us = 5'000;

  explicit PassageMeter(events::SensorSize size);

  /// A part of time; the uncertainty is the scatter of the parts.
  void begin_part() { parts_.emplace_back(); }
  /// One event, at us since the recording's first.
  void add(std::size_t pixel, bool on, std::int64_t t_us);
  void end_recording(double seconds);

  /// Those of `touched`, without as many as the quiet recordings show in the same time.
  friend Passages passages(const PassageMeter& touched, const PassageMeter& quiet);

 private:
  struct Row {
    std::int64_t latest = never;
    std::uint32_t events = 0;
    bool has_neighbours = false;
  };
  struct Sums {
    double passages = 0, events = 0;
  };
  static constexpr std::int64_t never = -1'000'000'000;
  bool neighbours_fire(std::size_t pixel, std::int64_t t_us, const std::vector<Row>& rows) const;
  void end_row(Row& row, std::size_t polarity);

  std::size_t width_, height_;
  std::array<std::vector<Row>, 2> rows_;  ///< by polarity
  std::vector<std::array<Sums, 2>> parts_;
  double seconds_ = 0;
};

Passages passages(const PassageMeter& touched, const PassageMeter& quiet);

}  // namespace tactile::characterise
