#include "tactile/transport/dv/dv_stream_packets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/transport/dv/dv_stream_client.hpp"

namespace tactile::transport {
namespace {

constexpr std::size_t content_limit = events::packet_limit - 4096;  // a reader decompresses to `packet_limit` at most [B]

std::size_t pixels_of(const events::Frame& frame) {
  const auto side = [](std::int16_t length) { return static_cast<std::size_t>(std::max<int>(length, 0)); };
  return side(frame.width) * side(frame.height);
}

void write_events(std::byte* place, std::span<const events::Event> events) {
  events::write_event_packet_head(place, events.size());
  std::memcpy(place + events::event_packet_head, events.data(), events.size_bytes());
}

}  // namespace

DvStreamPackets::DvStreamPackets(std::string where, events::Stream stream, events::Compression compression)
    : where_(std::move(where)), stream_(std::move(stream)), compression_(compression) {
  events::check_readable_by_vendor(stream_, where_);
}

SharedPacket DvStreamPackets::header() const {
  const events::HeaderImage image = events::header_image(compression_, std::span(&stream_, 1));
  auto header = std::make_shared<SharedBytes>(image.bytes.size());
  std::memcpy(header->bytes.get(), image.bytes.data(), image.bytes.size());
  return header;
}

void DvStreamPackets::check_type(events::StreamType type) const {
  if (stream_.type != type) {
    throw Error(fmt::format("{}: carries {}, not {}", where_, name_of(stream_.type), name_of(type)));
  }
}

void DvStreamPackets::check_size(std::size_t payload, std::size_t limit) const {
  if (payload > limit) throw Error(fmt::format("{}: a packet of {} bytes; expected at most {}", where_, payload, limit));
}

void DvStreamPackets::check_content(std::size_t size) const {
  if (compression_ == events::Compression::none) check_size(size, dv_packet_limit);
  check_size(size, content_limit);
}

void DvStreamPackets::check(std::span<const events::Event> events) const {
  check_type(events::StreamType::events);
  check_content(events::event_packet_head + events.size_bytes());
}

void DvStreamPackets::check(std::span<const events::ImuSample> samples) const {
  check_type(events::StreamType::imu);
  check_content(samples.size_bytes());
}

void DvStreamPackets::check(std::span<const events::Trigger> triggers) const {
  check_type(events::StreamType::triggers);
  check_content(triggers.size_bytes());
}

void DvStreamPackets::check(const events::Frame& frame) const {
  check_type(events::StreamType::frames);
  if (frame.pixels.size() != pixels_of(frame) * events::bytes_per_pixel(frame.format)) {
    throw Error(fmt::format("{}: a frame of {} x {} in format {} with {} bytes; expected as many as its pixels take", where_,
                            frame.width, frame.height, frame.format, frame.pixels.size()));
  }
  check_content(frame.pixels.size());
}

/// A packet whose payload is still to be written.
std::shared_ptr<SharedBytes> DvStreamPackets::packet_for(std::size_t payload) const {
  check_size(payload, dv_packet_limit);
  auto packet = std::make_shared<SharedBytes>(events::packet_header_size + payload);
  const auto size = static_cast<std::uint32_t>(payload);
  std::memcpy(packet->bytes.get(), &stream_.id, sizeof stream_.id);
  std::memcpy(packet->bytes.get() + sizeof stream_.id, &size, sizeof size);
  return packet;
}

/// A packet of the `size` bytes at the front of `content_`.
SharedPacket DvStreamPackets::packet_of_content(std::size_t size) {
  events::PacketBuffer* payload = &content_;
  if (compression_ != events::Compression::none) {
    size = compressor_.compress(compression_, {content_.data(), size}, stored_, 0);
    payload = &stored_;
  }
  auto packet = packet_for(size);
  std::memcpy(packet->bytes.get() + events::packet_header_size, payload->data(), size);
  return packet;
}

SharedPacket DvStreamPackets::encode(std::span<const events::Event> events) {
  const std::size_t size = events::event_packet_head + events.size_bytes();
  if (compression_ == events::Compression::none) {
    auto packet = packet_for(size);
    write_events(packet->bytes.get() + events::packet_header_size, events);
    return packet;
  }
  content_.grow(size, 0);
  write_events(content_.data(), events);
  return packet_of_content(size);
}

SharedPacket DvStreamPackets::encode(std::span<const events::ImuSample> samples) {
  return packet_of_content(events::encode_imu(samples, content_, 0));
}

SharedPacket DvStreamPackets::encode(std::span<const events::Trigger> triggers) {
  return packet_of_content(events::encode_triggers(triggers, content_, 0));
}

SharedPacket DvStreamPackets::encode(const events::Frame& frame) {
  return packet_of_content(events::encode_frame(frame, content_, 0));
}

}  // namespace tactile::transport
