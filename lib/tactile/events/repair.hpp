#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::events {

struct RepairedStream {
  Stream stream;
  std::uint64_t packets_kept = 0;
  std::uint64_t packets_lost = 0;  ///< broken, of another type, without a sound element, or with a wrong checksum
  std::uint64_t bytes_lost = 0;    ///< of the lost packets, headers included
  std::uint64_t elements_kept = 0;
  std::uint64_t steps_back = 0;  ///< in time; kept as they are
};

/// What a repair did.
struct RepairSummary {
  std::vector<RepairedStream> streams;
  std::uint64_t packets_damaged = 0;       ///< of the lost ones: with a wrong checksum
  bool header_damaged = false;             ///< according to its checksum
  std::uint64_t packets_rewritten = 0;     ///< of the kept ones: events out of range removed, or times corrected
  RecordingProblems problems;              ///< of the input, complete
  PacketIndex index = PacketIndex::table;  ///< of the input
  std::uint64_t bytes_in = 0, bytes_out = 0;
  std::map<std::string, std::uint64_t> log_bytes_lost;  ///< of a run's CSV files, by name: the rows from the first zero byte on

  std::uint64_t packets_kept() const;
  std::uint64_t packets_lost() const;  ///< undeclared streams included
  std::uint64_t bytes_lost() const;    ///< of packets of declared streams, between packets, and after the last whole one
};

/// Writes the sound packets of `in` to `out` and adds a data table. Sound packets are copied bit for bit. Events outside the
/// sensor are removed. Packets with a wrong checksum, in the file next to `in`, are omitted. Streams keep their ids, sources
/// and attributes. Steps back in time stay and are counted, because the true times are unknown.
/// @param threads  threads that read, > 0
/// @throws Error  if `out` is `in`, `out` exists and `replace` is false, `in` is not AEDAT4, or none of its packets is sound
RepairSummary repair_recording(const std::filesystem::path& in, const std::filesystem::path& out, bool replace = false,
                               unsigned threads = 1, const ProgressCallback& progress = {});

}  // namespace tactile::events
