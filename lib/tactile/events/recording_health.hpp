#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/hot_pixels.hpp"
#include "tactile/events/readout.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::events {

struct HealthOptions {
  std::string stream{};       ///< the event stream to examine, by id or source; all if empty
  microseconds gap{100'000};  ///< a longer silence is reported, > 0
  microseconds tick{2'000};   ///< the peak rate is that of the fullest tick, > 0; ticks begin at whole multiples of it
  std::size_t listed = 10;    ///< how many gaps, hot pixels and damaged packets are listed; all are counted
  HotPixelRule hot{};
  bool checksums = false;  ///< compare the packets with the checksums beside the recording, if there are any
  unsigned threads = 1;    ///< threads that read, > 0
};

/// A silence longer than the limit: nothing in `begin < t < end`. A quiet scene has silences too. The inertial sensor samples all
/// the time: if it is silent as well, data is missing.
struct Gap {
  CameraTime begin{}, end{};
  bool imu_silent = false;

  microseconds length() const { return between(begin, end); }
};

/// The time stamps of one stream. Only a stamp later than all before it can end a gap.
struct StampHealth {
  std::uint64_t elements = 0;
  CameraTime first{}, last{};                    ///< earliest and latest; meaningless without elements
  std::uint64_t steps_back_in_packets = 0;       ///< a stamp earlier than the one before it in its packet
  std::uint64_t steps_back_between_packets = 0;  ///< a packet's first stamp earlier than the last stamp of the packet before it
  std::uint64_t gaps = 0;
  microseconds silent{};          ///< total length of the gaps
  std::vector<Gap> longest_gaps;  ///< the longest ones, in order of time

  microseconds duration() const { return elements == 0 ? microseconds{} : between(first, last); }
  std::optional<double> rate_hz() const;  ///< elements / duration; nothing if the duration is 0
};

/// Takes the time stamps of a stream packet by packet.
class StampMeter {
 public:
  StampMeter(microseconds gap, std::size_t listed) : gap_(gap), listed_(listed) {}

  void begin_packet() { at_packet_begin_ = true; }
  void add(CameraTime t) {
    if (stamps_.elements++ == 0) {
      stamps_.first = stamps_.last = t;
    } else {
      if (t < previous_) ++(at_packet_begin_ ? stamps_.steps_back_between_packets : stamps_.steps_back_in_packets);
      if (t > stamps_.last) {
        if (between(stamps_.last, t) > gap_) note_gap(stamps_.last, t);
        stamps_.last = t;
      } else if (t < stamps_.first) {
        stamps_.first = t;
      }
    }
    previous_ = t;
    at_packet_begin_ = false;
  }
  StampHealth health() const;

 private:
  void note_gap(CameraTime begin, CameraTime end);

  microseconds gap_;
  std::size_t listed_;
  StampHealth stamps_;
  CameraTime previous_{};
  bool at_packet_begin_ = true;
};

/// Health of an event stream.
struct EventHealth {
  std::uint64_t on = 0;                ///< events of polarity 1
  std::uint64_t peak_tick_events = 0;  ///< in the fullest tick
  double peak_rate_hz = 0;             ///< peak_tick_events / length of a tick
  std::uint64_t pixels_fired = 0;
  bool pixels_counted = false;  ///< whether the sensor's size is declared and valid; required for hot pixels
  std::uint64_t hot_pixels = 0;
  std::uint64_t hot_events = 0;   ///< of the hot pixels
  std::vector<HotPixel> hottest;  ///< sorted by events, most first

  Readout readout;  ///< as the beginning of the stream shows it
};

/// Takes the events of one stream packet by packet; keeps 4 bytes per pixel of the sensor, and 2^19 time stamps at most.
class EventMeter {
 public:
  /// Pixels are counted if `size` is given and has at most `most_pixels`.
  EventMeter(std::optional<SensorSize> size, const HealthOptions& options);

  void add_packet(std::span<const Event> events);
  StampHealth stamps() const { return stamps_.health(); }
  EventHealth health() const;

  static constexpr std::int64_t most_pixels = std::int64_t{1} << 24;

 private:
  void find_hot_pixels(EventHealth& health) const;

  HealthOptions options_;
  SensorSize size_;
  StampMeter stamps_;
  std::uint64_t on_ = 0;
  CameraTime tick_begin_{}, tick_end_{};  ///< of the tick that is being counted
  std::uint64_t tick_events_ = 0, peak_tick_events_ = 0;
  bool any_ = false;
  std::vector<std::uint32_t> counts_;  ///< per pixel, row by row; limited to the largest value
  ReadoutMeter readout_;
};

struct StreamHealth {
  Stream stream;
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;  ///< as stored, packet headers included
  StampHealth stamps;
  std::optional<EventHealth> events;  ///< only of an examined event stream
};

/// What the checksums of the packets show, over all streams.
struct ChecksumHealth {
  bool header_damaged = false;
  std::uint64_t whole = 0, damaged = 0, not_covered = 0;  ///< packets
  struct Packet {
    std::size_t index = 0;  ///< in the order of the file
    PacketRecord record;
  };
  std::vector<Packet> first_damaged;
};

/// What a recording contains, and whether it is sound.
struct RecordingHealth {
  std::filesystem::path file;
  std::uint64_t file_size = 0;
  RecordingEncoding encoding = RecordingEncoding::aedat4;
  Compression compression = Compression::none;
  PacketIndex index = PacketIndex::table;
  RecordingProblems problems;
  std::vector<StreamHealth> streams;        ///< as declared, without event streams that were not chosen
  std::optional<ChecksumHealth> checksums;  ///< if they were used
  std::vector<std::string> reasons;  ///< why it is not healthy: truncated, damaged between packets, broken or foreign packets,
                                     ///< an unusable data table, events out of range, time that steps back, no events, no valid
                                     ///< sensor size, a period with neither events nor IMU samples, a wrong checksum
  std::vector<std::string> notes;    ///< worth knowing, but not unhealthy: never closed (all packets whole, but no table, or none
                                     ///< that the header names), gaps, hot pixels, empty packets, corrected times

  bool healthy() const { return reasons.empty(); }
  std::uint64_t packets() const;
  std::optional<CameraTime> first() const;  ///< earliest over the streams; nothing if all are empty
  std::optional<CameraTime> last() const;   ///< latest over the streams
  microseconds duration() const;            ///< from `first` to `last`
};

/// Reads every packet once; memory follows the packet.
/// @throws Error  if the file is not AEDAT4, or has no event stream named `options.stream`
RecordingHealth examine_recording(const std::filesystem::path& file, const HealthOptions& options = {},
                                  const ProgressCallback& progress = {});

}  // namespace tactile::events
