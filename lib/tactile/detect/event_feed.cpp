#include "tactile/detect/event_feed.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds source_patience{50};  // within it the thread sees that it shall stop
constexpr milliseconds first_pause{50}, longest_pause{1'000};
constexpr microseconds between_tellings{1'000'000};

}  // namespace

const Stream& events_of(const CameraSource& source) {
  for (const Stream& stream : source.streams()) {
    if (stream.type != StreamType::events) continue;
    if (stream.size) return stream;
    throw Error(source.name() + ": its events declare no size; expected their sensor's");
  }
  throw Error(source.name() + ": has no stream of events; expected a source that has");
}

EventFeed::EventFeed(std::unique_ptr<CameraSource> source, PacketQueue& queue, EventFeedOptions options)
    : source_(std::move(source)),
      queue_(queue),
      options_(std::move(options)),
      name_(source_->name()),
      sensor_(*events_of(*source_).size) {}

EventFeed::~EventFeed() { stop(); }

void EventFeed::start() {
  thread_ = std::thread([this] { receive_all(); });
}

void EventFeed::stop() {
  {
    const std::scoped_lock lock(guard_);
    stops_ = true;
  }
  wake_.notify_all();
  queue_.close();  // nobody waits for room any more
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

SourceDrops EventFeed::drops() const {
  const std::scoped_lock lock(guard_);
  SourceDrops drops = drops_of_earlier_;
  return drops += drops_;
}

void EventFeed::say(const char* kind, const std::string& text) const {
  if (options_.fault) options_.fault({kind, text, host_now()});
}

void EventFeed::receive_all() {
  if (options_.prepare) options_.prepare();
  packet_ = queue_.take();
  const auto stops = [this] {
    const std::scoped_lock lock(guard_);
    return stops_;
  };
  while (!stops() && receive_one()) {
  }
  queue_.close();
}

/// False once there is nothing more to receive.
bool EventFeed::receive_one() {
  CameraPacket& elements = packet_.front().elements;
  elements.clear();
  const auto keep_drops = [this] {  // why the source is gone says it all
    const std::scoped_lock lock(guard_);
    drops_ = source_->drops();
  };
  try {
    switch (source_->receive(elements, source_patience)) {
      case CameraSource::Received::packet:
        hand_over();
        break;
      case CameraSource::Received::nothing:
        break;
      case CameraSource::Received::ended:
        keep_drops();
        return open_again("has closed", false);
    }
  } catch (const Error& e) {
    keep_drops();
    return open_again(e.what(), true);
  }
  note_drops();
  return true;
}

void EventFeed::hand_over() {
  packet_.front().source_index = index_;
  packet_.front().arrived = host_now();
  if (options_.see) options_.see(packet_.front().elements);
  const CameraPacket& elements = packet_.front().elements;
  if (elements.events.empty() && !elements.empty()) return;  // of another stream, which tells no verdict
  const std::uint64_t events = elements.events.size();
  const bool wakes = !options_.wakes || options_.wakes(elements);
  if (queue_.push(packet_, options_.waits, wakes)) {
    packet_ = queue_.take();
  } else if (queue_.is_open()) {
    lost_ += events;
  }
}

/// Told at most once a second: damage mostly comes in heaps.
void EventFeed::note_drops() {
  const SourceDrops drops = source_->drops();
  if (!(drops == drops_)) {
    const std::scoped_lock lock(guard_);
    drops_ = drops;
  }
  const LostElements all = drops.total();
  const std::uint64_t count = all.packets + all.events + all.others;
  const HostTime now = host_now();
  if (count == drops_known_ || now - drops_told_ < between_tellings) return;
  drops_known_ = count;
  drops_told_ = now;
  say("unsound", fmt::format("{}: {} packets and {} events so far could not be used: broken, outside the sensor, or earlier than "
                             "those before them",
                             name_, all.packets, all.events));
}

/// Why the source is gone is said once, and that it is back or given up.
bool EventFeed::open_again(const std::string& why, bool broke) {
  const bool tries = options_.open && options_.reconnect > milliseconds(0);
  if (broke || tries)
    say(broke ? "broken" : "closed",
        fmt::format("{}{}{}", broke ? "" : name_ + ": ", why, tries ? "; trying to open it again" : ""));
  if (!tries) {
    const std::scoped_lock lock(guard_);
    if (broke) error_ = why;
    return false;
  }
  {
    const std::scoped_lock lock(guard_);
    drops_of_earlier_ += std::exchange(drops_, {});
  }
  drops_known_ = 0;
  // What was known of the stream is not to be mixed with what comes.
  ++index_;
  packet_.front().elements.clear();
  packet_.front().source_index = index_;
  packet_.front().arrived = host_now();
  if (queue_.push(packet_, true)) packet_ = queue_.take();
  const HostTime gone = host_now();
  std::string last_reason;
  for (milliseconds pause = first_pause; host_now() - gone < options_.reconnect; pause = std::min(2 * pause, longest_pause)) {
    {
      std::unique_lock lock(guard_);
      if (wake_.wait_for(lock, pause, [this] { return stops_; })) return false;
    }
    try {
      std::unique_ptr<CameraSource> again = options_.open();
      if (*events_of(*again).size != sensor_) throw Error(name_ + ": is another sensor now; expected one of the same size");
      source_ = std::move(again);
    } catch (const Error& e) {
      last_reason = e.what();
      continue;
    }
    ++index_, ++reopened_;
    say("back", fmt::format("{}: is back after {:.1f} s", name_, 1e-6 * static_cast<double>((host_now() - gone).count())));
    return true;
  }
  const microseconds tried = host_now() - gone;
  say("gave up", fmt::format("{}: gave up after {:.1f} s{}; expected it to be there again within --reconnect", name_,
                             1e-6 * static_cast<double>(tried.count()), last_reason.empty() ? "" : " (" + last_reason + ")"));
  const std::scoped_lock lock(guard_);
  gave_up_after_ = tried;
  if (broke) error_ = why;
  return false;
}

}  // namespace tactile
