#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::review {

/// What a run's list of packets says, without reading its events.
struct RunFacts {
  std::int32_t stream_id = 0;
  CameraTime first{}, last{};  ///< of the events
  std::uint64_t events = 0;    ///< by the list of packets
  events::SensorSize sensor;   ///< 0 x 0 where the stream declares none
  bool has_imu = false, simulated = false;

  double length_s() const { return 1e-6 * static_cast<double>(between(first, last).count()); }
};

/// @throws Error  if the recording cannot be read or has no event
RunFacts read_facts(const RunFolder& run);

/// A work that its owner no longer wants.
struct Cancelled {};

/// Called with the share that is done, in [0, 1]; throws `Cancelled` to end the work.
using Advance = std::function<void(double share)>;

/// The events of a run's recording, read from the file where they are asked for: memory follows the window. Its functions may be
/// called from several threads; one at a time reads.
class RunEvents {
 public:
  /// @throws Error  as `read_facts`
  explicit RunEvents(const RunFolder& run);

  const RunFacts& facts() const { return facts_; }

  /// All events, packet by packet.
  void for_all(const std::function<void(std::span<const events::Event>)>& use, const Advance& advance) const;

  /// All IMU samples, by time.
  std::vector<events::ImuSample> imu() const;

  /// The events in [begin, end), as the file has them; nothing as soon as there are more than `most`.
  std::optional<std::vector<events::Event>> events_in(CameraTime begin, CameraTime end, std::size_t most) const;

  /// The events in [end - history, end) at each pixel: a header of four uint32, width, height, events on and off, little-endian;
  /// then a byte for each pixel, the number of its events on, 255 at most; then the same of those off.
  /// @throws Error  if the stream declares no size
  std::string counts_before(CameraTime end, microseconds history) const;

  /// The heatmap of [end - history, end), byte by byte what `HeatmapRenderer` stores: a header of width, height, events and 0,
  /// then a byte for each cell.
  std::string heatmap_before(CameraTime end, microseconds history) const;

  /// The same as a PNG in false colours, `width` wide at the most.
  std::string picture_before(CameraTime end, microseconds history, int width) const;

 private:
  events::SensorSize sensor() const;

  RunFolder run_;
  RunFacts facts_;
  mutable std::mutex guard_;
  mutable events::RecordingReader recording_;
};

}  // namespace tactile::review
