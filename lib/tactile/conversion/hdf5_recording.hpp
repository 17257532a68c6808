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

// A recording as plain HDF5, which h5py opens as it is: `/events` (t_us, x, y, on), `/imu` (t_us, temperature_c, acceleration_g,
// angular_rate_dps, magnetic_field_ut) and `/triggers` (t_us, type), one table a column, in compressed chunks. Of several streams
// of one type the first has the plain name and each further one its id behind it, `/events_4`. docs/format.md has the types.
namespace tactile {

/// Writes one. Memory follows the chunk. Not for several threads at once.
class Hdf5RecordingWriter {
 public:
  /// Streams of events, IMU and triggers. @throws Error if there is another, or the file cannot be made
  Hdf5RecordingWriter(const std::filesystem::path& file, std::span<const Stream> streams);
  ~Hdf5RecordingWriter();
  Hdf5RecordingWriter(Hdf5RecordingWriter&&) noexcept;
  Hdf5RecordingWriter& operator=(Hdf5RecordingWriter&&) noexcept;

  /// Places must be >= 0. @throws Error, as its siblings, if a stream's time goes back: what reads the file refuses that
  void write_events(std::int32_t stream_id, std::span<const Event> events);
  void write_imu(std::int32_t stream_id, std::span<const ImuSample> samples);
  void write_triggers(std::int32_t stream_id, std::span<const Trigger> triggers);
  void close();  ///< @throws Error if the file cannot be written

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads one, also if another program made it: whole numbers of any width, a stream's attributes where they are there. A process
/// of its own does the reading, since HDF5 may crash on a damaged file (`hdf5::read_apart`).
class Hdf5RecordingReader {
 public:
  /// `size`, `source`: of the events where the file does not say them; it is an error to give what it says.
  /// @throws Error  if the file is none, lacks a column, its columns differ in length, hold another type or shape, or claim more
  ///                than the file can hold; or if it is the events file of a dataset
  explicit Hdf5RecordingReader(const std::filesystem::path& file, std::optional<SensorSize> size = std::nullopt,
                               const std::optional<std::string>& source = std::nullopt);
  ~Hdf5RecordingReader();
  Hdf5RecordingReader(Hdf5RecordingReader&&) noexcept;
  Hdf5RecordingReader& operator=(Hdf5RecordingReader&&) noexcept;

  std::span<const Stream> streams() const;

  /// Takes what is read, piece by piece.
  struct Taker {
    std::function<void(const Stream&, std::span<const Event>)> events;
    std::function<void(const Stream&, std::span<const ImuSample>)> imu;
    std::function<void(const Stream&, std::span<const Trigger>)> triggers;
  };
  /// Reads the streams with these ids, their pieces by time so that they lie beside each other in what is made of them. Progress
  /// counts elements.
  /// @throws Error  that names the table and row of a time that goes back, or a value out of range
  void read(std::span<const std::int32_t> stream_ids, const Taker& taker, const ProgressCallback& progress = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
