#include "tactile/events/event_read_ahead.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/event_checks.hpp"

namespace tactile {
namespace {

/// Handing a batch from thread to thread costs some microseconds, decoding it hundreds.
constexpr std::size_t batch_bytes = std::size_t{512} << 10;
constexpr std::size_t batch_packets = 16;
constexpr std::size_t most_bytes_ahead = std::size_t{64} << 20;
/// A buffer that a huge packet left behind is not kept for small ones.
constexpr std::size_t largest_kept_buffer = std::size_t{4} << 20;

}  // namespace

bool EventPacketDecoder::load(const PacketRecord& packet, PacketBuffer& content, std::size_t& size, Expected expected) {
  if (compression_ == Compression::none) {
    content.grow(packet.payload_size, 0);
    file_->read(packet.payload_offset, {content.data(), packet.payload_size});
    size = packet.payload_size;
    return true;
  }
  Decompressed result;
  const std::size_t limit = largest_content(compression_, packet.payload_size);
  const auto decompress = [&](std::span<const std::byte> bytes) {
    result = decompressor_.decompress(compression_, bytes, content, limit, expected);
  };
  if (!window_->use(file_->descriptor(), packet.payload_offset, packet.payload_size, file_->size(), decompress)) {
    decompressor_ = {};  // it may have been left in the middle
    decompress(stored(packet));
  }
  size = result.size;
  return result.whole;
}

std::span<const std::byte> EventPacketDecoder::stored(const PacketRecord& packet) {
  stored_.grow(packet.payload_size, 0);
  file_->read(packet.payload_offset, {stored_.data(), packet.payload_size});
  return {stored_.data(), packet.payload_size};
}

DecodedEvents EventPacketDecoder::decode(const PacketRecord& packet, SensorSize sensor, PacketBuffer& content) {
  DecodedEvents decoded;
  std::size_t size = 0;
  if (!load(packet, content, size, Expected::events)) return decoded;
  decoded.contents = decode_events(content, size, decoded.events);
  if (decoded.contents != Contents::whole) return decoded;
  const EventsCheck check = check_events(decoded.events, sensor);
  decoded.ascending = check.ascending;
  if (check.inside) return decoded;
  const std::span<Event> kept = without_outside(decoded.events, sensor);
  decoded.dropped = decoded.events.size() - kept.size();
  decoded.events = kept;
  decoded.ascending = check_events(decoded.events, sensor).ascending;
  return decoded;
}

struct EventReadAhead::State {
  /// Some packets in a row that one thread decodes.
  struct Batch {
    enum class Stage { planned, taken, done } stage = Stage::planned;
    std::span<const EventPacket> packets;
    std::vector<std::optional<DecodedEvents>> decoded;  ///< nothing where that failed or would have been too much
    std::vector<PacketBuffer> contents;
    std::size_t bytes = 0;  ///< of the contents that are kept
  };

  const RecordingFile& file;
  Compression compression;
  std::vector<EventPacket> expected;
  std::size_t planned = 0;  ///< of those expected

  std::mutex guard;
  std::condition_variable work, progress;
  std::deque<std::unique_ptr<Batch>> ahead;  ///< in the packets' order, what is read at the front
  std::vector<std::unique_ptr<Batch>> spare;
  std::atomic<std::size_t> bytes_ahead{0};
  bool stopping = false;

  std::size_t cursor = 0;  ///< in the batch at the front
  EventPacketDecoder own_decoder;
  std::vector<std::thread> helpers;

  State(const RecordingFile& recording, Compression method, unsigned count)
      : file(recording), compression(method), own_decoder(recording, method) {
    // One for each thread, one that is read; what is fresh memory costs more than waiting now and then.
    for (std::size_t i = 0; i < std::size_t{count} + 2; ++i) spare.push_back(std::make_unique<Batch>());
    try {
      for (unsigned i = 0; i < count; ++i) helpers.emplace_back([this] { help(); });
    } catch (const std::system_error&) {
      // The machine gives no more threads: those that are there do the work.
    }
  }
  ~State() {
    {
      const std::scoped_lock lock(guard);
      stopping = true;
    }
    work.notify_all();
    for (std::thread& helper : helpers) helper.join();
  }

  Batch* next_planned() {
    for (const auto& batch : ahead) {
      if (batch->stage == Batch::Stage::planned) return batch.get();
    }
    return nullptr;
  }

