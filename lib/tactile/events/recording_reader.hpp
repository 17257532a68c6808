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
#include "tactile/events/stream.hpp"

namespace tactile {

/// One packet of a recording. `elements`, `first` and `last` are the data table's, before anything is dropped, or what a scan
/// found: the number of sound elements, the earliest and the latest of their times; 0 elements where a packet cannot be read.
struct PacketRecord {
  std::int32_t stream_id = 0;
  std::uint64_t payload_offset = 0;  ///< [B] from the start of the file, behind the packet's 8-byte header
  std::uint32_t payload_size = 0;    ///< [B] as stored
  std::int64_t elements = 0;
  CameraTime first{}, last{};  ///< meaningless where `elements` is 0
};

/// Where the list of packets came from: a data table that agrees with every packet's header, or else every packet itself, read
/// once.
enum class PacketIndex : std::uint8_t { table, scan };

/// What was wrong with a recording and how it was met; all 0 in a sound one. Those that need the packets' contents are complete
/// once every packet has been read.
struct RecordingProblems {
  std::string table;                      ///< why the data table was not used; empty if it was, or there was none to use
  bool header_not_patched = false;        ///< the data table is sound, but the header does not say where it is: not closed
  std::uint64_t truncated_bytes = 0;      ///< behind the last whole packet
  std::uint64_t skipped_bytes = 0;        ///< between packets: damaged headers, and what was lost with them
  std::uint64_t resized_packets = 0;      ///< whose header had a wrong size, which was put right
  std::uint64_t empty_packets = 0;        ///< with a size of 0
  std::uint64_t undeclared_packets = 0;   ///< of a stream that the header does not name
  std::uint64_t mismatched_packets = 0;   ///< that hold another type than their stream's
  std::uint64_t broken_packets = 0;       ///< that do not decompress or decode
  std::uint64_t out_of_range_events = 0;  ///< outside the sensor or with a polarity above 1; dropped
  std::uint64_t unwrapped_packets = 0;    ///< whose times were 2^32 us too early, and were put right
  std::uint64_t missing_packets = 0;      ///< that a data table lists, though not used, and that are not there
  std::uint64_t missing_elements = 0;     ///< as it says, of those
};

/// An AEDAT4 recording. Opening reads the header and the list of packets; packets are read one at a time, so memory follows the
/// packet, not the file. Every size is checked before anything is allocated for it, and a packet may decompress to 256 MiB
/// at most.
///
/// Without a sound data table the packets are found by a scan, as `find_packets` does. A step back of a stream by more than
/// 2^31 us and at most 2^32 is a writer's overflow: 2^32 us are added from there on, until a step forward of such a size takes
/// them off again. Any other step back is left as it is, also one that only leads back to where a leap forward came from; and so
/// is what lies between a leap of either kind and the way back in the same packet.
///
/// With several threads, packets of events that are read one after the other are decoded ahead, a few batches of some packets;
/// what is read, and in which order, does not depend on their number.
///
/// Source: the AEDAT 4.0 format of iniVation's DV.
class RecordingReader {
 public:
  /// @param threads  to decode on, the caller's among them, > 0
  /// @throws Error  if the file is none of AEDAT4, or declares no stream
  explicit RecordingReader(std::filesystem::path file, unsigned threads = 1);
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  const std::filesystem::path& file() const;
  std::uint64_t file_size() const;
  Compression compression() const;
  std::span<const Stream> streams() const;
  const Stream& stream(std::int32_t id) const;    ///< @throws Error if no stream has this id
  std::span<const PacketRecord> packets() const;  ///< in file order, of declared streams
  PacketIndex index() const;
  const RecordingProblems& problems() const;

  /// The events of one packet, decompressed once and not copied: valid until the next read from this reader. Those outside the
  /// sensor (with a negative place, where the stream declares no size) or of a polarity above 1 are dropped and counted; a packet
  /// that cannot be decoded is counted and gives none.
  /// @throws Error  if the packet is none of this recording's, its stream is of another type, or the file cannot be read
  std::span<Event> read_events(const PacketRecord& packet);
  std::vector<ImuSample> read_imu(const PacketRecord& packet);
  std::vector<Trigger> read_triggers(const PacketRecord& packet);
  std::optional<Frame> read_frame(const PacketRecord& packet);  ///< nothing if it cannot be decoded

  /// The packet as the file has it, still compressed; valid until the next read from this reader, and leaves events that were
  /// read alone. @throws Error likewise
  std::span<const std::byte> read_stored(const PacketRecord& packet);
  /// Whether elements of the packet were dropped or their times put right when it was read. @throws Error likewise
  bool was_put_right(const PacketRecord& packet) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The one event stream, or the one that `choice` names by id or source. @throws Error, listing them, if there is none or more
/// than one left
const Stream& event_stream(const RecordingReader& recording, std::string_view choice = {});

/// Likewise of streams wherever they come from; `where` names them in an error.
const Stream& event_stream(std::span<const Stream> streams, std::string_view where, std::string_view choice = {});

/// Hands every event with `begin <= t < end` of the stream to `use`, packet by packet in file order; reads only packets that
/// overlap.
void for_events_between(RecordingReader& recording, std::int32_t stream_id, CameraTime begin, CameraTime end,
                        const std::function<void(std::span<const Event>)>& use);

/// Likewise all events of the stream.
void for_all_events(RecordingReader& recording, std::int32_t stream_id, const std::function<void(std::span<const Event>)>& use);

}  // namespace tactile
