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
#include "tactile/events/event_csv.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/recipes/recipe.hpp"

namespace tactile::conversion {

/// The formats of a conversion, given by the extension in upper or lower case: .aedat4, .csv or .txt, .h5 or .hdf5, .npz (output
/// only), .raw (input only).
enum class RecordingFormat : std::uint8_t { aedat4, csv, hdf5, npz, raw };

std::string_view name_of(RecordingFormat format);  ///< "AEDAT4", "CSV", "HDF5", "NPZ", "RAW"

/// The extension in lower case, with its dot.
std::string lower_extension(const std::filesystem::path& file);

/// @throws Error  that lists the known extensions, if the file has another one
RecordingFormat recording_format_of(const std::filesystem::path& file);

struct ConvertOptions {
  /// Of an AEDAT4 output. Default: that of an AEDAT4 input, otherwise LZ4.
  std::optional<events::Compression> compression{};
  std::optional<CameraTime> from{};  ///< earlier elements are omitted
  std::optional<CameraTime> to{};    ///< elements at this time and later are omitted
  bool from_counts_from_first = false,
       to_counts_from_first = false;  ///< `from`, `to` count from the first element of the kept streams
  std::optional<PixelRegion> crop{};  ///< of events and frames; must lie inside the sensor
  /// Of an AEDAT4 or HDF5 input: the event streams to keep, by id or source, with the other streams of their cameras; all if
  /// empty.
  std::vector<std::string> streams{};
  /// Of a CSV input, or of an HDF5 input without a size. Default for CSV: the smallest of 320x240, 346x260 and 640x480 that
  /// contains the events, or their extent if none does.
  std::optional<events::SensorSize> size{};
  std::optional<std::string> source{};     ///< the camera to declare for such an input; default "csv" or "hdf5"
  events::EventCsvOptions csv{};           ///< the columns of a CSV input, and the unit of its times
  std::vector<recipes::Recipe> recipes{};  ///< applied to each stream of events, after cut and crop
  bool replace = false;                    ///< whether an existing output may be replaced
  unsigned threads = 1;                    ///< threads that read an AEDAT4 input, > 0
};

struct ConvertedStream {
  events::Stream stream;       ///< as written
  std::uint64_t elements = 0;  ///< written
};

/// What a conversion did.
struct ConvertSummary {
  RecordingFormat from = RecordingFormat::aedat4, to = RecordingFormat::aedat4;
  std::optional<events::Compression> compression;  ///< of an AEDAT4 output
  std::vector<ConvertedStream> streams;            ///< kept
  std::vector<events::Stream> left_out;            ///< other event streams, and types that the output format lacks
  std::optional<events::SensorSize> size;          ///< of the first stream of events, as written
  bool size_guessed = false;                       ///< derived from a CSV's events
  std::optional<events::TimeUnit> time_unit;       ///< of a CSV input
  bool time_unit_guessed = false;                  ///< because the times of a CSV have a fraction
  events::TimeOverflows overflows;                 ///< of a CSV's times, undone
  std::optional<CameraTime> first, last;           ///< of the elements written, over all streams
  std::optional<CameraTime> first_in;              ///< of the elements read, cut or not
  std::uint64_t cropped_events = 0;                ///< inside the cut, but outside the crop
  std::uint64_t cropped_frames = 0;                ///< completely outside the crop
  std::uint64_t steps_back = 0;                    ///< in time, of the events written to CSV or NPZ
  events::RecordingProblems problems;              ///< of an AEDAT4 input
  std::uint64_t bytes_in = 0, bytes_out = 0;
};

/// Converts AEDAT4, Prophesee RAW, CSV or HDF5 to AEDAT4, CSV, HDF5 or NPZ, with an optional cut by time and a crop. CSV and NPZ
/// contain the events of one stream; HDF5 several streams, IMU and triggers; AEDAT4 also frames. Every packet is read even with a
/// cut, because the times in a data table may be wrong. The output appears only when it is complete. Memory follows the packet or
/// the chunk.
/// @throws Error  if input and output are the same file, the output exists, a format is unknown, an option does not apply, cut or
///                crop contain nothing, or the output format cannot represent the input: CSV and NPZ have one event stream,
///                AEDAT4 and HDF5 no steps back in time, AEDAT4 and NPZ no events without a sensor size
ConvertSummary convert_recording(const std::filesystem::path& in, const std::filesystem::path& out,
                                 const ConvertOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile::conversion
