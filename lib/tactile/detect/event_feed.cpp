#include "tactile/detect/event_feed.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile::detect {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds source_patience{50};  // after which the thread checks whether to stop
constexpr milliseconds first_pause{50}, longest_pause{1'000};
constexpr microseconds between_drop_reports{1'000'000};

}  // namespace

const events::Stream& events_of(const capture::CameraSource& source) {
  for (const events::Stream& stream : source.streams()) {
    if (stream.type != events::StreamType::events) continue;
    if (stream.size) return stream;
    throw Error(source.name() + ": its events declare no size; expected the sensor's");
  }
  throw Error(source.name() + ": has no stream of events; expected one");
}

EventFeed::EventFeed(std::unique_ptr<capture::CameraSource> source, capture::PacketQueue& queue, EventFeedOptions options)
    : source_(std::move(source)),
      queue_(queue),
      options_(std::move(options)),
      name_(source_->name()),
      sensor_(*events_of(*source_).size) {}

EventFeed::~EventFeed() { stop(); }

void EventFeed::start() {
  thread_ = std::thread([this] { options_.receives_ahead ? receive_all() : open_when_lost(); });
}

void EventFeed::stop() {
  {
    const std::scoped_lock lock(guard_);
    stops_ = true;
  }
  wake_.notify_all();
  queue_.close();  // ends a wait for room
  if (thread_.joinable()) thread_.join();
}

std::string EventFeed::error() const {
  const std::scoped_lock lock(guard_);
  return error_;
}

std::optional<microseconds> EventFeed::gave_up_after() const {
  const std::scoped_lock lock(guard_);
  return gave_up_after_;
}

capture::SourceDrops EventFeed::drops() const {
  const std::scoped_lock lock(guard_);
  capture::SourceDrops drops = drops_of_earlier_;
  return drops += drops_;
}

void EventFeed::report(const char* kind, const std::string& text) const { options_.fault({kind, text, host_now()}); }

void EventFeed::receive_all() {
  if (options_.prepare) options_.prepare();
  packet_ = queue_.take();
  const auto stops = [this] {
    const std::scoped_lock lock(guard_);
    return stops_;
  };
  for (bool continues = true; continues && !stops();) {
    switch (receive(source_patience)) {
      case Outcome::packet:
        hand_over();
        break;
      case Outcome::nothing:
        break;
      case Outcome::lost:
        if (queue_.push(packet_, true)) packet_ = queue_.take();
        continues = open_again();
        break;
      case Outcome::over:
        continues = false;
    }
  }
  queue_.close();
}

/// A separate thread, because opening takes long, and verdicts continue meanwhile.
void EventFeed::open_when_lost() {
  for (;;) {
    {
      std::unique_lock lock(guard_);
      wake_.wait(lock, [this] { return stops_ || opens_; });
      if (stops_) return;
      opens_ = false;
    }
    if (!open_again()) return queue_.close();
    capture::PacketQueue::Packet back = queue_.take();
    mark(back.front());
    queue_.push(back, true);
  }
}

bool EventFeed::next(capture::PacketQueue::Packet& packet, microseconds patience, microseconds rest) {
  if (options_.receives_ahead) return queue_.pop(packet, patience);
  if (is_lost_) {
    const bool continues = queue_.pop(packet, patience);
    is_lost_ = packet.empty();
    return continues;
  }
  if (!queue_.is_open()) return false;
  if (packet_.empty()) packet_ = queue_.take();
  if (rest > microseconds{0}) std::this_thread::sleep_for(rest);
  switch (receive(patience - rest)) {
    case Outcome::packet:
      packet = std::exchange(packet_, {});
      break;
    case Outcome::nothing:
      break;
    case Outcome::lost: {
      packet = std::exchange(packet_, {});
      is_lost_ = true;
      const std::scoped_lock lock(guard_);
      opens_ = true;
      wake_.notify_all();
      break;
    }
    case Outcome::over:
      queue_.close();
      return false;
  }
  return true;
}

/// Receives into `packet_`. If the source is lost, `packet_` is empty and has the next `source_index`.
EventFeed::Outcome EventFeed::receive(microseconds patience) {
  capture::CameraPacket& elements = packet_.front().elements;
  elements.clear();
  const auto keep_drops = [this] {  // without a report: the error says more
    const std::scoped_lock lock(guard_);
    drops_ = source_->drops();
  };
  Outcome outcome = Outcome::nothing;
  try {
    switch (source_->receive(elements, patience)) {
      case capture::CameraSource::Received::packet:
        note_arrival();
        if (options_.see) options_.see(elements);
        // Packets of other streams lead to no verdict.
        if (!elements.events.empty() || elements.empty()) outcome = Outcome::packet;
        break;
      case capture::CameraSource::Received::nothing:
        break;
      case capture::CameraSource::Received::ended:
        keep_drops();
        return Outcome::over;
    }
  } catch (const Error& e) {
    keep_drops();
    return lose(e.what());
  }
  note_drops();
  return outcome;
}

/// Makes it the empty packet that shows a new `source_index`.
void EventFeed::mark(capture::QueuedPacket& packet) const {
  packet.elements.clear();
  packet.source_index = index_;
  packet.arrived = host_now();
}

void EventFeed::note_arrival() {
  capture::QueuedPacket& packet = packet_.front();
  packet.source_index = index_;
  packet.arrived = packet.elements.arrived.value_or(host_now());
  // Others may have arrived while it was decoded.
  if (!options_.receives_ahead && !packet.elements.arrived) packet.elements.more_came = true;
}

void EventFeed::hand_over() {
  const capture::CameraPacket& elements = packet_.front().elements;
  const std::uint64_t events = elements.events.size();
  const bool wakes = !options_.wakes || options_.wakes(elements);
  if (queue_.push(packet_, options_.waits, wakes)) {
    packet_ = queue_.take();
  } else if (queue_.is_open()) {
    lost_ += events;
  }
}

/// Reports at most once a second: damage usually affects many packets.
void EventFeed::note_drops() {
  const capture::SourceDrops drops = source_->drops();
  if (!(drops == drops_)) {
    const std::scoped_lock lock(guard_);
    drops_ = drops;
  }
  const capture::LostElements all = drops.total();
  const std::uint64_t count = all.packets + all.events + all.others;
  const HostTime now = host_now();
  if (count == drops_known_ || now - drops_reported_ < between_drop_reports) return;
  drops_known_ = count;
  drops_reported_ = now;
  report("unsound",
         fmt::format("{}: {} packets and {} events so far could not be used: broken, outside the sensor, or back in time", name_,
                     all.packets, all.events));
}

/// Reports once why the source is lost.
EventFeed::Outcome EventFeed::lose(const std::string& why) {
  const bool tries = options_.open && options_.reconnect > milliseconds(0);
  report("broken", why + (tries ? "; trying to open it again" : ""));
  const std::scoped_lock lock(guard_);
  if (!tries) {
    error_ = why;
    return Outcome::over;
  }
  drops_of_earlier_ += std::exchange(drops_, {});
  drops_known_ = 0;
  why_lost_ = why, lost_at_ = host_now();
  ++index_;  // no verdict combines events from before and after
  mark(packet_.front());
  return Outcome::lost;
}

/// Reports once that the source is back, or that the feed gave up.
bool EventFeed::open_again() {
  source_.reset();  // a camera can be open only once, and some servers accept one client
  std::string last_reason;
  milliseconds pause = first_pause;
  do {
    {
      std::unique_lock lock(guard_);
      if (wake_.wait_for(lock, pause, [this] { return stops_; })) return false;
    }
    pause = std::min(2 * pause, longest_pause);
    try {
      std::unique_ptr<capture::CameraSource> again = options_.open();
      if (*events_of(*again).size != sensor_) throw Error(name_ + ": is another sensor now; expected the same size as before");
      source_ = std::move(again);
    } catch (const Error& e) {
      last_reason = e.what();
      continue;
    }
    ++index_, ++reopened_;
    report("back", fmt::format("{}: is back after {:.1f} s", name_, in_s(host_now() - lost_at_)));
    return true;
  } while (host_now() - lost_at_ < options_.reconnect);
  const microseconds tried = host_now() - lost_at_;
  const std::string prefix = name_ + ": ";
  if (last_reason.starts_with(prefix)) last_reason.erase(0, prefix.size());
  report("gave up", fmt::format("{}gave up after {:.1f} s{}; expected it to be available again within {} s (--reconnect)", prefix,
                                in_s(tried), last_reason.empty() ? "" : " (" + last_reason + ")", in_s(options_.reconnect)));
  const std::scoped_lock lock(guard_);
  gave_up_after_ = tried;
  error_ = why_lost_;
  return false;
}

}  // namespace tactile::detect
