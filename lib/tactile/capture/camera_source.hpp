#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::capture {

/// Elements of one stream, ascending in time. The vectors are reused from packet to packet.
struct CameraPacket {
  std::int32_t stream_id = 0;  ///< one of the source's streams
  std::vector<events::Event> events;
  std::vector<events::ImuSample> imu;
  std::vector<events::Trigger> triggers;
  std::optional<events::Frame> frame;
  std::optional<HostTime> arrived = {};  ///< when it reached this machine, if the source reports that
  bool more_came = false;                ///< further data arrived with it: `arrived` is their time, this packet came earlier

  void clear() {
    events.clear();
    imu.clear();
    triggers.clear();
    frame.reset();
    arrived.reset();
    more_came = false;
  }
  bool empty() const { return events.empty() && imu.empty() && triggers.empty() && !frame; }
};

/// Counts of elements that were not recorded.
struct LostElements {
  std::uint64_t packets = 0;  ///< lost completely
  std::uint64_t events = 0;
  std::uint64_t others = 0;  ///< IMU samples, triggers and frames

  LostElements& operator+=(const LostElements& more) {
    packets += more.packets, events += more.events, others += more.others;
    return *this;
  }
  friend LostElements operator-(const LostElements& all, const LostElements& part) {
    return {.packets = all.packets - part.packets, .events = all.events - part.events, .others = all.others - part.others};
  }
  friend bool operator==(const LostElements&, const LostElements&) = default;
};

/// One packet and its contents.
LostElements count_of(const CameraPacket& packet);

/// Elements that were lost before they reached this machine, or cannot be recorded. Counts never decrease.
struct SourceDrops {
  std::uint64_t packets = 0;  ///< broken, lost by the device's driver, or completely back in time
  std::uint64_t events = 0;   ///< outside the sensor, or back in time
  std::uint64_t others = 0;   ///< IMU samples, triggers and frames that were back in time
  LostElements back_in_time;  ///< of all these: earlier than previous elements of their stream

  LostElements total() const { return {.packets = packets, .events = events, .others = others}; }
  SourceDrops& operator+=(const SourceDrops& more) {
    packets += more.packets, events += more.events, others += more.others;
    back_in_time += more.back_in_time;
    return *this;
  }
  friend bool operator==(const SourceDrops&, const SourceDrops&) = default;
};

/// A camera, or a stream, file or simulator in its place. Used from one thread.
class CameraSource {
 public:
  enum class Received : std::uint8_t { packet, nothing, ended };

  virtual ~CameraSource() = default;

  virtual std::string name() const = 0;  ///< as the user wrote it
  virtual std::span<const events::Stream> streams() const = 0;
  virtual bool simulated() const { return false; }
  /// Whether packets that are not received in time are lost. A file or simulator at full speed waits instead.
  virtual bool live() const { return true; }
  /// For run.json's "camera": source, readout_mode, biases and further known properties.
  virtual nlohmann::json camera() const = 0;

  /// Whether it plays a recording.
  virtual bool is_replay() const { return false; }
  /// Whether it can be opened again after it broke.
  virtual bool can_reopen() const { return false; }

  /// Whether packets have the time at which they reached this machine, even if they are received later.
  virtual bool reports_arrivals() const { return false; }

  /// A warning before the first packet, such as what a recording lacks, in one line; usually empty.
  virtual std::string remark() const { return {}; }

  /// Waits up to `patience` for the next elements and puts them into `packet`. `nothing`: none arrived. `ended`: the source has
  /// ended. @throws Error  if the source is lost or sends impossible data
  virtual Received receive(CameraPacket& packet, std::chrono::microseconds patience) = 0;

  virtual SourceDrops drops() const = 0;

  // For the simulator, which also produces the robot's log, the video and the truth.

  /// Whether it starts again with every `begin_run` after it has ended.
  virtual bool begins_again() const { return false; }
  /// The following packets belong to this run, whose folder exists.
  virtual void begin_run(const RunFolder& run) { static_cast<void>(run); }
  /// Writes the files of the run that only the source can produce, once its recording is closed. robot.csv and the video are
  /// written on request. @throws Error  if they cannot be written
  virtual void end_run(const RunFolder& run, bool wants_robot, bool wants_video) {
    static_cast<void>(run), static_cast<void>(wants_robot), static_cast<void>(wants_video);
  }
};

struct CameraSourceOptions {
  double speed = 1;                               ///< of files and the simulator, >= 0: 1 is real time, 0 is as fast as possible
  std::uint64_t seed = 1;                         ///< of the simulator
  std::string readout_mode = {};                  ///< of a camera, such as "variable-5000"; empty: the default
  std::string stream = {};                        ///< of a file with several event streams: the one to play, by id or source;
                                                  ///< must be empty for other sources
  std::chrono::microseconds packet_span{10'000};  ///< of a file: longest time within a packet, > 0
};

/// Opens `tcp://host:port`, `unix:PATH`, `file:PATH`, `sim[:OBJECT]` or `camera[:SERIAL]`.
/// @throws Error  if `text` is none of these, or the source cannot be opened
std::unique_ptr<CameraSource> open_camera_source(const std::string& text, const CameraSourceOptions& options = {});

}  // namespace tactile::capture
