#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/conversion/pixel_region.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile {

/// The files that a conversion reads and writes, told by their extension whatever its case: .aedat4, .csv, .h5 or .hdf5, .npz
/// (written only).
enum class RecordingFormat : std::uint8_t { aedat4, csv, hdf5, npz };

std::string_view name_of(RecordingFormat format);  ///< "AEDAT4", "CSV", "HDF5", "NPZ"

/// @throws Error  that lists the known extensions, if this file's is none of them
RecordingFormat recording_format_of(const std::filesystem::path& file);

struct ConvertOptions {
  /// Of an AEDAT4 output; else the input's, LZ4 if that is none.
  std::optional<Compression> compression{};
  std::optional<CameraTime> from{};                                   ///< earlier elements are left out
  std::optional<CameraTime> to{};                                     ///< elements at this time and later are left out
  bool from_counts_from_first = false, to_counts_from_first = false;  ///< `from`, `to` from the first element of the streams kept
  std::optional<PixelRegion> crop{};  ///< of events and frames, which it must lie within: others are left out
  /// Of an AEDAT4 or HDF5 input: the event streams to keep, by id or source, with the rest of their cameras' streams; all if
  /// empty.
  std::vector<std::string> streams{};
  /// Of a CSV input; else the smallest of 320x240, 346x260 and 640x480 that holds the events, or their extent if none does. Of an
  /// HDF5 input that does not say it.
  std::optional<SensorSize> size{};
  std::optional<std::string> source{};  ///< the camera to declare, likewise; else "csv" or "hdf5"
  bool replace = false;                 ///< whether an output that exists already may be replaced
  unsigned threads = 1;                 ///< to read an AEDAT4 input on, > 0
};

struct ConvertedStream {
  Stream stream;               ///< as written
  std::uint64_t elements = 0;  ///< written
};

/// What a conversion did.
struct ConvertSummary {
  RecordingFormat from = RecordingFormat::aedat4, to = RecordingFormat::aedat4;
  std::optional<Compression> compression;  ///< of an AEDAT4 output
  std::vector<ConvertedStream> streams;    ///< kept
  std::vector<Stream> left_out;            ///< other event streams, types that the output cannot hold
  std::optional<SensorSize> size;          ///< of the first stream of events, as written
  bool size_guessed = false;               ///< from the extent of a CSV's events
  std::optional<CameraTime> first, last;   ///< of the elements written, over all streams
  std::optional<CameraTime> first_in;      ///< of the elements read, cut or not
  std::uint64_t cropped_events = 0;        ///< within the cut, but outside the crop
  std::uint64_t cropped_frames = 0;        ///< wholly outside it
  std::uint64_t steps_back = 0;            ///< in time, of the events written to CSV or NPZ as they are
  RecordingProblems problems;              ///< of an AEDAT4 input
  std::uint64_t bytes_in = 0, bytes_out = 0;
};

/// From AEDAT4, CSV or HDF5 to AEDAT4, CSV, HDF5 or NPZ; cut by time, cropped. CSV and NPZ hold the events of one stream, HDF5
/// several of them, IMU and triggers, AEDAT4 frames too. A cut reads every packet too, for a data table's times may be wrong. The
/// output appears only once it is whole. Memory follows the packet or the chunk.
/// @throws Error  if input and output are one file, the output exists already, a format is unknown, an option does not apply, cut
///                or crop leave nothing, or the input cannot be used: of several event streams a CSV or NPZ takes one, an
///                AEDAT4 or HDF5 output takes no times that step back, and an AEDAT4 or NPZ no events without a sensor size
ConvertSummary convert_recording(const std::filesystem::path& in, const std::filesystem::path& out,
                                 const ConvertOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile
