#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

/// The files that a conversion reads and writes, told by their extension whatever its case.
enum class RecordingFormat : std::uint8_t { aedat4, csv };

/// @throws Error  that lists the known extensions, if this file's is none of them
RecordingFormat recording_format_of(const std::filesystem::path& file);

struct ConvertOptions {
  /// Of an AEDAT4 output; else the input's, LZ4 if that is CSV.
  std::optional<Compression> compression{};
  std::optional<CameraTime> from{};  ///< earlier elements are left out
  std::optional<CameraTime> to{};    ///< elements at this time and later are left out
  /// Of an AEDAT4 input: the event stream to keep, by id or source, with the rest of its camera's streams; all if empty.
  std::string stream{};
  /// Of a CSV input; else the smallest of 320x240, 346x260 and 640x480 that holds the events, or their extent if none does.
  std::optional<SensorSize> size{};
  std::optional<std::string> source{};  ///< of a CSV input: the camera to declare; else "csv"
  bool replace = false;                 ///< whether an output that exists already may be replaced
  unsigned threads = 1;                 ///< to read an AEDAT4 input on, > 0
};

struct ConvertedStream {
  Stream stream;
  std::uint64_t elements = 0;  ///< written
};

/// What a conversion did.
struct ConvertSummary {
  RecordingFormat from = RecordingFormat::aedat4, to = RecordingFormat::aedat4;
  std::optional<Compression> compression;  ///< of an AEDAT4 output
  std::vector<ConvertedStream> streams;    ///< kept
  std::vector<Stream> left_out;            ///< other event streams, types that the output cannot hold
  std::optional<SensorSize> size;          ///< of the events
  bool size_guessed = false;               ///< from the extent of a CSV's events
  std::optional<CameraTime> first, last;   ///< of the elements written, over all streams
  std::uint64_t steps_back = 0;            ///< in time, of the events written to a CSV as they are
  RecordingProblems problems;              ///< of an AEDAT4 input
  std::uint64_t bytes_in = 0, bytes_out = 0;
};

/// AEDAT4 to AEDAT4, AEDAT4 to CSV (events only), CSV to AEDAT4; cut by time. The output appears only once it is whole. Memory
/// follows the packet, and the chunk of a CSV.
/// @throws Error  if input and output are one file, the output exists already, a format is unknown, an option does not apply, the
///                cut leaves nothing, or the input cannot be used: of several event streams a CSV takes one, and an AEDAT4 output
///                takes no times that step back
ConvertSummary convert_recording(const std::filesystem::path& in, const std::filesystem::path& out,
                                 const ConvertOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile
