#pragma once

#include <filesystem>
#include <functional>

#include "tactile/characterise/characterise.hpp"
#include "tactile/characterise/pixel_counts.hpp"
#include "tactile/characterise/quiet_stretches.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::characterise {

/// One quiet stretch of a recording, as its first reading shows it.
struct ReadRecording {
  std::filesystem::path file;
  std::int32_t stream = 0;
  CameraTime first{}, last{};
  events::Readout readout;

  QuietStretch stretch() const { return {first, after(last, microseconds{1})}; }
  double seconds() const { return std::chrono::duration<double>(between(first, last)).count(); }
};

/// What quiet recordings have in common, and the packets' times.
struct FirstReading {
  std::vector<ReadRecording> recordings;
  PixelCounts counts;
  std::string camera;
  events::Readout readout;  ///< of the first recording, with the combined values of all that have the same kind
  std::optional<PacketTimes> packets;
  double seconds_left_out = 0;  ///< in which something moves

  microseconds shortest() const;
  /// The recording's own, if it is of the same kind as the others.
  const events::Readout& readout_of(const ReadRecording& recording) const {
    return recording.readout.kind == readout.kind && recording.readout.scan == readout.scan ? recording.readout : readout;
  }
};

/// A recording that is open, and its event stream. @throws Error  as `characterise`
class OpenRecording {
 public:
  /// @param expected  the sensor's size, if it is known from another recording
  OpenRecording(const std::filesystem::path& file, const CharacteriseOptions& options,
                std::optional<events::SensorSize> expected);

  const events::Stream& stream() const { return stream_; }
  const events::RecordingReader& reader() const { return reader_; }
  /// The events of every packet of the stream, in file order.
  void for_packets(const std::function<void(std::span<const events::Event>)>& use, const ProgressCallback& progress);
  /// Only those in a stretch.
  void for_packets(const QuietStretch& stretch, const std::function<void(std::span<const events::Event>)>& use,
                   const ProgressCallback& progress);

 private:
  events::RecordingReader reader_;
  events::Stream stream_;
};

/// @throws Error  as `characterise`
FirstReading read_first(const std::vector<std::filesystem::path>& quiet, const CharacteriseOptions& options,
                        const ProgressCallback& progress);

}  // namespace tactile::characterise
