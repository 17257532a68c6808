#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/run_drops.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/robot/robot_monitor.hpp"
#include "tactile/video/video_capture.hpp"

namespace tactile {

struct RunRecorderOptions {
  std::size_t queue_bytes = std::size_t{256} << 20;  ///< packets that wait for the disk [B]; more are dropped and counted
  Compression compression = Compression::lz4;
  std::chrono::milliseconds sync_period{1'000};  ///< how often everything is brought to the disk, > 0
  /// Told of a source that has ended while events go on, once, by `RunRecorder::state`; never of replays that do not wait.
  std::function<void(const std::string&)> log = {};
};

/// One run to record.
struct RunRequest {
  RunFolder run;                         ///< its folder is there, and empty
  std::string session;                   ///< see RunInfo
  std::optional<microseconds> duration;  ///< by the host's clock; where no source is live by the camera's, cut to the microsecond
  nlohmann::json settings = nlohmann::json::object();  ///< kept in run.json
};

/// How the present run goes.
struct RunState {
  std::chrono::microseconds elapsed{};  ///< since it began
  std::uint64_t events = 0;             ///< handed to the file
  std::uint64_t others = 0;             ///< IMU samples, triggers and frames likewise
  std::uint64_t bytes = 0;              ///< the file's size
  std::size_t queue_bytes = 0;
  RunDrops drops;
  std::optional<RobotMonitorState> robot;
  std::optional<VideoCaptureState> video;
  std::string ended;  ///< why it must end now; empty while it can go on
};

struct RunSummary {
  RunFolder run;
  std::string session;
  bool simulated = false;
  bool complete = false;                 ///< everything that was not counted as dropped is in its files, and these are closed
  std::uint64_t events = 0, others = 0;  ///< that the recording holds
  std::uint64_t imu_samples = 0, triggers = 0, frames = 0;  ///< of the others
  std::uint64_t bytes = 0;                                  ///< of all of its files but run.json
  std::chrono::microseconds elapsed{};                      ///< of the host
  std::chrono::microseconds span{};         ///< from the earliest to the latest element that the recording holds, of the camera
  std::chrono::microseconds events_span{};  ///< likewise of the events alone
  RunDrops drops;
  std::optional<RobotMonitorState> robot;
  std::optional<VideoCaptureState> video;
  std::string ended;                ///< why: "duration", "source ended", "interrupted" …, or the first of `errors`
  std::vector<std::string> errors;  ///< sources that are gone, files that could not be written; empty after a good run
};

/// Records runs, one after the other, from sources that stay open in between; what they send then is discarded.
///
/// Each source is received on a thread of its own, which never waits for the disk: a queue of bounded memory stands between it
/// and the thread that writes. Where that falls behind the queue grows, then whole packets are dropped and counted. A source that
/// is not live waits instead. Events, IMU samples, triggers and frames of all sources go into one recording, with ids in this
/// order; elements that step back in time or do not fit their stream are left out and counted. The recording, the robot's log and
/// the film bear their final names from the first byte and are brought to the disk every second, from a thread that only does
/// that.
///
/// `run.json` is written when the run begins, with `complete: false`, and again once all files are closed and hashed. Until then
/// the packets' checksums lie beside the recording. Whatever goes wrong, what came until then is kept and readable.
class RunRecorder {
 public:
  /// The robot and the film may be missing.
  /// @throws Error  if no source has a stream of events, or two sources have the same stream of the same camera
  RunRecorder(std::vector<std::unique_ptr<CameraSource>> sources, std::unique_ptr<RobotMonitor> robot,
              std::unique_ptr<VideoCapture> video, RunRecorderOptions options = {});
  ~RunRecorder();  ///< ends a run that was begun
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  const std::vector<Stream>& streams() const;  ///< as the recordings declare them
  bool simulated() const;
  const RobotMonitor* robot() const;  ///< null if there is none

  /// From now on what live sources send is discarded until a run begins, as it is between two runs. Without it the first run has
  /// everything from the sources' first moment on.
  void discard();

  /// @throws Error  if a file cannot be made; what was made of the run is then removed
  void begin(const RunRequest& request);
  RunState state() const;  ///< of the run that was begun

  /// Writes what still waits, closes and hashes everything. `why` is kept in run.json as `ended`. Never throws for what can go
  /// wrong outside: the summary says it.
  RunSummary end(const std::string& why);

  std::string gone() const;  ///< why no further run can be recorded: "source ended", "source gone: …"; empty while one can

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
