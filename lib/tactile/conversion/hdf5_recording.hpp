#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/stream.hpp"

// A recording as plain HDF5, readable by h5py: `/events` (t_us, x, y, on), `/imu` (t_us, temperature_c, acceleration_g,
// angular_rate_dps, magnetic_field_ut) and `/triggers` (t_us, type). Each column is a table with compressed chunks. The first
// stream of a type has the plain name; further streams append their id, `/events_4`. docs/format/ lists the types.
namespace tactile::conversion {

/// Writes such a file. Memory follows the chunk. Not thread-safe.
class Hdf5RecordingWriter {
 public:
  /// @param streams  of events, IMU and triggers
  /// @throws Error  if a stream has another type, or the file cannot be made
  Hdf5RecordingWriter(const std::filesystem::path& file, std::span<const events::Stream> streams);
  ~Hdf5RecordingWriter();
  Hdf5RecordingWriter(Hdf5RecordingWriter&&) noexcept;
  Hdf5RecordingWriter& operator=(Hdf5RecordingWriter&&) noexcept;

  // Each throws Error if a stream's time goes back, because readers refuse such files. Coordinates must be >= 0.
  void write_events(std::int32_t stream_id, std::span<const events::Event> events);
  void write_imu(std::int32_t stream_id, std::span<const events::ImuSample> samples);
  void write_triggers(std::int32_t stream_id, std::span<const events::Trigger> triggers);
  void close();  ///< @throws Error if the file cannot be written

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads such a file, also if another program wrote it in this layout: integers may have any width, and the streams' attributes
/// are optional. A separate process reads it, because HDF5 may crash on a damaged file (`hdf5::read_apart`).
class Hdf5RecordingReader {
 public:
  /// @param size, source  of the events, if the file does not declare them; otherwise they are an error
  /// @throws Error  if the file is no such recording: a column is missing, has another length, type or shape, or claims more than
  ///                the file can contain; or if it is the events file of a dataset
  explicit Hdf5RecordingReader(const std::filesystem::path& file, std::optional<events::SensorSize> size = std::nullopt,
                               const std::optional<std::string>& source = std::nullopt);
  ~Hdf5RecordingReader();
  Hdf5RecordingReader(Hdf5RecordingReader&&) noexcept;
  Hdf5RecordingReader& operator=(Hdf5RecordingReader&&) noexcept;

  std::span<const events::Stream> streams() const;

  /// Receives what is read, piece by piece.
  struct Taker {
    std::function<void(const events::Stream&, std::span<const events::Event>)> events;
    std::function<void(const events::Stream&, std::span<const events::ImuSample>)> imu;
    std::function<void(const events::Stream&, std::span<const events::Trigger>)> triggers;
  };
  /// Reads the streams with these ids. Their pieces come in order of time, so that an output interleaves them. Progress counts
  /// elements.
  /// @throws Error  that names the table and the row of a time that goes back, or of a value out of range
  void read(std::span<const std::int32_t> stream_ids, const Taker& taker, const ProgressCallback& progress = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::conversion
