#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/detect/arrival_line.hpp"
#include "tactile/events/event.hpp"

namespace tactile::detect {

struct TickClockOptions {
  microseconds tick{2'000};      ///< > 0
  microseconds history{40'000};  ///< a whole number of ticks, > 0
  microseconds slack{2'000};     ///< a tick waits this long for late events, in host time, >= 0
  bool by_events_alone = false;  ///< the host's time closes no tick: for replays at any speed
};

/// A tick that is closed.
struct DueTick {
  CameraTime t{};
  std::uint64_t skipped = 0;  ///< ticks between the last reported tick and this one
  HostTime closed{};          ///< when it could first be reported, if packets were read as they arrive
  bool by_events = true;      ///< closed by events; else by the host's time
};

/// Closes the ticks of a live stream: those of `full_ticks`, whole multiples of the tick in camera time whose history lies within
/// the stream. A tick t_c closes when an event at or after t_c has arrived, or when the host's time has passed
///
///   host_of(t_c) + max(slack, longest packet) + 100 ppm * (t_c - last event)
///
/// with host_of of `ArrivalLine`, since a quiet scene sends nothing. The last term is the drift of two clocks during a silence.
/// Valid up to both ends of int64: there are no ticks beyond the end of the clock.
class TickClock {
 public:
  explicit TickClock(const TickClockOptions& options) : options_(options) { arrivals_.reserve(64); }

  /// Starts a new stream. Keeps the longest packet.
  void restart();

  /// How many of these events, from the first on, are earlier than the last reported tick, and therefore too late.
  std::size_t too_late(std::span<const events::Event> events) const;

  /// Events of one packet that are not too late, ascending from call to call.
  void arrived(CameraTime first, CameraTime last, HostTime at);

  /// The next tick, if it is closed at `now`.
  std::optional<DueTick> next(HostTime now) const;
  /// The newest tick that is closed at `now`; those before it are `skipped`.
  std::optional<DueTick> newest(HostTime now) const;
  /// When the next tick closes if no event arrives; nothing if never.
  std::optional<HostTime> next_by_host() const;

  void reported(const DueTick& tick);  ///< ends it and all ticks before it

  /// The next tick, closed or not; nothing before the first event, and at the end of the clock.
  std::optional<CameraTime> next_tick() const;
  TickRange ticks_until(CameraTime t) const;  ///< all ticks of this stream up to `t`; none before the first event
  std::optional<CameraTime> first_event() const { return first_event_; }  ///< of this stream
  std::optional<CameraTime> last_event() const { return last_event_; }
  std::optional<CameraTime> last_reported() const { return last_reported_; }
  microseconds longest_packet() const { return longest_packet_; }
  microseconds waits() const { return std::max(options_.slack, longest_packet_); }  ///< a tick, for late events
  const ArrivalLine& line() const { return line_; }

 private:
  struct Arrival {
    CameraTime last;
    HostTime at;
  };
  HostTime closes_at(CameraTime tick) const;
  std::optional<DueTick> due(std::int64_t index, HostTime now) const;
  bool host_closes() const { return !options_.by_events_alone && line_.is_known(); }

  TickClockOptions options_;
  ArrivalLine line_;
  microseconds longest_packet_{0};
  std::optional<CameraTime> first_event_, last_event_, last_reported_;
  TickRange all_;                  ///< from the first event to the end of the clock
  std::int64_t next_ = 0;          ///< index in `all_`: earlier ticks were reported or skipped
  std::vector<Arrival> arrivals_;  ///< packets that close ticks that are not reported yet, ascending
};

}  // namespace tactile::detect
