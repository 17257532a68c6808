#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/file_window.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_file.hpp"

namespace tactile::events {

/// The events of one packet, and their state.
struct DecodedEvents {
  Contents contents = Contents::broken;
  std::span<Event> events;    ///< inside the sensor and with a valid polarity; in the buffer of the decoder
  std::uint64_t dropped = 0;  ///< other events
  bool ascending = true;
};

/// Decodes packets, with memory that is reused. It keeps no state between packets, so several decoders may use one file
/// concurrently.
class EventPacketDecoder {
 public:
  EventPacketDecoder(const RecordingFile& file, Compression compression)
      : file_(&file), compression_(compression), window_(file.parts()) {}

  /// Loads a packet's contents to the front of `content`; false if they cannot be decompressed. @throws Error  if the file cannot
  /// be read
  bool load(const PacketRecord& packet, PacketBuffer& content, std::size_t& size, Expected expected = Expected::anything);
  /// The events of a packet. @param sensor  1 to 32768 pixels in each direction. @throws Error  if the file cannot be read
  DecodedEvents decode(const PacketRecord& packet, SensorSize sensor, PacketBuffer& content);
  /// The stored bytes; valid until the next call of any function. @throws Error  if the file cannot be read
  std::span<const std::byte> stored(const PacketRecord& packet);

 private:
  const RecordingFile* file_;
  Compression compression_;
  FileWindow window_;
  PacketBuffer stored_;
  PacketDecompressor decompressor_;
};

/// A packet to be decoded.
struct EventPacket {
  PacketRecord record;
  SensorSize sensor;
};

/// Decodes packets ahead of their reader, on its own threads; the reader helps instead of waiting. It is limited to a few batches
/// of packets, and to 64 MiB of contents in addition to the packets being decoded.
class EventReadAhead {
 public:
  /// @param helpers  number of threads, > 0; if none can be started, the reader decodes all packets
  EventReadAhead(const RecordingFile& file, Compression compression, unsigned helpers);
  ~EventReadAhead();
  EventReadAhead(const EventReadAhead&) = delete;
  EventReadAhead& operator=(const EventReadAhead&) = delete;

  /// Sets the packets that will be requested, in the order of their places. Replaces earlier expectations.
  void expect(std::vector<EventPacket> packets);

  /// The events of an expected packet, once only, and valid until the next call. Nothing if the packet is not expected, lies
  /// before an earlier request, or was not decoded ahead. Then the caller decodes it.
  std::optional<DecodedEvents> take(const PacketRecord& packet);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::events
