#include "tactile/transport/dv/dv_stream_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "tactile/core/error.hpp"
#include "tactile/events/event_checks.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_header.hpp"

namespace tactile::transport {
namespace {

constexpr std::size_t smallest_header = 16;                 ///< [B] after its prefix
constexpr std::size_t header_limit = std::size_t{1} << 20;  ///< a stream's header has about 1200 bytes
constexpr std::size_t first_room = std::size_t{1} << 20;    ///< for a larger packet, until these bytes have arrived [B]

std::uint32_t u32_at(const std::byte* bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Drops, in place, events outside the sensor or with a polarity above 1.
std::span<events::Event> sound_events(std::span<events::Event> events, const std::optional<events::SensorSize>& size) {
  const events::SensorSize bounds = events::bounds_of(size);
  return events::check_events(events, bounds).inside ? events : events::without_outside(events, bounds);
}

}  // namespace

/// Distinguishes a server without a header from other data: its first bytes are a packet's stream id, a small number.
void DvStreamParser::check_start() const {
  const std::uint32_t size = u32_at(start_.data());
  const bool is_header = std::memcmp(start_.data() + 8, "IOHE", 4) == 0;
  if (size < smallest_header) {
    throw Error(where_ +
                ": sends packets without a header, as DV before 1.6 does; expected a stream of DV 1.6 or newer, dv-processing or "
                "tactile serve");
  }
  if (!is_header) {
    std::string text;
    for (const std::byte b : start_) {
      const char c = static_cast<char>(b);
      text += c >= ' ' && c <= '~' ? c : '?';
    }
    throw Error(where_ + ": sends no DV stream, its first bytes are '" + text +
                "'; expected a stream of DV, dv-processing or tactile serve");
  }
  if (size > header_limit) {
    throw Error(fmt::format("{}: claims a header of {} bytes; expected at most {}", where_, size, header_limit));
  }
}

void DvStreamParser::read_stream_header() {
  events::RecordingHeader header = events::read_header({content_.data(), size_}, where_);
  if (header.streams.size() != 1) {
    throw Error(fmt::format("{}: declares {} streams; expected one per connection", where_, header.streams.size()));
  }
  compression_ = header.compression;
  stream_ = std::move(header.streams.front());
  if (stream_.type == events::StreamType::other) {
    throw Error(fmt::format("{}: carries packets of type '{}'; expected EVTS, IMUS, TRIG or FRME", where_,
                            stream_.type_identifier.substr(0, 40)));
  }
}

void DvStreamParser::begin_packet() {
  packet_id_ = static_cast<std::int32_t>(u32_at(packet_header_.data()));
  size_ = u32_at(packet_header_.data() + 4);
  have_ = 0;
  if (size_ == 0) {
    ++problems_.broken_packets;
    return;
  }
  if (size_ > dv_packet_limit) {
    throw Error(fmt::format("{}: sends a packet of {} bytes; expected at most {}. The next packet cannot be found", where_, size_,
                            dv_packet_limit));
  }
  part_ = Part::payload;
}

std::span<std::byte> DvStreamParser::room() {
  events_ = {};
  imu_.clear();
  triggers_.clear();
  frame_.reset();
  if (part_ == Part::packet_header && have_ == packet_header_size) begin_packet();
  switch (part_) {
    case Part::start:
      return std::span(start_).subspan(have_);
    case Part::packet_header:
      return std::span(packet_header_).subspan(have_);
    case Part::header:
      return {content_.data() + have_, size_ - have_};
    case Part::payload:
      break;
  }
  // Together with the next packet's header, which saves a system call.
  const std::size_t wanted = size_ + packet_header_size;
  events::PacketBuffer& buffer = incoming();
  if (have_ == 0 || have_ == buffer.capacity()) buffer.grow(std::min(wanted, std::max(first_room, 2 * have_)), have_);
  return {buffer.data() + have_, std::min(wanted, buffer.capacity()) - have_};
}

bool DvStreamParser::received(std::size_t count) {
  have_ += count;
  switch (part_) {
    case Part::start:
      if (have_ < start_.size()) break;
      check_start();
      size_ = std::size_t{u32_at(start_.data())} + 4;
      content_.grow(size_, 0);
      std::memcpy(content_.data(), start_.data(), start_.size());
      part_ = Part::header;
      break;
    case Part::header:
      if (have_ < size_) break;
      read_stream_header();
      part_ = Part::packet_header;
      have_ = 0;
      break;
    case Part::packet_header:
      break;
    case Part::payload:
      if (have_ < size_) break;
      have_ -= size_;
      std::memcpy(packet_header_.data(), incoming().data() + size_, have_);
      part_ = Part::packet_header;
      return take_packet();
  }
  return false;
}

/// Decompresses the payload into `content_` and decodes it there.
bool DvStreamParser::take_packet() {
  if (packet_id_ != stream_.id) {
    ++problems_.foreign_packets;
    return false;
  }
  std::size_t content_size = size_;
  events::Contents contents = events::Contents::broken;
  if (compression_ != events::Compression::none) {
    const std::size_t limit = events::largest_content(compression_, size_);
    const events::Expected expected =
        stream_.type == events::StreamType::events ? events::Expected::events : events::Expected::anything;
    const events::Decompressed result =
        decompressor_.decompress(compression_, {stored_.data(), size_}, content_, limit, expected);
    if (!result.whole) {
      ++problems_.broken_packets;
      return false;
    }
    content_size = result.size;
  }
  switch (stream_.type) {
    case events::StreamType::events: {
      std::span<events::Event> all;
      contents = events::decode_events(content_, content_size, all);
      if (contents != events::Contents::whole) break;
      events_ = sound_events(all, stream_.size);
      problems_.out_of_range_events += all.size() - events_.size();
      break;
    }
    case events::StreamType::imu:
      contents = events::decode_imu(content_, content_size, imu_);
      break;
    case events::StreamType::triggers:
      contents = events::decode_triggers(content_, content_size, triggers_);
      break;
    case events::StreamType::frames:
      contents = events::decode_frame(content_, content_size, frame_.emplace());
      if (contents != events::Contents::whole) frame_.reset();
      break;
    case events::StreamType::other:
      break;
  }
  if (contents == events::Contents::whole) return true;
  ++(contents == events::Contents::mismatched ? problems_.mismatched_packets : problems_.broken_packets);
  return false;
}

void DvStreamParser::end() const {
  if (!has_header()) throw Error(where_ + ": closed before its header was complete; expected a DV stream");
  if (!is_between_packets()) throw Error(where_ + ": ended inside a packet; expected it to end between two");
}

}  // namespace tactile::transport
