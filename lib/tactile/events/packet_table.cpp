#include "tactile/events/packet_table.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <span>

#include "tactile/core/time.hpp"
#include "tactile/events/recording_header.hpp"

namespace tactile::events {
namespace {

constexpr std::size_t piece_size = std::size_t{64} << 10;

constexpr std::uint32_t head_size = 32;   ///< prefix, offset of the root, identifier, root and its vtable, count
constexpr std::uint32_t entry_size = 48;  ///< 44, and padding for the alignment of the next
constexpr std::array<std::uint16_t, 7> entry_vtable{14, 44, 4, 36,
                                                    12, 20, 28};  ///< its size, the entry's size, the places of the fields

std::uint64_t number_of(CameraTime t) { return static_cast<std::uint64_t>(us_of(t)); }

/// Maps differences, which wrap around, so that small ones of either sign become small numbers.
std::uint64_t folded(std::uint64_t difference) { return difference << 1 ^ (difference >> 63 != 0 ? ~std::uint64_t{0} : 0); }
std::uint64_t unfolded(std::uint64_t number) { return number >> 1 ^ ((number & 1) != 0 ? ~std::uint64_t{0} : 0); }

/// The place of the first entry: after the offsets and the vtable, and 4 bytes before its aligned 64-bit numbers.
std::uint64_t first_entry(std::uint64_t packets) {
  const std::uint64_t offsets_end = head_size + 4 * packets;
  return (offsets_end + sizeof entry_vtable + 3) / 8 * 8 + 4;
}

/// Collects values and passes them on in pieces.
class Pieces {
 public:
  explicit Pieces(const ByteSink& sink) : sink_(sink), bytes_(piece_size) {}

  template <class T>
  void put(const T& value) {
    if (used_ + sizeof value > bytes_.size()) flush();
    std::memcpy(bytes_.data() + used_, &value, sizeof value);
    used_ += sizeof value;
  }
  void flush() {
    if (used_ > 0) sink_(std::span(bytes_).first(used_));
    passed_on_ += used_;
    used_ = 0;
  }
  std::uint64_t position() const { return passed_on_ + used_; }

 private:
  const ByteSink& sink_;
  std::vector<std::byte> bytes_;
  std::size_t used_ = 0;
  std::uint64_t passed_on_ = 0;
};

}  // namespace

void PacketTable::put(std::uint64_t number) {
  for (; number >= 0x80; number >>= 7) bytes_.push_back(static_cast<std::uint8_t>(number | 0x80));
  bytes_.push_back(static_cast<std::uint8_t>(number));
}

void PacketTable::add(const PacketRecord& packet) {
  auto stream = std::find_if(streams_.begin(), streams_.end(), [&](const StreamState& s) { return s.id == packet.stream_id; });
  if (stream == streams_.end()) stream = streams_.insert(streams_.end(), StreamState{.id = packet.stream_id});
  const StreamState now{.id = packet.stream_id,
                        .size = packet.payload_size,
                        .elements = static_cast<std::uint64_t>(packet.elements),
                        .last = number_of(packet.last),
                        .span = number_of(packet.last) - number_of(packet.first)};
  put(static_cast<std::uint64_t>(stream - streams_.begin()));
  put(folded(now.size - stream->size));
  put(folded(now.elements - stream->elements));
  put(folded(number_of(packet.first) - stream->last));
  put(folded(now.span - stream->span));
  *stream = now;
  ++packets_;
}

std::uint64_t PacketTable::content_size() const {
  return packets_ == 0 ? head_size : first_entry(packets_) + entry_size * packets_;
}

void PacketTable::write_contents(const ByteSink& sink) const {
  assert(content_size() < (std::uint64_t{1} << 31) && "a larger table exceeds its own offsets");
  Pieces out(sink);
  out.put(static_cast<std::uint32_t>(content_size() - 4));
  out.put(std::uint32_t{16});  // the root table is at 4 + 16
  out.put(std::array{'F', 'T', 'A', 'B'});
  out.put(std::array<std::uint16_t, 4>{0, 6, 8, 4});  // padding, and the root's vtable
  out.put(std::uint32_t{6});                          // the root: distances back to its vtable and forward to its vector
  out.put(std::uint32_t{4});
  out.put(static_cast<std::uint32_t>(packets_));
  if (packets_ == 0) return out.flush();

  const std::uint64_t first = first_entry(packets_);
  for (std::size_t i = 0; i < packets_; ++i) {
    out.put(static_cast<std::uint32_t>(first + entry_size * i - out.position()));
  }
  const std::uint64_t vtable = first - sizeof entry_vtable;
  while (out.position() < vtable) out.put(std::byte{0});
  out.put(entry_vtable);

  std::vector<StreamState> streams;
  for (const StreamState& stream : streams_) streams.push_back({.id = stream.id});
  auto at = bytes_.begin();
  const auto next = [&] {
    std::uint64_t number = 0;
    for (unsigned shift = 0;; shift += 7) {
      const std::uint8_t byte = *at++;
      number |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
      if (byte < 0x80) return number;
    }
  };
  std::uint64_t end = begin_;
  for (std::size_t i = 0; i < packets_; ++i) {
    StreamState& stream = streams[static_cast<std::size_t>(next())];
    stream.size += unfolded(next());
    stream.elements += unfolded(next());
    const std::uint64_t packet_first = stream.last + unfolded(next());
    stream.span += unfolded(next());
    stream.last = packet_first + stream.span;
    out.put(static_cast<std::uint32_t>(out.position() - vtable));
    out.put(end + packet_header_size);
    out.put(stream.elements);
    out.put(packet_first);
    out.put(stream.last);
    out.put(stream.id);
    out.put(static_cast<std::uint32_t>(stream.size));
    out.put(std::uint32_t{0});
    end += packet_header_size + stream.size;
  }
  out.flush();
}

}  // namespace tactile::events
