#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tactile/characterise/flicker.hpp"
#include "tactile/characterise/passages.hpp"
#include "tactile/characterise/pixel_meters.hpp"
#include "tactile/core/measured.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/readout.hpp"

namespace tactile::characterise {

/// A pixel that fires by itself more than the others.
struct UnusualPixel {
  enum class Kind : std::uint8_t {
    warm,   ///< at least ten times the mean rate of ordinary pixels and ten events, but not hot
    hot,    ///< by the rule of `tactile info`
    stuck,  ///< at half of the read-outs or more
    lit     ///< one of these in step with light that flickers
  };
  Kind kind = Kind::hot;
  int x = 0, y = 0;
  Measured rate_hz;
  double on_share = 0;

  bool is_hot() const { return kind == Kind::hot || kind == Kind::stuck; }
};

/// The noise of the pixels that are not unusual. Rates are per pixel.
struct Background {
  Measured on_hz, off_hz;
  Measured spread_decades;  ///< between pixels, standard deviation of log10 of the rate
  Measured regularity;      ///< shape of the gamma distribution of a pixel's intervals; 1: Poisson
  Measured on_spread;       ///< between pixels, standard deviation of the share of ON events

  /// Events in bursts are those of a scene that moves or flickers, not of the sensor.
  bool is_disturbed() const { return regularity.value < 0.9; }
  double hz() const { return on_hz.value + off_hz.value; }
  double on_share() const { return hz() > 0 ? on_hz.value / hz() : 0.5; }
};

/// How many pixels are unusual. Uncertainties of numbers and shares are those between sensors of the same kind: sqrt(n) of n
/// pixels, with those that are near a limit.
struct UnusualPixels {
  Measured hot, stuck, warm;           ///< pixels
  Measured hot_share;                  ///< of the events, those of hot and stuck pixels
  Measured on_share;                   ///< mean over hot and warm pixels
  Measured regularity;                 ///< mean over hot and warm pixels: 1 - standard deviation / mean of their intervals
  std::size_t lit = 0;                 ///< pixels, which are no other kind
  std::vector<UnusualPixel> pixels{};  ///< most events first
};

/// Pixels without any event. A short recording leaves many ordinary pixels silent.
struct DeadPixels {
  Measured count;                           ///< silent ones minus expected ones, at least 0
  std::uint64_t silent = 0;                 ///< in all recordings, touched ones too
  double expected = 0;                      ///< silent ones by the noise of ordinary pixels that no touch made fire
  std::vector<std::pair<int, int>> places;  ///< x, y of the silent ones if they are known: fewer than one in two is expected;
                                            ///< 1000 at most

  /// Whether more pixels are silent than by chance, or chance explains none.
  bool is_known() const { return silent == 0 || expected <= 0.5 || count.value >= 2 * count.uncertainty; }
};

/// How long events wait in packets: an event can be used only when its packet is complete. AEDAT4 has no arrival times, so what
/// the host adds is not known.
struct PacketTimes {
  std::uint64_t packets = 0;
  Measured interval_us;   ///< from the last event of a packet to that of the next, median; half of the middle 68 % as uncertainty
  Measured wait_us;       ///< from an event to the last of its packet, mean over events
  double longest_us = 0;  ///< first to last event of a packet
  std::uint64_t back = 0;  ///< packets that begin before the end of the one before
};

/// What a sensor does, as recordings in which nothing touches it show it.
struct Sensor {
  std::vector<std::string> quiet, touched;  ///< the recordings
  std::string camera;
  events::SensorSize size;
  double seconds = 0;           ///< of the quiet recordings in which nothing moves
  double seconds_left_out = 0;  ///< of them in which something moves
  std::uint64_t events = 0;
  events::Readout readout;
  std::optional<PacketTimes> packets;  ///< if the format has packets
  Measured rate_hz, rate_without_hot_hz;
  Background background;
  UnusualPixels unusual;
  DeadPixels dead;
  Flicker flicker;
  Neighbours neighbours;
  std::optional<Measured> shortest_interval_us;
  std::optional<Measured> refractory_us;  ///< between two read-outs it is not known better
  LargestCounts largest, largest_ordinary;
  std::optional<Passages> passages;         ///< if there are touched recordings
  std::vector<double> background_rates_hz;  ///< of the ordinary pixels, quantiles at equal steps from 0 to 1, for the picture
};

}  // namespace tactile::characterise
