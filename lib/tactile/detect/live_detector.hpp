#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "tactile/capture/packet_queue.hpp"
#include "tactile/detect/deadline_monitor.hpp"
#include "tactile/detect/packet_supply.hpp"
#include "tactile/detect/tick_clock.hpp"
#include "tactile/detect/tick_detector.hpp"

namespace tactile {

/// What went wrong on the way of the events or the verdicts, and what was done.
struct DetectionFault {
  std::string kind;  ///< "broken", "back", "gave up", "unsound", "jump", "silence", "events again", "stopped", "late",
                     ///< "late events", "behind", "long packets", "lost", "robot", "udp", "recording"
  std::string text;  ///< a sentence; empty where the like was said a moment ago
  HostTime at{};
};
using TellFault = std::function<void(const DetectionFault&)>;

/// A tick as it is told.
struct ToldTick {
  TickVerdict verdict;
  DueTick due;
  std::uint64_t number = 0;              ///< of the ticks told, from 0
  std::uint32_t beginning = 0;           ///< how often the stream began anew: no verdict has events of two beginnings
  bool incomplete = false;               ///< events of its history are known to be lost
  HostTime begun{};                      ///< when it was worked on
  std::optional<HostTime> last_arrival;  ///< of events, whichever they are
};

struct LiveDetectorOptions {
  TickClockOptions clock;  ///< `by_events_alone`: every tick is told, none skipped, however late; of what is played at any pace
  microseconds silence{2'000'000};  ///< after it, that nothing comes is said
  microseconds jump{1'000'000};     ///< the camera's time is so far ahead of the host's: it jumped
  /// Of what is played: no tick is told that comes so long after the first one.
  microseconds play_for = microseconds::max();
  microseconds late_for{500'000};     ///< all events have come too late for so long: the stream is another one
  microseconds behind_for{500'000};   ///< what is read came to the host's knowledge so late: it is not kept up with
  microseconds stopped_for{500'000};  ///< so long nothing was done that should have been: the detector itself was stopped
  /// Between two ticks, of which the gate did not spare the first, the network is run once for nothing: its weights would else
  /// have left the cache until the second one closes. Not while ticks are closed by the host's time.
  bool rehearses = false;
};

struct LiveCounts {
  std::uint64_t events = 0;                              ///< counted in some tick or waiting for one
  std::uint64_t late_events = 0;                         ///< of a tick that was told already; left out
  std::uint64_t lost_events = 0;                         ///< for which there was no room ahead of the detector, or no time
  std::uint64_t packets = 0;                             ///< with events
  std::uint64_t gated = 0, by_host = 0, incomplete = 0;  ///< ticks told
  std::uint64_t rehearsals = 0;
  std::uint32_t beginnings = 0;
};

/// Verdicts from packets of events as they come: ticks closed by their clock, told in order, and what becomes of a stream that
/// stalls, jumps in time or begins anew. Where ticks come too fast to be told within a tick, the newest is told and those before
/// it are skipped. The host's time is always handed in; only `run` looks at the clock.
class LiveDetector {
 public:
  /// @param tell   told of each tick as soon as there is a verdict; what it takes is the tick's output
  /// @param fault  told of each fault
  /// @param forget  told when the stream begins anew: no verdict is known until the next one
  LiveDetector(TickDetector detector, const LiveDetectorOptions& options, std::function<void(const ToldTick&)> tell,
               TellFault fault, std::function<void()> forget = {});

  /// A packet; where `source_index` is another than before the stream began anew, and whatever was known of it is forgotten.
  /// Ticks of a stream that is closed by events alone are told at once.
  /// @throws Error  if events lie outside the sensor or go back in time, or if what is played has come to over `most_ticks`
  void take(const QueuedPacket& packet);

  /// The next tick that is due, or the newest; false if none is.
  /// @param taken_until  what arrived until then has been taken, later packets may wait: the host's time closes no tick behind it
  bool tell_due(HostTime now, HostTime taken_until);
  bool tell_due(HostTime now) { return tell_due(now, now); }  ///< all that arrived has been taken
  HostTime wakes_at(HostTime now) const;                      ///< when there is something to do if nothing comes
  /// Until when packets of a quiet stream may lie: the packet that closes the next tick has not come earlier for a while, and to
  /// count what comes ahead of it takes nothing. One that does come earlier is seen so much later, once. `now` of a busy stream,
  /// or one that is not known for long.
  HostTime rests_until(HostTime now) const;
  void look_for_silence(HostTime now);
  /// Begins anew where much should have been done by `due`, and was not until `now`: what waits is of another time.
  void look_for_stop(HostTime due, HostTime now);
  void rehearse(HostTime now);                  ///< if it is time, and enough is left until the next tick closes
  void note_lost(std::uint64_t events_so_far);  ///< what the queue had no room for, all in all

  /// Whether `run` has something to do once a packet is there: it closes a tick, or counting it all at the tick's end would take
  /// a while. Others may wait in the queue until `run` wakes by itself: a thread is woken at a cost of some microseconds, which
  /// is most of what a quiet scene takes. On any thread.
  bool awaits(std::span<const Event> events) const;

  /// Takes packets until there are no more, or `stop` says so, by the host's clock.
  void run(PacketSupply& supply, const std::function<bool()>& stop);

  const LiveCounts& counts() const { return counts_; }
  const DeadlineMonitor& deadlines() const { return deadlines_; }
  const TickClock& clock() const { return clock_; }

 private:
  bool is_closed_in_time(HostTime now) const;
  void note_late(std::span<const Event> events, std::size_t late, HostTime at);
  bool plays() const { return options_.clock.by_events_alone; }
  void begin_anew(const char* kind, const std::string& text, HostTime at);
  void begin_anew_without_what_waits(microseconds behind, HostTime at);
  void drop(const CameraPacket& packet, HostTime at);
  void take_played(std::span<const Event> events, HostTime at);
  void take_live(std::span<const Event> events, HostTime at);
  void tell(const DueTick& due, HostTime now);
  void plan_rehearsal(const ToldTick& told, const TickCost& cost);

  TickDetector detector_;
  LiveDetectorOptions options_;
  std::function<void(const ToldTick&)> tell_;
  TellFault fault_;
  std::function<void()> forget_;
  TickClock clock_;
  DeadlineMonitor deadlines_;
  LiveCounts counts_;
  std::optional<std::size_t> stream_;     ///< `source_index` of the packets
  std::optional<HostTime> last_arrival_;  ///< of events of this beginning
  std::optional<CameraTime> last_seen_;   ///< of them, those that came too late among them
  std::optional<HostTime> late_since_;    ///< from when on no event was in time
  /// A fault that may come again and again, whichever beginning it ends: said at most every ten seconds.
  struct Repeated {
    std::optional<HostTime> last, said;
    std::uint64_t unsaid = 0;
    std::uint64_t to_be_said(HostTime at);  ///< how many since it was last said, this one among them; 0: it is not yet to be
  };
  Repeated too_late_, behind_, late_events_;
  bool catches_up_ = false;               ///< what waits is dropped
  std::optional<CameraTime> hole_until_;  ///< histories that begin before it lack events
  std::uint64_t lost_in_queue_ = 0;
  std::atomic<CameraTime> awaited_{CameraTime::min()};  ///< events before it close no tick
  /// When to rehearse, as the packet that closes the next tick comes a tick after the one that closed the last.
  struct Rehearsal {
    HostTime from{}, to{};
  };
  std::optional<Rehearsal> rehearsal_;  ///< not yet over
  /// The least that ticks closed by events have waited, of one or two periods of the host's time.
  struct LeastWaiting {
    HostTime period_begin{};
    std::optional<microseconds> last_period, this_period;
    void add(microseconds waiting, HostTime at);
  };
  LeastWaiting least_waiting_;
  std::uint64_t events_since_tick_ = 0;
  HostTime together_{};  ///< the last arrival known only as that of later packets, too
  std::optional<CameraTime> first_played_;
  std::function<bool()> stop_;  ///< while `run` works: one packet of what is played may be followed by hours of ticks
  bool over_ = false;
  HostTime late_window_{};  ///< since when the next three are counted
  std::uint64_t window_events_ = 0, window_late_ = 0;
  microseconds latest_{0};  ///< behind the tick told last
  bool is_silent_ = false, told_of_long_packets_ = false, lost_pending_ = false;
};

}  // namespace tactile
