#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "tactile/detect/deadline_monitor.hpp"
#include "tactile/detect/detection_fault.hpp"
#include "tactile/events/event.hpp"

namespace tactile::detect {

/// A fault that can occur again and again. It is reported at most every ten seconds.
class RepeatedFault {
 public:
  /// Counts an occurrence. @return  how often it occurred since the last report, this time included; 0: not to be reported yet
  std::uint64_t occurred(HostTime at);
  /// Whether a fault that lasts is to be reported again.
  bool is_due_again(HostTime at);

 private:
  std::optional<HostTime> last_, reported_;
  std::uint64_t unreported_ = 0;
};

/// Events that arrive after the verdict of their tick.
class LateEvents {
 public:
  /// @param limit  if all events are late for this long, the stream's delay has grown
  LateEvents(microseconds limit, ReportFault report) : limit_(limit), report_(std::move(report)) {}

  /// Counts one packet. Reports a fault if more than 1 % of the events within a second were late.
  /// @param late           number of `events`, from the first on, that were late
  /// @param last_reported  the last tick with a verdict, if any
  /// @param waits          how long ticks wait for late events at this time
  void add(std::span<const events::Event> events, std::size_t late, const std::optional<CameraTime>& last_reported,
           microseconds waits, HostTime at);

  /// The slack with which 99 % of the packets with late events would have been in time, in whole milliseconds. Nothing if no
  /// event was late, or if it is above 50 ms: then the source stalls, and no slack helps.
  std::optional<microseconds> proposed_slack() const;

  void in_time() { all_late_since_.reset(); }  ///< an event was in time
  /// All events of a packet were late. @return  a sentence, or an empty text, once this has lasted for `limit`
  std::optional<std::string> all_late(HostTime at);

 private:
  const microseconds limit_;
  ReportFault report_;
  RepeatedFault some_late_, delay_grew_;
  std::optional<HostTime> all_late_since_;
  HostTime window_begin_{};  ///< the following three are counted from here
  std::uint64_t window_events_ = 0, window_late_ = 0;
  microseconds latest_{0};      ///< largest delay after the last reported tick
  DurationHistogram needed_{};  ///< slack that each packet with late events needed
};

/// Events that were read late because others waited before them.
class Backlog {
 public:
  explicit Backlog(ReportFault report) : report_(std::move(report)) {}

  /// Events were read late. @return  a sentence, empty if reported shortly before
  std::string text_of(microseconds lateness, HostTime at);
  void begin_dropping() { drops_ = true; }  ///< from now on waiting packets are dropped
  void end_dropping() { drops_ = false; }
  bool drops() const { return drops_; }
  /// A packet was dropped. @param more_came  whether further ones wait
  void dropped(bool more_came, HostTime at);

 private:
  ReportFault report_;
  RepeatedFault read_late_;
  bool drops_ = false;
};

}  // namespace tactile::detect
