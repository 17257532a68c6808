#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::transport {

/// Bytes that several clients receive. They are made once and never change.
struct SharedBytes {
  explicit SharedBytes(std::size_t length) : bytes(new std::byte[length]), size(length) {}
  std::unique_ptr<std::byte[]> bytes;  ///< not initialised: whoever makes the packet writes every byte
  std::size_t size;                    ///< [B]
};
using SharedPacket = std::shared_ptr<const SharedBytes>;

/// Encodes one stream as DV sends it: a header, then packets as in AEDAT4, each after its stream id and size.
class DvStreamPackets {
 public:
  /// @param where  name of the stream in errors
  /// @throws Error  if the stream lacks something that DV's reader needs
  DvStreamPackets(std::string where, events::Stream stream, events::Compression compression);

  SharedPacket header() const;

  /// @throws Error  if the stream has another type, a frame's size contradicts its pixels, or the packet exceeds the limit
  void check(std::span<const events::Event> events) const;
  void check(std::span<const events::ImuSample> samples) const;
  void check(std::span<const events::Trigger> triggers) const;
  void check(const events::Frame& frame) const;

  /// One packet of elements that `check` has accepted. @throws Error  if it exceeds `dv_packet_limit` after compression
  SharedPacket encode(std::span<const events::Event> events);
  SharedPacket encode(std::span<const events::ImuSample> samples);
  SharedPacket encode(std::span<const events::Trigger> triggers);
  SharedPacket encode(const events::Frame& frame);

 private:
  void check_type(events::StreamType type) const;
  void check_size(std::size_t payload, std::size_t limit) const;
  void check_content(std::size_t size) const;
  std::shared_ptr<SharedBytes> packet_for(std::size_t payload) const;
  SharedPacket packet_of_content(std::size_t size);

  std::string where_;
  events::Stream stream_;
  events::Compression compression_;
  events::PacketBuffer content_, stored_;
  events::PacketCompressor compressor_;
};

}  // namespace tactile::transport
