#include "tactile/detect/live_detector.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t chunk = 8192;  // events of what is played, counted ahead of their tick at the most
constexpr microseconds longest_wait{20'000};
constexpr microseconds late_window{1'000'000}, between_tellings_of_late{10'000'000};
constexpr std::size_t few_events = 128;           // counted in some microseconds
constexpr std::uint64_t few_events_a_tick = 256;  // likewise
constexpr microseconds waiting_period{250'000};

constexpr microseconds a_year = std::chrono::years{1};

double seconds_of(microseconds us) { return 1e-6 * static_cast<double>(us.count()); }

/// From one time of the host to another, within a year: a line may lie at the end of the clock.
microseconds passed(HostTime begin, HostTime end) {
  return std::clamp(microseconds{saturating_subtract(us_of(end), us_of(begin))}, -a_year, a_year);
}

}  // namespace

LiveDetector::LiveDetector(TickDetector detector, const LiveDetectorOptions& options, std::function<void(const ToldTick&)> tell,
                           TellFault fault, std::function<void()> forget)
    : detector_(std::move(detector)),
      options_(options),
      tell_(std::move(tell)),
      fault_(std::move(fault)),
      forget_(std::move(forget)),
      clock_(options.clock),
      deadlines_(options.clock.tick) {}

void LiveDetector::begin_anew(const char* kind, const std::string& text, HostTime at) {
  detector_.restart();
  clock_.restart();
  ++counts_.beginnings;
  last_arrival_.reset(), last_seen_.reset(), late_since_.reset(), hole_until_.reset(), rehearsal_.reset();
  least_waiting_ = {}, events_since_tick_ = 0;
  is_silent_ = lost_pending_ = false;
  catches_up_ = false;
  if (forget_) forget_();
  if (*kind != '\0') fault_({kind, text, at});
}

void LiveDetector::take(const QueuedPacket& packet) {
  const std::span<const Event> events = packet.elements.events;
  const HostTime at = packet.arrived;
  if (stream_ && *stream_ != packet.source_index) {
    // What arrived ahead of the change is told of first.
    while (!plays() && tell_due(at)) {
    }
    if (last_arrival_) begin_anew("", "", at);  // who changed the stream has said why
    catches_up_ = false;
  }
  stream_ = packet.source_index;
  if (events.empty()) return;
  if (catches_up_) return drop(packet.elements, at);
  if (is_silent_) fault_({"events again", fmt::format("events again after {:.1f} s", seconds_of(at - *last_arrival_)), at});
  is_silent_ = false;
  ++counts_.packets;
  events_since_tick_ += events.size();
  if (events_since_tick_ > few_events_a_tick || !packet.elements.arrived) least_waiting_ = {};
  if (packet.elements.more_came) together_ = at;
  plays() ? take_played(events, at) : take_live(events, at);
  last_arrival_ = at;
  // Where nothing waits behind it, it is the stream that has become late.
  if (plays() || !packet.elements.more_came || !clock_.line().is_known() || !clock_.last_event()) return;
  const microseconds behind = passed(clock_.line().host_of(*clock_.last_event()), at);
  if (behind >= options_.behind_for) begin_anew_without_what_waits(behind, at);
}

/// Reading alone is faster than counting: so it is caught up with, where it can be.
void LiveDetector::begin_anew_without_what_waits(microseconds behind, HostTime at) {
  std::string text;
  if (const std::uint64_t times = behind_.to_be_said(at))
    text = fmt::format(
        "events were read {:.1f} s late{}: more come than can be counted here, or they were held up; those that wait "
        "are dropped, and the history begins anew",
        seconds_of(behind), times > 1 ? fmt::format(", {} times", times) : "");
  begin_anew("behind", text, at);
  catches_up_ = true;
}

void LiveDetector::drop(const CameraPacket& packet, HostTime at) {
  counts_.lost_events += packet.events.size();
  catches_up_ = packet.more_came;
  if (!catches_up_ || at - *behind_.said < between_tellings_of_late) return;
  behind_.said = at;
  fault_({"behind", "there is no catching up: more events come than can be read here, and no verdict is told", at});
}

void LiveDetector::take_played(std::span<const Event> events, HostTime at) {
  for (; !events.empty() && !over_; events = events.subspan(std::min(chunk, events.size()))) {
    const std::span<const Event> part = events.first(std::min(chunk, events.size()));
    detector_.add(part);
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
      tell(*due, at);
    }
  }
}

