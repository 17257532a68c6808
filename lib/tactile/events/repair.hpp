#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

struct RepairedStream {
  Stream stream;
  std::uint64_t packets_kept = 0;
  std::uint64_t packets_lost = 0;  ///< broken, of another type, without a sound element, or not what was written
  std::uint64_t bytes_lost = 0;    ///< of those, headers included
  std::uint64_t elements_kept = 0;
  std::uint64_t steps_back = 0;  ///< in time, kept as they are
};

/// What a repair did.
struct RepairSummary {
  std::vector<RepairedStream> streams;
  std::uint64_t packets_damaged = 0;       ///< of those lost: with a checksum that is wrong
  bool header_damaged = false;             ///< by its checksum
  std::uint64_t packets_rewritten = 0;     ///< of those kept: without events that were out of range, or with times put right
  RecordingProblems problems;              ///< of the input, complete
  PacketIndex index = PacketIndex::table;  ///< of the input
  std::uint64_t bytes_in = 0, bytes_out = 0;
  std::map<std::string, std::uint64_t> log_bytes_lost;  ///< of a run's CSV files, by name: rows from the first zero byte on

  std::uint64_t packets_kept() const;
  std::uint64_t packets_lost() const;  ///< those of undeclared streams too
  std::uint64_t bytes_lost() const;    ///< of packets of declared streams, between packets, and behind the last whole one
};

/// Writes what is whole in `in` to `out` and gives it a data table: sound packets bit for bit, those with events outside the
/// sensor without these, those that are not what was written by the checksums beside `in` not at all. Streams keep their ids,
/// sources and attributes. Times that step back are left as they are, and counted: what is right cannot be told.
/// @param threads  to read on, > 0
/// @throws Error  if `out` is `in` or exists already and `replace` is false, `in` is none of AEDAT4, or not one of its packets is
/// sound
RepairSummary repair_recording(const std::filesystem::path& in, const std::filesystem::path& out, bool replace = false,
                               unsigned threads = 1, const ProgressCallback& progress = {});

}  // namespace tactile
