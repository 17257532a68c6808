#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "tactile/capture/packet_queue.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/detect/deadline_monitor.hpp"
#include "tactile/detect/detection_fault.hpp"
#include "tactile/detect/late_events.hpp"
#include "tactile/detect/packet_supply.hpp"
#include "tactile/detect/quiet_stream.hpp"
#include "tactile/detect/rehearsal.hpp"
#include "tactile/detect/reported_tick.hpp"
#include "tactile/detect/scene_watch.hpp"
#include "tactile/detect/tick_clock.hpp"
#include "tactile/detect/tick_detector.hpp"

namespace tactile::detect {

struct LiveDetectorOptions {
  TickClockOptions clock;           ///< `by_events_alone`, for replays at any speed: every tick is reported, however late
  microseconds silence{2'000'000};  ///< without an event for this long, a silence is reported
  microseconds jump{1'000'000};     ///< the camera's time jumped if it is this far ahead of the host's
  /// Of a replay: ticks this long after the first one are not reported.
  microseconds play_for = microseconds::max();
  microseconds late_for{500'000};          ///< if all events are late for this long, the stream's delay has grown
  microseconds longest_lateness{500'000};  ///< if events are read this late while others wait, the waiting ones are dropped
  microseconds stopped_for{500'000};       ///< if the detector does nothing for this long, it was stopped
  /// Run the network once without use between two ticks, so that its weights are in the cache when the second one closes. Not
  /// after a tick that the host's time closed.
  bool rehearses = false;
  SceneWatch* scene = nullptr;  ///< gets the events that are counted, if there is one; must outlive the detector
};

struct LiveCounts {
  std::uint64_t events = 0;                   ///< counted in a tick, or waiting for one
  std::uint64_t late_events = 0;              ///< after the verdict of their tick; left out
  std::uint64_t lost_events = 0;              ///< dropped before the detector, for lack of room or of time
  std::uint64_t packets = 0;                  ///< with events
  std::uint64_t by_host = 0, incomplete = 0;  ///< reported ticks
  std::uint64_t rehearsals = 0;
  std::uint32_t beginnings = 0;  ///< restarts of the stream
};

/// Verdicts from packets of events as they arrive. Its clock closes the ticks, and they are reported in order. If ticks close
/// faster than they can be reported, the newest is reported and those before it are skipped. If the stream jumps in time, grows
/// late or is opened again, the history starts again. The host's time is a parameter: only `run` reads the clock.
class LiveDetector {
 public:
  /// @param report  called with each tick once it has a verdict; its time counts as the tick's output
  /// @param fault   called with each fault
  /// @param forget  called when the stream restarts: there is no verdict until the next tick
  LiveDetector(TickDetector detector, const LiveDetectorOptions& options, std::function<void(const ReportedTick&)> report,
               ReportFault fault, std::function<void()> forget = {});

  /// Counts the events of a packet. If its `source_index` is new, the stream restarts. Ticks of a replay are reported at once.
  /// @throws Error  if events lie outside the sensor or are not ascending, or if a replay has more than `most_ticks` ticks
  void take(const capture::QueuedPacket& packet);

  /// Reports the next tick that is due, or the newest. @return  false if none is due
  /// @param taken_until  packets that arrived until then have been taken, later ones may wait: the host's time closes no later
  /// tick
  bool report_due(HostTime now, HostTime taken_until);
  bool report_due(HostTime now) { return report_due(now, now); }  ///< all packets that arrived have been taken
  HostTime wakes_at(HostTime now) const;                          ///< when there is something to do if no packet arrives
  /// Until when packets can wait unread: no packet that closes the next tick arrives earlier, as estimated by `QuietStream`.
  /// `now` if the stream is busy or not yet known.
  HostTime rests_until(HostTime now) const;
  void check_silence(HostTime now);
  /// Restarts if work that was due at `due` was only done at `now`, much later: what waits belongs to the past.
  void check_stop(HostTime due, HostTime now);
  void rehearse(HostTime now);                  ///< runs the network without use if a run is due
  void note_lost(std::uint64_t events_so_far);  ///< events that the queue had no room for, in total

  /// Whether `run` must wake up for a packet: it closes a tick, or has so many events that counting them later takes long. Other
  /// packets can wait until `run` wakes by itself. Waking a thread takes some microseconds, which is most of the work of a quiet
  /// scene. Any thread may call it.
  bool awaits(std::span<const events::Event> events) const;

  /// Takes packets by the host's clock until there are no more, or `stop` returns true.
  void run(PacketSupply& supply, const std::function<bool()>& stop);

  const LiveCounts& counts() const { return counts_; }
  const DeadlineMonitor& deadlines() const { return deadlines_; }
  const LateEvents& late_events() const { return late_events_; }
  const TickClock& clock() const { return clock_; }

 private:
  bool plays() const { return options_.clock.by_events_alone; }
  bool is_closed_in_time(HostTime now) const;
  void restart(const char* kind, const std::string& text, HostTime at);
  void drop(const capture::CameraPacket& packet, HostTime at);
  void take_played(std::span<const events::Event> events, HostTime at);
  void take_live(std::span<const events::Event> events, HostTime at);
  void check_jump(CameraTime first, HostTime at);
  void check_length(microseconds span, HostTime at);
  HostTime take_waiting(PacketSupply& supply, capture::PacketQueue::Packet& packet, HostTime begun, HostTime& taken_until);
  void report(const DueTick& due, HostTime now);

  TickDetector detector_;
  LiveDetectorOptions options_;
  std::function<void(const ReportedTick&)> report_;
  ReportFault fault_;
  std::function<void()> forget_;
  TickClock clock_;
  DeadlineMonitor deadlines_;
  LiveCounts counts_;
  LateEvents late_events_;
  Backlog backlog_;
  Rehearsal rehearsal_;
  QuietStream quiet_stream_;

  std::optional<std::size_t> stream_;     ///< `source_index` of the packets
  std::optional<HostTime> last_arrival_;  ///< of events since the last restart
  std::optional<CameraTime> last_seen_;   ///< the last of these events, including late ones
  std::optional<CameraTime> hole_until_;  ///< histories that begin earlier lack events
  bool lost_pending_ = false;             ///< events were lost after the last event counted
  std::uint64_t lost_in_queue_ = 0;
  bool is_silent_ = false, has_reported_long_packets_ = false;
  HostTime together_{};  ///< the last arrival time that belongs to later packets, too

  std::atomic<CameraTime> awaited_{CameraTime::min()};  ///< events before it close no tick
  std::function<bool()> stop_;                          ///< while `run` works: one packet of a replay can close millions of ticks
  std::optional<CameraTime> first_played_;
  bool over_ = false;  ///< a replay has lasted for `play_for`
};

}  // namespace tactile::detect