void LiveDetector::take_live(std::span<const Event> events, HostTime at) {
  const CameraTime first = events.front().t, last = events.back().t;
  if (last_arrival_ && last_seen_) {
    const microseconds gap = between(*last_seen_, first), of_the_host = at - *last_arrival_;
    if (gap > of_the_host + options_.jump) {
      begin_anew(
          "jump",
          fmt::format("the camera's time jumped ahead by {:.3f} s; the history begins anew", seconds_of(gap - of_the_host)), at);
    }
  }
  if (!told_of_long_packets_ && between(first, last) > options_.clock.tick) {
    told_of_long_packets_ = true;
    fault_({"long packets",
            fmt::format("packets of up to {:.1f} ms and more, longer than the tick of {:.1f} ms: verdicts come later by as much; "
                        "expected a source that sends shorter ones",
                        1e3 * seconds_of(between(first, last)), 1e3 * seconds_of(options_.clock.tick)),
            at});
  }
  last_seen_ = last;
  const std::size_t late = clock_.too_late(events);
  counts_.late_events += late;
  note_late(events, late, at);
  const std::span<const Event> in_time = events.subspan(late);
  if (in_time.empty()) {
    if (!late_since_) late_since_ = at;
    if (at - *late_since_ < options_.late_for) return;
    std::string text;
    if (const std::uint64_t times = too_late_.to_be_said(at)) {
      text = fmt::format("every event came too late for {:.1f} s; ", seconds_of(at - *late_since_));
      text += times == 1
                  ? "the stream's delay has grown, and the history begins anew"
                  : fmt::format(
                        "the stream's delay grows on, and the history began anew {} times: its time runs slower than ours, "
                        "as of a sender that cannot keep up, or a file served at a --speed below 1",
                        times);
    }
    begin_anew("late", text, at);
    return;
  }
  late_since_.reset();
  if (std::exchange(lost_pending_, false)) hole_until_ = std::max(hole_until_.value_or(CameraTime::min()), in_time.front().t);
  detector_.add(in_time);
  counts_.events += in_time.size();
  clock_.arrived(first, last, at);
  const auto next = clock_.next_tick();
  if (next && last < *next) detector_.count_ahead(*next);  // while there is time: once it closes, a robot waits
}

std::uint64_t LiveDetector::Repeated::to_be_said(HostTime at) {
  const bool goes_on = last && at - *last < between_tellings_of_late;
  last = at;
  unsaid = goes_on ? unsaid + 1 : 1;
  if (said && at - *said < between_tellings_of_late) return 0;
  said = at;
  return std::exchange(unsaid, 0);
}

/// A few that are late tell nothing; a share that matters is told of, at most every ten seconds.
void LiveDetector::note_late(std::span<const Event> events, std::size_t late, HostTime at) {
  if (late > 0 && clock_.last_told()) latest_ = std::max(latest_, between(events.front().t, *clock_.last_told()));
  if (late > 0) hole_until_ = std::max(hole_until_.value_or(CameraTime::min()), after(events[late - 1].t, 1us));
  if (late_window_ == HostTime{}) late_window_ = at;
  window_events_ += events.size();
  window_late_ += late;
  if (at - late_window_ < late_window) return;
  if (100 * window_late_ > window_events_ && late_events_.to_be_said(at) > 0) {
    fault_({"late events",
            fmt::format(
                "{} of {} events within {:.1f} s came when their tick had been told, up to {:.1f} ms before, and are left out: "
                "verdicts lack them; expected a source that sends in time, or a slack of as much more than {:.1f} ms "
                "(--slack-us)",
                window_late_, window_events_, seconds_of(at - late_window_), 1e3 * seconds_of(latest_),
                1e3 * seconds_of(options_.clock.slack)),
            at});
  }
  late_window_ = at;
  window_events_ = window_late_ = 0;
  latest_ = {};
}

void LiveDetector::note_lost(std::uint64_t events_so_far) {
  if (events_so_far == lost_in_queue_) return;
  if (lost_in_queue_ == 0)
    fault_({"lost", "events come faster than they can be counted: some are dropped, and verdicts of such histories are marked",
            host_now()});
  counts_.lost_events += events_so_far - lost_in_queue_;
  lost_in_queue_ = events_so_far;
  lost_pending_ = true;
}

bool LiveDetector::tell_due(HostTime now, HostTime taken_until) {
  if (over_) return false;
  std::optional<DueTick> due = clock_.next(taken_until);
  if (!due) return false;
  if (!plays() && now - due->closed > options_.clock.tick) {
    if (const auto newest = clock_.newest(taken_until)) due = newest;
  }
  tell(*due, now);
  return true;
}

void LiveDetector::tell(const DueTick& due, HostTime now) {
  using Clock = std::chrono::steady_clock;
  ToldTick told;
  told.due = due;
  told.begun = now;
  TickCost cost;
  told.verdict = detector_.verdict_at(due.t, due.skipped, cost);
  told.number = deadlines_.counts().told;
  told.beginning = counts_.beginnings;
  told.last_arrival = last_arrival_;
  told.incomplete = lost_pending_ || (hole_until_ && before(due.t, options_.clock.history) < *hole_until_);
  counts_.gated += told.verdict.gated ? 1 : 0;
  counts_.by_host += due.by_events ? 0 : 1;
  counts_.incomplete += told.incomplete ? 1 : 0;
  TickTimes times{.waiting = {}, .queued = {}, .rendering = cost.rendering, .network = cost.network};
  if (!plays()) {
    const microseconds waited = passed(clock_.line().host_of(due.t), due.closed);
    times.waiting = waited;
    times.queued = passed(due.closed, told.begun);
    if (due.by_events && due.closed != together_) least_waiting_.add(waited, due.closed);
    events_since_tick_ = 0;
  }
  const Clock::time_point said = Clock::now();
  tell_(told);
  times.output = Clock::now() - said;
  deadlines_.add(times, due.skipped);
  clock_.told(due);
  plan_rehearsal(told, cost);
}

