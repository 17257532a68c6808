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

namespace tactile::events {

struct RecordingWriterOptions {
  Compression compression = Compression::lz4;
  std::chrono::microseconds packet_span{10'000};  ///< a packet's elements span less time than this, > 0
  std::size_t packet_events = 8192;               ///< and it has at most this many events, > 0
  unsigned threads = 1;                           ///< that compress packets, > 0; see below
  bool checksums = false;                         ///< in a file beside it, see packet_checksums.hpp; the caller removes that file
};

/// The written packets of one stream.
struct WrittenStream {
  std::uint64_t packets = 0, elements = 0;
  CameraTime first{}, last{};  ///< of all elements; meaningless without elements
};

/// Writes an AEDAT4 recording that the vendor's software reads. The file has its final name from the start, and is always
/// readable up to its last whole packet. Elements are collected until a packet is full; `flush` writes the waiting ones. With
/// more than one thread, up to 80 packets, or 8 per thread if these are more, and at most 16 MiB, wait while as many are
/// compressed and written beside the caller. Then a later call throws the error of an earlier one.
///
/// The times of a stream must not go back, and events must lie inside the sensor. Otherwise the whole span is refused. Further
/// `info` of a stream is written as whole numbers if possible, otherwise as text. Memory grows by the data table, about 7 bytes
/// per packet.
class RecordingWriter {
 public:
  /// A stream must have one of the four types, a unique id, a name, a source, and for events and frames a size: the vendor's
  /// reader requires them. @throws Error  if a stream lacks one, or the file does not end in .aedat4, exists or cannot be made
  RecordingWriter(const std::filesystem::path& file, const std::vector<Stream>& streams, RecordingWriterOptions options = {});
  ~RecordingWriter();  ///< closes the file; errors are only reported by `close`
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;

  // Each throws Error and writes nothing if its elements are not valid. After an error of the disk some may be written.
  void write_events(std::int32_t stream_id, std::span<const Event> events);
  void write_imu(std::int32_t stream_id, std::span<const ImuSample> samples);
  void write_triggers(std::int32_t stream_id, std::span<const Trigger> triggers);
  void write_frame(std::int32_t stream_id, const Frame& frame);
  void write_waiting();  ///< writes incomplete packets, without sync
  void flush();          ///< writes incomplete packets, and syncs
  /// Flushes, writes the data table, updates the header, and syncs. If writing fails, the file is cut after its last whole packet
  /// and may lack the table. @throws Error  then, too
  void close();

  std::vector<WrittenStream> written() const;  ///< one for each stream, in the order of their declaration

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A stream of events as a DVXplorer Mini declares it: id 0, "events".
Stream event_stream_declaration(SensorSize size, std::string source);

}  // namespace tactile::events
