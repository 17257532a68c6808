#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/run_drops.hpp"
#include "tactile/core/clock_pairs.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/robot/robot_monitor.hpp"
#include "tactile/video/video_capture.hpp"

namespace tactile::capture {

struct RunRecorderOptions {
  std::size_t queue_bytes = std::size_t{256} << 20;  ///< packets that wait for the disk [B]; further ones are dropped and counted
  events::Compression compression = events::Compression::lz4;
  std::chrono::milliseconds sync_period{1'000};  ///< between two syncs of the disk, > 0
  /// Called once by `RunRecorder::state` when a source has ended while events continue; not for replays at full speed.
  std::function<void(const std::string&)> log = {};
  /// Called with the events of the first event stream as they arrive, on its source's thread, also between runs. It must return
  /// soon: what takes long delays the recording. Events may lie outside the sensor.
  std::function<void(std::span<const events::Event>)> see_events = {};
  /// The same for the samples of the IMU of that camera, or of another one if it has none.
  std::function<void(std::span<const events::ImuSample>)> see_imu = {};
};

/// A source of a recording, now.
struct SourceState {
  std::string name;
  std::uint64_t packets = 0;  ///< that arrived since the program began
  bool has_ended = false;
  std::string error;  ///< why it is lost; empty if it is not
};

/// One run to record.
struct RunRequest {
  RunFolder run;                         ///< its folder exists and is empty
  std::string session;                   ///< see RunInfo
  std::optional<microseconds> duration;  ///< in host time; if no source is live in camera time, exact to the microsecond
  nlohmann::json settings = nlohmann::json::object();  ///< kept in run.json
};

/// State of the present run.
struct RunState {
  std::chrono::microseconds elapsed{};  ///< since it began
  std::uint64_t events = 0;             ///< written
  std::uint64_t others = 0;             ///< IMU samples, triggers and frames written
  std::uint64_t bytes = 0;              ///< the file's size
  std::size_t queue_bytes = 0;
  RunDrops drops;
  std::optional<ClockOffset> clock;  ///< of the first stream's camera; nothing before its first packet, or unless it is live
  microseconds lateness{0};          ///< of its packets, as `RecentLateness`
  std::optional<robot::RobotMonitorState> robot;
  std::optional<video::VideoCaptureState> video;
  std::string ended;  ///< why it must end now; empty while it can continue
};

struct RunSummary {
  RunFolder run;
  std::string session;
  bool simulated = false;
  bool complete = false;                 ///< its files are closed, and contain everything that is not counted as dropped
  std::uint64_t events = 0, others = 0;  ///< in the recording
  std::uint64_t imu_samples = 0, triggers = 0, frames = 0;  ///< parts of `others`
  std::uint64_t bytes = 0;                                  ///< of all its files except run.json
  std::chrono::microseconds elapsed{};                      ///< host time
  std::chrono::microseconds span{};         ///< camera time from the earliest to the latest element in the recording
  std::chrono::microseconds events_span{};  ///< of the events only
  RunDrops drops;
  std::optional<robot::RobotMonitorState> robot;
  std::optional<video::VideoCaptureState> video;
  std::string ended;                ///< why: "duration", "source ended", "interrupted" …, or the first of `errors`
  std::vector<std::string> errors;  ///< sources that were lost, files that could not be written
};

/// Records runs, one after the other. The sources stay open; what they send between two runs is discarded.
///
/// Each source has its own thread, which never waits for the disk: a queue of bounded memory connects it with the thread that
/// writes. If writing is too slow, the queue grows, then whole packets are dropped and counted. A source that is not live waits
/// instead. Events, IMU samples, triggers and frames of all sources go into one recording, with ids in this order. Elements that
/// step back in time or do not fit their stream are left out and counted. The recording, the robot's log and the film have their
/// final names from the first byte on. A separate thread syncs them every second.
///
/// `run.json` is written when the run begins, with `complete: false`, and again once all files are closed and hashed. Until
/// then a file next to the recording has the packets' checksums. After any failure the data so far is kept and readable.
class RunRecorder {
 public:
  /// `robot` and `video` may be null.
  /// @throws Error  if no source has a stream of events, or two sources have the same stream of the same camera
  RunRecorder(std::vector<std::unique_ptr<CameraSource>> sources, std::unique_ptr<robot::RobotMonitor> robot,
              std::unique_ptr<video::VideoCapture> video, RunRecorderOptions options = {});
  ~RunRecorder();  ///< ends the present run
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  const std::vector<events::Stream>& streams() const;  ///< as the recordings declare them
  bool simulated() const;
  std::vector<SourceState> sources() const;
  const robot::RobotMonitor* robot() const;                  ///< null if there is none
  std::shared_ptr<const video::VideoCapture> video() const;  ///< null if there is none

  /// From now on packets of live sources are discarded until a run begins. Otherwise the first run has everything that the
  /// sources sent before it.
  void discard();

  /// @throws Error  if a file cannot be created; the files of the run are then removed
  void begin(const RunRequest& request);
  RunState state() const;  ///< of the present run

  /// Writes waiting packets, closes and hashes all files. Errors of the disk or the sources are in the summary.
  /// @param why  kept in run.json as `ended`
  RunSummary end(const std::string& why);

  std::string gone() const;  ///< why no further run can be recorded: "source ended", "source gone: …"; empty while one can

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::capture
