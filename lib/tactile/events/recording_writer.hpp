#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

struct RecordingWriterOptions {
  Compression compression = Compression::lz4;
  std::chrono::microseconds packet_span{10'000};  ///< a packet's last element comes earlier than this after its first, > 0
  std::size_t packet_events = 8192;               ///< and at most so many events, > 0
  bool checksums = false;  ///< in a file beside it, see packet_checksums.hpp; whoever asks for it removes it
};

/// What a recording holds of one stream, in whole packets.
struct WrittenStream {
  std::uint64_t packets = 0, elements = 0;
  CameraTime first{}, last{};  ///< of all elements; meaningless where there are none
};

/// Writes an AEDAT4 recording that the vendor's software reads. It bears its final name from the first byte: whatever happens,
/// the file is readable up to its last whole packet. Elements gather until a packet is full; `flush` writes those that wait.
///
/// Elements of one stream must not go back in time, and events must lie inside the sensor; a span with one that does not is
/// refused whole. A stream's further `info` is written as whole numbers where it is one, else as text.
/// Memory grows by the data table, some 7 bytes a packet.
class RecordingWriter {
 public:
  /// A stream must have a type of the four, an id of its own, a name, a source, and for events and frames a size: the vendor's
  /// reader demands them. @throws Error if one lacks them, or the file does not end in .aedat4, exists already or cannot be made
  RecordingWriter(const std::filesystem::path& file, std::vector<Stream> streams, RecordingWriterOptions options = {});
  ~RecordingWriter();  ///< closes; a failure to do so is seen only by calling `close`
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;

  // Each throws Error and writes nothing of what it was given, if that is not sound; an Error of the disk may come half-way.
  void write_events(std::int32_t stream_id, std::span<const Event> events);
  void write_imu(std::int32_t stream_id, std::span<const ImuSample> samples);
  void write_triggers(std::int32_t stream_id, std::span<const Trigger> triggers);
  void write_frame(std::int32_t stream_id, const Frame& frame);
  void write_waiting();  ///< whatever the packets still lack; who wants it synced too calls `flush`
  void flush();          ///< writes what waits, and syncs
  /// Flushes, writes the data table, patches the header, syncs. Where that fails the file is cut behind its last whole packet,
  /// which frees the room that a part of one took, and goes without a table if there is no room for it. @throws Error then too
  void close();

  std::vector<WrittenStream> written() const;  ///< one for each stream, in the order of their declaration

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A stream of events as a DVXplorer Mini would declare it: id 0, "events".
Stream event_stream_declaration(SensorSize size, std::string source);

}  // namespace tactile