/// Halfway, roughly, to the packet that is to close the next tick: what is read later is the more surely still in the cache then,
/// but cold it may take twice as long as now, and packets do not come on the microsecond. Where the network takes so much of a
/// tick that it would have to begin at once there is none.
void LiveDetector::plan_rehearsal(const ToldTick& told, const TickCost& cost) {
  rehearsal_.reset();
  if (!options_.rehearses || plays() || !told.due.by_events || told.verdict.gated) return;
  const auto taken = std::chrono::duration_cast<microseconds>(cost.rendering + cost.network);
  const HostTime expected = told.due.closed + options_.clock.tick, from = expected - 4 * taken;
  if (from > told.begun + taken) rehearsal_ = {.from = from, .to = expected - 5 * taken / 2};
}

void LiveDetector::rehearse(HostTime now) {
  if (!rehearsal_ || now < rehearsal_->from) return;
  if (now < rehearsal_->to && detector_.rehearse()) ++counts_.rehearsals;
  rehearsal_.reset();
}

/// Whether the next tick is closed by an event, and not so late yet that it may have to be skipped.
bool LiveDetector::is_closed_in_time(HostTime now) const {
  const auto due = clock_.next(now);
  return due && due->by_events && now - due->closed <= options_.clock.tick;
}

HostTime LiveDetector::wakes_at(HostTime now) const {
  if (clock_.next(now)) return now;
  HostTime latest = now + longest_wait;
  if (rehearsal_ && rehearsal_->from > now) latest = std::min(latest, rehearsal_->from);
  return std::min(latest, clock_.next_by_host().value_or(latest));
}

void LiveDetector::LeastWaiting::add(microseconds waiting, HostTime at) {
  if (!this_period || at - period_begin >= waiting_period) {
    last_period = at - period_begin < 2 * waiting_period ? this_period : std::nullopt;
    this_period = waiting, period_begin = at;
  }
  this_period = std::min(*this_period, waiting);
}

HostTime LiveDetector::rests_until(HostTime now) const {
  const auto next = clock_.next_tick();
  const auto& [begin, last, current] = least_waiting_;
  if (plays() || !next || !last || !current || now - begin > 2 * waiting_period) return now;
  return std::max(now, clock_.line().host_of(*next) + std::min(*last, *current));
}

void LiveDetector::look_for_silence(HostTime now) {
  if (plays() || is_silent_ || !last_arrival_ || now - *last_arrival_ < options_.silence) return;
  is_silent_ = true;
  fault_({"silence",
          fmt::format("no event for {:.1f} s: the scene is still, or the stream stalls; verdicts go on",
                      seconds_of(now - *last_arrival_)),
          now});
}

void LiveDetector::look_for_stop(HostTime due, HostTime now) {
  if (plays() || !last_arrival_ || now - due < options_.stopped_for) return;
  begin_anew("stopped",
             fmt::format("the detector itself did nothing for {:.1f} s: it was stopped, or the machine did something else; the "
                         "history begins anew",
                         seconds_of(now - due)),
             now);
}

bool LiveDetector::awaits(std::span<const Event> events) const {
  return events.size() > few_events || events.empty() || events.back().t >= awaited_.load(std::memory_order_relaxed);
}

void LiveDetector::run(PacketSupply& supply, const std::function<bool()>& stop) {
  PacketQueue::Packet packet;
  HostTime taken_until{};  // as good as never
  stop_ = stop;
  for (bool open = true; open && !stop() && !over_;) {
    // An earlier one only wakes this too often. A stream that begins anew says so by an empty packet, which is always awaited.
    awaited_.store(plays() ? CameraTime::min() : clock_.next_tick().value_or(CameraTime::min()), std::memory_order_relaxed);
    const HostTime waited_from = host_now();
    const HostTime wakes = std::max(waited_from, wakes_at(waited_from));
    open = supply.next(packet, wakes - waited_from, std::min(wakes, rests_until(waited_from)) - waited_from);
    const HostTime begun = host_now();
    HostTime now = begun;
    look_for_stop(wakes, begun);
    if (packet.empty()) taken_until = std::min(now, wakes);
    while (!packet.empty()) {
      note_lost(supply.lost_events());
      take(packet.front());
      if (!packet.front().elements.more_came) taken_until = std::max(taken_until, packet.front().arrived);
      supply.give_back(std::exchange(packet, {}));
      now = host_now();
      // All that waits, but not for ever, nor while a tick waits whose events are all here.
      if (now - begun >= options_.clock.tick || is_closed_in_time(now)) break;
      supply.next(packet, {}, {});
      if (packet.empty()) taken_until = now;
    }
    if (!tell_due(now, taken_until)) rehearse(now);
    look_for_silence(taken_until);
    look_for_stop(now, host_now());
  }
  while (!stop() && tell_due(host_now())) {
  }
  stop_ = nullptr;
}

}  // namespace tactile
