#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/raw_header.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::events {

/// One packet of a recording. `elements`, `first` and `last` come from the data table, before anything is dropped. After a scan
/// they are the number of sound elements and their earliest and latest time; 0 elements if the packet cannot be read.
struct PacketRecord {
  std::int32_t stream_id = 0;
  std::uint64_t payload_offset = 0;  ///< [B] from the start of the file, after the packet's header
  std::uint32_t payload_size = 0;    ///< [B] as stored
  std::int64_t elements = 0;
  CameraTime first{}, last{};  ///< meaningless if `elements` is 0
};

/// The origin of the list of packets: a data table that agrees with every packet's header, or one reading of every packet; or the
/// recording has no packets, and is divided into pieces that are read as packets are.
enum class PacketIndex : std::uint8_t { table, scan, pieces };

/// What is wrong with a recording; all 0 in a sound one. Counts that depend on the packets' contents are complete once every
/// packet has been read.
struct RecordingProblems {
  std::string table;                      ///< why the data table is not used; empty if it is, or if there is none
  bool header_not_patched = false;        ///< the data table is sound, but the header lacks its position: not closed
  std::uint64_t truncated_bytes = 0;      ///< after the last whole packet
  std::uint64_t skipped_bytes = 0;        ///< between packets: damaged headers, and what was lost with them
  std::uint64_t resized_packets = 0;      ///< whose header had a wrong size, which was corrected
  std::uint64_t empty_packets = 0;        ///< with a size of 0
  std::uint64_t undeclared_packets = 0;   ///< of a stream that the header does not name
  std::uint64_t mismatched_packets = 0;   ///< of another type than their stream
  std::uint64_t broken_packets = 0;       ///< cannot be decompressed or decoded
  std::uint64_t out_of_range_events = 0;  ///< outside the sensor or with a polarity above 1; dropped
  std::uint64_t unwrapped_packets = 0;    ///< whose times were 2^32 us too early, and were corrected
  std::uint64_t missing_packets = 0;      ///< listed by an unused data table, and not in the file
  std::uint64_t missing_elements = 0;     ///< of those, according to the table
};

/// The events of one packet, with the memory that they lie in.
struct OwnedEvents {
  PacketBuffer memory;
  std::span<Event> events;
};

/// An AEDAT4 recording, or a Prophesee RAW file of EVT2 or EVT3. Opening reads the header and the list of packets. Packets are
/// read one at a time, so memory follows the packet, not the file. Every size is checked before memory is allocated for it; a
/// packet may decompress to at most 256 MiB.
///
/// Without a sound data table the packets are found by a scan, as `find_packets` does. A step back of a stream by more than
/// 2^31 us and at most 2^32 us is a writer's overflow: 2^32 us are added from there on, until a step forward of such a size. Any
/// other step back stays as it is. So does a step back that returns to where a leap forward began, and so do the times between a
/// leap and a return in the same packet.
///
/// With several threads, packets of events that are read in sequence are decoded ahead. The result does not depend on the number
/// of threads.
///
/// A RAW file is read once when it is opened, and divided into pieces of 64 KiB. Its problems are counted then: words of unknown
/// types (`skipped_bytes`), a word that is cut off (`truncated_bytes`), events outside the sensor.
///
/// Sources: the AEDAT 4.0 format of iniVation's DV; Prophesee, EVT 2.0 and EVT 3.0 Format.
class RecordingReader {
 public:
  /// @param threads  threads that decode, the caller's included, > 0; at most 4 decode ahead
  /// @throws Error  if the file is neither AEDAT4 nor RAW, or declares no stream
  explicit RecordingReader(std::filesystem::path file, unsigned threads = 1);
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  const std::filesystem::path& file() const;
  std::uint64_t file_size() const;
  RecordingEncoding encoding() const;
  Compression compression() const;
  std::span<const Stream> streams() const;
  const Stream& stream(std::int32_t id) const;    ///< @throws Error if no stream has this id
  std::span<const PacketRecord> packets() const;  ///< in file order, of declared streams
  PacketIndex index() const;
  const RecordingProblems& problems() const;

  /// The events of one packet, decompressed once and not copied: valid until the next read from this reader. Events outside the
  /// sensor (at a negative place, if the stream declares no size) or of a polarity above 1 are dropped and counted. A packet that
  /// cannot be decoded is counted and gives no events.
  /// @throws Error  if the packet is not of this recording, its stream is of another type, or the file cannot be read
  std::span<Event> read_events(const PacketRecord& packet);
  /// The same, for a caller that keeps them. They are not copied where they were decompressed alone: in an AEDAT4 recording that
  /// is read by one thread. @throws Error  as `read_events`
  OwnedEvents take_events(const PacketRecord& packet);
  std::vector<ImuSample> read_imu(const PacketRecord& packet);
  std::vector<Trigger> read_triggers(const PacketRecord& packet);
  std::optional<Frame> read_frame(const PacketRecord& packet);  ///< nothing if it cannot be decoded

  /// The packet as stored, still compressed; valid until the next read from this reader. Events that were read stay valid.
  /// @throws Error  as `read_events`
  std::span<const std::byte> read_stored(const PacketRecord& packet);
  /// Whether elements of the packet were dropped, or their times corrected, when it was read. @throws Error  as `read_events`
  bool was_corrected(const PacketRecord& packet) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The one event stream, or the one that `choice` names. @throws Error  as for the streams alone
const Stream& event_stream(const RecordingReader& recording, std::string_view choice = {});

/// Passes every event of the stream with `begin <= t < end` to `use`, packet by packet in file order. Reads only packets that
/// overlap this interval.
void for_events_between(RecordingReader& recording, std::int32_t stream_id, CameraTime begin, CameraTime end,
                        const std::function<void(std::span<const Event>)>& use);

/// The same for all events of the stream.
void for_all_events(RecordingReader& recording, std::int32_t stream_id, const std::function<void(std::span<const Event>)>& use);

}  // namespace tactile::events
