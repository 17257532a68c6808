#include "tactile/detect/live_detector.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile::detect {
namespace {

constexpr std::size_t chunk = 8192;  // events of a replay that are counted before their tick, at most
constexpr microseconds longest_wait{20'000};
constexpr std::size_t few_events = 128;  // counted in some microseconds
constexpr microseconds a_year = std::chrono::years{1};

/// The time between two host times, limited to a year: `ArrivalLine` may return the end of the clock.
microseconds passed(HostTime begin, HostTime end) {
  return std::clamp(microseconds{saturating_subtract(us_of(end), us_of(begin))}, -a_year, a_year);
}

}  // namespace

LiveDetector::LiveDetector(TickDetector detector, const LiveDetectorOptions& options,
                           std::function<void(const ReportedTick&)> report, ReportFault fault, std::function<void()> forget)
    : detector_(std::move(detector)),
      options_(options),
      report_(std::move(report)),
      fault_(std::move(fault)),
      forget_(std::move(forget)),
      clock_(options.clock),
      deadlines_(options.clock.tick),
      late_events_(options.late_for, fault_),
      backlog_(fault_) {}

void LiveDetector::restart(const char* kind, const std::string& text, HostTime at) {
  detector_.restart();
  if (options_.scene != nullptr) options_.scene->restart();
  clock_.restart();
  late_events_.in_time();
  rehearsal_.cancel();
  quiet_stream_.restart();
  backlog_.end_dropping();
  ++counts_.beginnings;
  last_arrival_.reset(), last_seen_.reset(), hole_until_.reset();
  is_silent_ = lost_pending_ = false;
  if (forget_) forget_();
  if (*kind != '\0') fault_({kind, text, at});
}

void LiveDetector::take(const capture::QueuedPacket& packet) {
  const std::span<const events::Event> events = packet.elements.events;
  const HostTime at = packet.arrived;
  if (stream_ && *stream_ != packet.source_index) {
    // First report the ticks that closed before the change.
    while (!plays() && report_due(at)) {
    }
    if (last_arrival_) restart("", "", at);  // the event feed has reported why
    backlog_.end_dropping();
  }
  stream_ = packet.source_index;
  if (events.empty()) return;
  if (backlog_.drops()) return drop(packet.elements, at);
  if (is_silent_) fault_({"events again", fmt::format("events again after {:.1f} s", in_s(at - *last_arrival_)), at});
  is_silent_ = false;
  ++counts_.packets;
  quiet_stream_.packet(events.size(), packet.elements.arrived.has_value());
  if (packet.elements.more_came) together_ = at;
  plays() ? take_played(events, at) : take_live(events, at);
  last_arrival_ = at;
  // If no packet waits after this one, the stream itself is late.
  if (plays() || !packet.elements.more_came || !clock_.line().is_known() || !clock_.last_event()) return;
  const microseconds lateness = passed(clock_.line().host_of(*clock_.last_event()), at);
  if (lateness < options_.longest_lateness) return;
  restart("behind", backlog_.text_of(lateness, at), at);
  backlog_.begin_dropping();
}

void LiveDetector::drop(const capture::CameraPacket& packet, HostTime at) {
  counts_.lost_events += packet.events.size();
  if (options_.scene != nullptr) options_.scene->lose(packet.events.size());
  backlog_.dropped(packet.more_came, at);
}

void LiveDetector::take_played(std::span<const events::Event> events, HostTime at) {
  for (; !events.empty() && !over_; events = events.subspan(std::min(chunk, events.size()))) {
    const std::span<const events::Event> part = events.first(std::min(chunk, events.size()));
    detector_.add(part);
    if (options_.scene != nullptr) options_.scene->add(part);
    counts_.events += part.size();
    clock_.arrived(part.front().t, part.back().t, at);
    TickRange ticks = clock_.ticks_until(part.back().t);
    ticks.count = std::min(ticks.count - 1, options_.play_for / options_.clock.tick) + 1;
    if (const std::string why = why_too_many(ticks); !why.empty()) throw Error(why);
    while (const auto due = clock_.next(at)) {
      if (stop_ && stop_()) return;
      if (!first_played_) first_played_ = due->t;
      over_ = between(*first_played_, due->t) >= options_.play_for;
      if (over_) return;
      report(*due, at);
    }
  }
}

void LiveDetector::check_jump(CameraTime first, HostTime at) {
  if (!last_arrival_ || !last_seen_) return;
  const microseconds gap = between(*last_seen_, first), of_the_host = at - *last_arrival_;
  if (gap <= of_the_host + options_.jump) return;
  restart("jump", fmt::format("the camera's time jumped ahead by {:.3f} s; the history starts again", in_s(gap - of_the_host)),
          at);
}

void LiveDetector::check_length(microseconds span, HostTime at) {
  if (has_reported_long_packets_ || span <= options_.clock.tick) return;
  has_reported_long_packets_ = true;
  fault_(
      {"long packets",
       fmt::format("packets of {:.1f} ms and more are longer than the tick of {:.1f} ms, so that verdicts come later; expected "
                   "a source that sends shorter ones",
                   in_ms(span), in_ms(options_.clock.tick)),
       at});
}

void LiveDetector::take_live(std::span<const events::Event> events, HostTime at) {
  const CameraTime first = events.front().t, last = events.back().t;
  check_jump(first, at);
  check_length(between(first, last), at);
  last_seen_ = last;
  const std::size_t late = clock_.too_late(events);
  counts_.late_events += late;
  late_events_.add(events, late, clock_.last_reported(), clock_.waits(), at);
  const auto lacks_events_until = [this](CameraTime t) { hole_until_ = std::max(hole_until_.value_or(CameraTime::min()), t); };
  if (late > 0) lacks_events_until(after(events[late - 1].t, 1us));
  if (options_.scene != nullptr) options_.scene->lose(late);
  const std::span<const events::Event> in_time = events.subspan(late);
  if (in_time.empty()) {
    if (const auto text = late_events_.all_late(at)) restart("late", *text, at);
    return;
  }
  late_events_.in_time();
  if (std::exchange(lost_pending_, false)) lacks_events_until(in_time.front().t);
  detector_.add(in_time);
  if (options_.scene != nullptr) options_.scene->add(in_time);
  counts_.events += in_time.size();
  clock_.arrived(first, last, at);
  const auto next = clock_.next_tick();
  if (next && last < *next) detector_.count_ahead(*next);  // now there is time; once the tick closes, a robot waits
}

void LiveDetector::note_lost(std::uint64_t events_so_far) {
  if (events_so_far == lost_in_queue_) return;
  if (lost_in_queue_ == 0)
    fault_({"lost", "events arrive faster than they can be counted: some are dropped, and verdicts without them are marked",
            host_now()});
  counts_.lost_events += events_so_far - lost_in_queue_;
  if (options_.scene != nullptr) options_.scene->lose(events_so_far - lost_in_queue_);
  lost_in_queue_ = events_so_far;
  lost_pending_ = true;
}

bool LiveDetector::report_due(HostTime now, HostTime taken_until) {
  if (over_) return false;
  std::optional<DueTick> due = clock_.next(taken_until);
  if (!due) return false;
  if (!plays() && now - due->closed > options_.clock.tick) {
    if (const auto newest = clock_.newest(taken_until)) due = newest;
  }
  report(*due, now);
  return true;
}

void LiveDetector::report(const DueTick& due, HostTime now) {
  using Clock = std::chrono::steady_clock;
  ReportedTick tick;
  tick.due = due;
  tick.begun = now;
  TickCost cost;
  tick.verdict = detector_.verdict_at(due.t, due.skipped, cost);
  tick.number = deadlines_.counts().reported;
  tick.beginning = counts_.beginnings;
  tick.first_event = clock_.first_event().value_or(due.t);
  tick.last_arrival = last_arrival_;
  tick.incomplete = lost_pending_ || (hole_until_ && before(due.t, options_.clock.history) < *hole_until_);
  counts_.by_host += due.by_events ? 0 : 1;
  counts_.incomplete += tick.incomplete ? 1 : 0;
  tick.late_events = counts_.late_events;
  tick.lost_events = counts_.lost_events;
  TickTimes times{.waiting = {}, .queued = {}, .rendering = cost.rendering, .network = cost.network};
  if (!plays()) {
    const microseconds waited = passed(clock_.line().host_of(due.t), due.closed);
    times.waiting = waited;
    times.queued = passed(due.closed, now);
    tick.lateness = *times.queued + cost.rendering + cost.network;
    if (due.by_events && due.closed != together_) quiet_stream_.tick(waited, due.closed);
    quiet_stream_.tick_reported();
  }
  const Clock::time_point output_begun = Clock::now();
  report_(tick);
  times.output = Clock::now() - output_begun;
  deadlines_.add(times, due.skipped);
  clock_.reported(due);
  rehearsal_.cancel();
  if (options_.rehearses && !plays() && due.by_events)
    rehearsal_.plan(due.closed + options_.clock.tick, std::chrono::duration_cast<microseconds>(cost.rendering + cost.network),
                    now);
}

void LiveDetector::rehearse(HostTime now) {
  if (!rehearsal_.is_due(now)) return;
  detector_.rehearse();
  ++counts_.rehearsals;
}

/// Whether an event has closed the next tick, and the tick is not so late that it may be skipped.
bool LiveDetector::is_closed_in_time(HostTime now) const {
  const auto due = clock_.next(now);
  return due && due->by_events && now - due->closed <= options_.clock.tick;
}

HostTime LiveDetector::wakes_at(HostTime now) const {
  if (clock_.next(now)) return now;
  const HostTime latest = std::min(now + longest_wait, rehearsal_.begins_after(now).value_or(HostTime::max()));
  return std::min(latest, clock_.next_by_host().value_or(latest));
}

HostTime LiveDetector::rests_until(HostTime now) const {
  const auto next = clock_.next_tick();
  const auto waiting = quiet_stream_.least_waiting(now);
  if (plays() || !next || !waiting) return now;
  return std::max(now, clock_.line().host_of(*next) + *waiting);
}

void LiveDetector::check_silence(HostTime now) {
  if (plays() || is_silent_ || !last_arrival_ || now - *last_arrival_ < options_.silence) return;
  is_silent_ = true;
  fault_({"silence",
          fmt::format("no event for {:.1f} s: the scene is still, or the stream stalls; verdicts continue",
                      in_s(now - *last_arrival_)),
          now});
}

void LiveDetector::check_stop(HostTime due, HostTime now) {
  if (plays() || !last_arrival_ || now - due < options_.stopped_for) return;
  restart("stopped",
          fmt::format("detect itself did nothing for {:.1f} s: it was stopped, or the machine was busy with something else; the "
                      "history starts again",
                      in_s(now - due)),
          now);
}

bool LiveDetector::awaits(std::span<const events::Event> events) const {
  return events.size() > few_events || events.empty() || events.back().t >= awaited_.load(std::memory_order_relaxed);
}

/// Takes `packet` and those that wait after it, for a tick's time at most, and not while a tick is due whose events are all here.
/// @return  the host's time afterwards
HostTime LiveDetector::take_waiting(PacketSupply& supply, capture::PacketQueue::Packet& packet, HostTime begun,
                                    HostTime& taken_until) {
  HostTime now = begun;
  while (!packet.empty()) {
    note_lost(supply.lost_events());
    take(packet.front());
    if (!packet.front().elements.more_came) taken_until = std::max(taken_until, packet.front().arrived);
    supply.give_back(std::exchange(packet, {}));
    now = host_now();
    if (now - begun >= options_.clock.tick || is_closed_in_time(now)) break;
    supply.next(packet, {}, {});
    if (packet.empty()) taken_until = now;
  }
  return now;
}

void LiveDetector::run(PacketSupply& supply, const std::function<bool()>& stop) {
  capture::PacketQueue::Packet packet;
  HostTime taken_until{};  // long ago
  stop_ = stop;
  for (bool open = true; open && !stop() && !over_;) {
    // After a restart this time may be too early, which only wakes this thread too often. The feed marks a restart by an empty
    // packet, which is always awaited.
    awaited_.store(plays() ? CameraTime::min() : clock_.next_tick().value_or(CameraTime::min()), std::memory_order_relaxed);
    const HostTime waited_from = host_now();
    const HostTime wakes = std::max(waited_from, wakes_at(waited_from));
    open = supply.next(packet, wakes - waited_from, std::min(wakes, rests_until(waited_from)) - waited_from);
    const HostTime begun = host_now();
    check_stop(wakes, begun);
    if (packet.empty()) taken_until = std::min(begun, wakes);
    const HostTime now = take_waiting(supply, packet, begun, taken_until);
    if (!report_due(now, taken_until)) rehearse(now);
    check_silence(taken_until);
    check_stop(now, host_now());
  }
  while (!stop() && report_due(host_now())) {
  }
  stop_ = nullptr;
}

}  // namespace tactile::detect
