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

namespace tactile {

/// Elements of one stream as a source hands them over, ascending in time. The vectors are used again from packet to packet.
struct CameraPacket {
  std::int32_t stream_id = 0;  ///< one of the source's streams
  std::vector<Event> events;
  std::vector<ImuSample> imu;
  std::vector<Trigger> triggers;
  std::optional<Frame> frame;
  std::optional<HostTime> arrived = {};  ///< at this machine, where the source tells that; else when it was received
  bool more_came = false;                ///< with it: `arrived` is when that came, and this packet before

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

/// What became of elements that were not recorded.
struct LostElements {
  std::uint64_t packets = 0;  ///< lost whole
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

/// Of one packet with all that is in it.
LostElements count_of(const CameraPacket& packet);

/// What was lost before it came to us, or was not fit to be recorded. Counts never fall.
struct SourceDrops {
  std::uint64_t packets = 0;  ///< broken, lost by the device's driver, or earlier as a whole
  std::uint64_t events = 0;   ///< outside the sensor, or earlier
  std::uint64_t others = 0;   ///< IMU samples, triggers and frames that were earlier
  LostElements back_in_time;  ///< of all these: what was earlier than what its stream had brought before

  LostElements total() const { return {.packets = packets, .events = events, .others = others}; }
  SourceDrops& operator+=(const SourceDrops& more) {
    packets += more.packets, events += more.events, others += more.others;
    back_in_time += more.back_in_time;
    return *this;
  }
  friend bool operator==(const SourceDrops&, const SourceDrops&) = default;
};

/// A live camera, or what stands for one. Used from one thread.
class CameraSource {
 public:
  enum class Received : std::uint8_t { packet, nothing, ended };

  virtual ~CameraSource() = default;

  virtual std::string name() const = 0;  ///< as the user wrote it
  virtual std::span<const Stream> streams() const = 0;
  virtual bool simulated() const { return false; }
  /// Whether it goes on whether or not anyone keeps up, so that what is not taken in time is lost. A file or simulator that goes
  /// as fast as it can waits instead.
  virtual bool live() const { return true; }
  /// For run.json's "camera": source, readout_mode, biases and whatever else is known.
  virtual nlohmann::json camera() const = 0;

  /// Whether packets know when they arrived, however late they are asked for: who receives them may do something else meanwhile.
  virtual bool tells_arrivals() const { return false; }

  /// What a person should know ahead of the first packet, such as what a recording lacks, in one line; mostly nothing.
  virtual std::string remark() const { return {}; }

  /// Waits up to `patience` for the next elements and puts them into `packet`. `ended`: nothing will come any more. Silence is
  /// legal. @throws Error  if the source is gone or sends what cannot be
  virtual Received receive(CameraPacket& packet, std::chrono::microseconds patience) = 0;

  virtual SourceDrops drops() const = 0;

  // A simulator knows the robot and the video too, and what is true: others leave these as they are.

  /// Whether it begins anew with every `begin_run` after it has ended.
  virtual bool begins_again() const { return false; }
  /// What comes from here on belongs to this run, whose folder is there.
  virtual void begin_run(const RunFolder& run) { static_cast<void>(run); }
  /// The run's recording is closed: the files that only the source can make are written beside it, robot.csv and the video only
  /// where they are wanted. @throws Error if they cannot be written
  virtual void end_run(const RunFolder& run, bool wants_robot, bool wants_video) {
    static_cast<void>(run), static_cast<void>(wants_robot), static_cast<void>(wants_video);
  }
};

struct CameraSourceOptions {
  double speed = 1;                               ///< of files and the simulator: 1 real time, 0 as fast as it goes, >= 0
  std::uint64_t seed = 1;                         ///< of the simulator
  std::string readout_mode = {};                  ///< of a camera, such as "variable-5000"; empty: the default
  std::string stream = {};                        ///< of a file with several event streams: the one to play, by id or source;
                                                  ///< other sources take none
  std::chrono::microseconds packet_span{10'000};  ///< of a file: a packet's elements lie less than this apart, > 0
};

/// Opens `tcp://host:port`, `unix:PATH`, `file:PATH`, `sim[:OBJECT]` or `camera[:SERIAL]`.
/// @throws Error  if `text` is none of these, or the source cannot be opened
std::unique_ptr<CameraSource> open_camera_source(const std::string& text, const CameraSourceOptions& options = {});

}  // namespace tactile
