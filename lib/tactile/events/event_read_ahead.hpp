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
#include "tactile/events/recording_index.hpp"

namespace tactile {

/// The events of one packet, with what must be known to put them to use.
struct DecodedEvents {
  Contents contents = Contents::broken;
  std::span<Event> events;    ///< inside the sensor and of a polarity; in the buffer that was decoded into
  std::uint64_t dropped = 0;  ///< those that were not
  bool ascending = true;
};

/// Decodes packets one after the other, with one set of working memory. Nothing in it depends on other packets, so several may
/// work on one file at the same time.
class EventPacketDecoder {
 public:
  EventPacketDecoder(const RecordingFile& file, Compression compression)
      : file_(&file), compression_(compression), window_(file.parts()) {}

  /// Brings a packet's contents to the front of `content`; false if they do not decompress. @throws Error if the file cannot be
  /// read
  bool load(const PacketRecord& packet, PacketBuffer& content, std::size_t& size, Expected expected = Expected::anything);
  /// Its events. @param sensor 1 to 32768 pixels each way. @throws Error likewise
  DecodedEvents decode(const PacketRecord& packet, SensorSize sensor, PacketBuffer& content);
  /// The bytes as they are stored; valid until the next call of any of these. @throws Error likewise
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

/// Decodes packets ahead of the one that reads them, on threads of its own; the reader helps where it would have to wait. What is
/// ahead is bounded: a few batches of some packets each, and 64 MiB of contents beside the packets that are being decoded.
class EventReadAhead {
 public:
  /// @param helpers  threads to start, > 0; where the machine gives none, the reader does all of it
  EventReadAhead(const RecordingFile& file, Compression compression, unsigned helpers);
  ~EventReadAhead();
  EventReadAhead(const EventReadAhead&) = delete;
  EventReadAhead& operator=(const EventReadAhead&) = delete;

  /// The packets that will be asked for, in the order of their places; takes the place of what was to come before.
  void expect(std::vector<EventPacket> packets);

  /// The events of one of them, valid until the next call, and once only. Nothing if it is none of them, comes before one asked
  /// for already, or could not be had ahead: it is to be decoded by the asker then.
  std::optional<DecodedEvents> take(const PacketRecord& packet);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
