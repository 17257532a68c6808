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

namespace tactile::events {
namespace {

/// The batches of a thread should fit its second-level cache of 1 MiB or 512 KiB. With fewer batches it would often wait for the
/// reader.
constexpr std::size_t batch_bytes = std::size_t{128} << 10;
constexpr std::size_t batches_each = 4;
constexpr std::size_t batch_packets = 16;
constexpr std::size_t most_bytes_ahead = std::size_t{64} << 20;
/// Larger buffers, after a huge packet, are not kept.
constexpr std::size_t largest_kept_buffer = std::size_t{2} << 20;

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
  if (!window_.use(file_->descriptor(), packet.payload_offset, packet.payload_size, file_->size(), decompress)) {
    decompressor_ = {};  // it may be in an intermediate state
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
  /// Memory for a batch's contents. It belongs to one thread, because moving it between caches is slow.
  using Memory = std::vector<PacketBuffer>;
  struct Worker {
    EventPacketDecoder decoder;
    std::vector<Memory> spare = std::vector<Memory>(batches_each);
  };

  /// Consecutive packets that one thread decodes.
  struct Batch {
    enum class Stage : std::uint8_t { planned, taken, done } stage = Stage::planned;
    std::span<const EventPacket> packets;
    std::vector<std::optional<DecodedEvents>> decoded;  ///< nothing if that failed or exceeded the memory limit
    Worker* worker = nullptr;                           ///< the thread that took it, and owns `contents`
    Memory contents;
    std::size_t bytes = 0;     ///< of the contents that are kept
    std::size_t expected = 0;  ///< their estimated size
  };

  std::vector<EventPacket> expected;
  std::size_t planned = 0;        ///< of those expected
  std::size_t planned_bytes = 0;  ///< ahead of the reader, decoded or not [B]

  std::mutex guard;
  std::condition_variable work, progress;
  std::deque<std::unique_ptr<Batch>> ahead;  ///< in the order of packets; the reader is at the front
  std::vector<std::unique_ptr<Batch>> spare;
  std::atomic<std::size_t> bytes_ahead{0};
  bool stopping = false;

  std::size_t cursor = 0;       ///< in the batch at the front
  std::vector<Worker> workers;  ///< the reader, and the helpers
  std::vector<std::thread> helpers;

  State(const RecordingFile& recording, Compression compression, unsigned count) {
    for (unsigned i = 0; i <= count; ++i) workers.push_back({.decoder = {recording, compression}});
    for (std::size_t i = 0; i < batches_each * workers.size(); ++i) spare.push_back(std::make_unique<Batch>());
    try {
      for (unsigned i = 0; i < count; ++i) helpers.emplace_back([this, i] { help(workers[i + 1]); });
    } catch (const std::system_error&) {
      // No more threads are available: the existing ones do the work.
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

  /// The next batch for this worker. Memory is always left for the batch at the front, because later ones are taken after it.
  Batch* next_for(const Worker& worker) {
    if (worker.spare.empty()) return nullptr;
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
        return;  // the reader gets the same error at this packet
      }
      batch.bytes += batch.decoded[i]->events.size_bytes();
      bytes_ahead += batch.decoded[i]->events.size_bytes();
    }
  }

  void work_on(Batch& batch, Worker& worker, std::unique_lock<std::mutex>& lock) {
    batch.stage = Batch::Stage::taken;
    batch.worker = &worker;
    batch.contents = std::move(worker.spare.back());
    worker.spare.pop_back();
    lock.unlock();
    decode(batch, worker.decoder);
    lock.lock();
    batch.stage = Batch::Stage::done;
  }

  void help(Worker& worker) {
    std::unique_lock lock(guard);
    for (;;) {
      Batch* batch = nullptr;
      work.wait(lock, [&] { return stopping || (batch = next_for(worker)) != nullptr; });
      if (stopping) return;
      work_on(*batch, worker, lock);
      progress.notify_one();
    }
  }

  /// Plans as many batches as fit: fewer with large packets.
  void plan() {
    const std::size_t enough = workers.size() * batches_each * batch_bytes;
    while (!spare.empty() && planned < expected.size() && (planned_bytes < enough || ahead.size() <= workers.size())) {
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
      batch->expected = bytes;
      planned += count;
      planned_bytes += bytes;
      ahead.push_back(std::move(batch));
    }
    work.notify_all();
  }

  /// Drops the batch at the front, which was read or is not needed.
  void drop_front(std::unique_lock<std::mutex>& lock) {
    progress.wait(lock, [&] { return ahead.front()->stage != Batch::Stage::taken; });
    std::unique_ptr<Batch> batch = std::move(ahead.front());
    ahead.pop_front();
    bytes_ahead -= batch->bytes;
    planned_bytes -= batch->expected;
    for (PacketBuffer& buffer : batch->contents) {
      if (buffer.capacity() > largest_kept_buffer) buffer = {};
    }
    if (Worker* worker = std::exchange(batch->worker, nullptr); worker != nullptr) {
      worker->spare.push_back(std::move(batch->contents));
    }
    spare.push_back(std::move(batch));
    cursor = 0;
  }

  /// Waits until the batch at the front is done, and decodes meanwhile.
  void finish_front(std::unique_lock<std::mutex>& lock) {
    while (ahead.front()->stage != Batch::Stage::done) {
      if (Batch* batch = next_for(workers.front())) {
        work_on(*batch, workers.front(), lock);
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
    if (state.ahead.empty()) {  // far ahead of the planned packets
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

}  // namespace tactile::events
