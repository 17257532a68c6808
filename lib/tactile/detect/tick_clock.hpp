#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/detect/arrival_line.hpp"
#include "tactile/events/event.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

struct TickClockOptions {
  microseconds tick{2'000};      ///< > 0
  microseconds history{40'000};  ///< a whole number of ticks, > 0
  microseconds slack{2'000};     ///< so long after its time on the host a tick waits for its events, >= 0
  bool by_events_alone = false;  ///< the host's time closes none: of what is played at any pace
};

/// A tick whose events are here, as far as they come at all.
struct DueTick {
  CameraTime t{};
  std::uint64_t skipped = 0;  ///< ticks between the last one told and this
  HostTime closed{};          ///< when it could first be told, had all been read at once that had come
  bool by_events = true;      ///< else by the host's time
};

/// The ticks of a stream as it comes: those of `full_ticks`, whole multiples of the tick of camera time whose history lies within
/// the stream. A tick t_c closes once an event at or after t_c is here, or once the host's time has passed
///
///   host_of(t_c) + max(slack, longest packet) + 100 ppm * (t_c - last event)
///
/// by the line below the arrivals, since a quiet scene sends nothing. The last term is what two clocks may drift apart in
/// silence. Right up to both ends of int64: where the clock ends there are no further ticks.
class TickClock {
 public:
  explicit TickClock(const TickClockOptions& options) : options_(options) { arrivals_.reserve(64); }

  /// Forgets the stream: what comes next is the begin of another. The longest packet is kept.
  void restart();

  /// How many of these events, from the first on, lie before a tick that was told, and are too late for it.
  std::size_t too_late(std::span<const Event> events) const;

  /// Events of one packet that are not too late, ascending, none before those of another call.
  void arrived(CameraTime first, CameraTime last, HostTime at);

  /// The next tick, if it is closed at `now`.
  std::optional<DueTick> next(HostTime now) const;
  /// The newest tick that is closed at `now`; those before it are `skipped`.
  std::optional<DueTick> newest(HostTime now) const;
  /// When the next tick closes if no event comes; nothing where that is never.
  std::optional<HostTime> next_by_host() const;

  void told(const DueTick& tick);  ///< it and all before it are over

  std::optional<CameraTime> next_tick()
      const;  ///< whether it is closed or not; nothing before the first event and where the clock ends
  TickRange ticks_until(CameraTime t) const;  ///< all of this stream, told or not, up to `t`; none before the first event
  std::optional<CameraTime> last_event() const { return last_event_; }
  std::optional<CameraTime> last_told() const { return last_told_; }
  microseconds longest_packet() const { return longest_packet_; }
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
  std::optional<CameraTime> first_event_, last_event_, last_told_;
  TickRange all_;                  ///< from the first event to the end of the clock
  std::int64_t next_ = 0;          ///< of `all_`: those before were told or skipped
  std::vector<Arrival> arrivals_;  ///< whose events close ticks not told yet, ascending
};

}  // namespace tactile