  void decode(Batch& batch, EventPacketDecoder& decoder) {
    batch.decoded.assign(batch.packets.size(), std::nullopt);
    if (batch.contents.size() < batch.packets.size()) batch.contents.resize(batch.packets.size());
    for (std::size_t i = 0; i < batch.packets.size() && bytes_ahead < most_bytes_ahead; ++i) {
      try {
        batch.decoded[i] = decoder.decode(batch.packets[i].record, batch.packets[i].sensor, batch.contents[i]);
      } catch (const std::exception&) {
        return;  // the reader meets it again when it comes to the packet
      }
      batch.bytes += batch.decoded[i]->events.size_bytes();
      bytes_ahead += batch.decoded[i]->events.size_bytes();
    }
  }

  void work_on(Batch& batch, EventPacketDecoder& decoder, std::unique_lock<std::mutex>& lock) {
    batch.stage = Batch::Stage::taken;
    lock.unlock();
    decode(batch, decoder);
    lock.lock();
    batch.stage = Batch::Stage::done;
  }

  void help() {
    EventPacketDecoder decoder(file, compression);
    std::unique_lock lock(guard);
    for (;;) {
      Batch* batch = nullptr;
      work.wait(lock, [&] { return stopping || (batch = next_planned()) != nullptr; });
      if (stopping) return;
      work_on(*batch, decoder, lock);
      progress.notify_one();
    }
  }

  /// Plans as many batches as there is room for.
  void plan() {
    bool any = false;
    while (!spare.empty() && planned < expected.size()) {
      std::size_t count = 0, bytes = 0;
      do {
        const PacketRecord& record = expected[planned + count].record;
        bytes += std::max<std::size_t>(record.payload_size, static_cast<std::size_t>(record.elements) * sizeof(Event));
        ++count;
      } while (bytes < batch_bytes && count < batch_packets && planned + count < expected.size());
      std::unique_ptr<Batch> batch = std::move(spare.back());
      spare.pop_back();
      batch->stage = Batch::Stage::planned;
      batch->packets = std::span(expected).subspan(planned, count);
      batch->bytes = 0;
      planned += count;
      ahead.push_back(std::move(batch));
      any = true;
    }
    if (any) work.notify_all();
  }

  /// The batch at the front has been read, or is not wanted.
  void drop_front(std::unique_lock<std::mutex>& lock) {
    progress.wait(lock, [&] { return ahead.front()->stage != Batch::Stage::taken; });
    std::unique_ptr<Batch> batch = std::move(ahead.front());
    ahead.pop_front();
    bytes_ahead -= batch->bytes;
    batch->bytes = 0;
    for (PacketBuffer& buffer : batch->contents) {
      if (buffer.capacity() > largest_kept_buffer) buffer = {};
    }
    spare.push_back(std::move(batch));
    cursor = 0;
  }

  /// Until the batch at the front is done. Who waits works.
  void finish_front(std::unique_lock<std::mutex>& lock) {
    while (ahead.front()->stage != Batch::Stage::done) {
      if (Batch* batch = next_planned()) {
        work_on(*batch, own_decoder, lock);
      } else {
        progress.wait(lock);
      }
    }
  }
};

EventReadAhead::EventReadAhead(const RecordingFile& file, Compression compression, unsigned helpers)
    : state_(std::make_unique<State>(file, compression, helpers)) {}
EventReadAhead::~EventReadAhead() = default;

void EventReadAhead::expect(std::vector<EventPacket> packets) {
  State& state = *state_;
  std::unique_lock lock(state.guard);
  while (!state.ahead.empty()) state.drop_front(lock);
  state.expected = std::move(packets);
  state.planned = 0;
  state.plan();
}

std::optional<DecodedEvents> EventReadAhead::take(const PacketRecord& packet) {
  State& state = *state_;
  const std::uint64_t place = packet.payload_offset;
  const auto is_before = [place](const EventPacket& other) { return other.record.payload_offset < place; };
  if (state.ahead.empty() || state.cursor == 0 || is_before(state.ahead.front()->packets.back())) {
    std::unique_lock lock(state.guard);
    while (!state.ahead.empty() && is_before(state.ahead.front()->packets.back())) state.drop_front(lock);
    if (state.ahead.empty()) {  // far ahead of what was planned
      const auto left = state.expected.begin() + static_cast<std::ptrdiff_t>(state.planned);
      state.planned += static_cast<std::size_t>(std::partition_point(left, state.expected.end(), is_before) - left);
    }
    state.plan();
    if (state.ahead.empty()) return std::nullopt;
    state.finish_front(lock);
  }
  State::Batch& batch = *state.ahead.front();
  while (is_before(batch.packets[state.cursor])) ++state.cursor;
  if (batch.packets[state.cursor].record.payload_offset != place) return std::nullopt;
  return std::exchange(batch.decoded[state.cursor], std::nullopt);
}

}  // namespace tactile
