#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/detect/live_detector.hpp"
#include "tactile/detect/robot_reporter.hpp"
#include "tactile/detect/scene_watch.hpp"
#include "tactile/detect/session_recording.hpp"
#include "tactile/detect/verdict_counts.hpp"

namespace tactile::detect {

struct DetectionOptions {
  std::string source;  ///< as `open_camera_source` takes it
  capture::CameraSourceOptions source_options;
  TickDetectorOptions detector;                         ///< rendering and decision
  microseconds slack{2'000};                            ///< a tick waits this long for late events, >= 0
  bool rehearses = true;                                ///< run the model once before each tick
  std::chrono::milliseconds reconnect{10'000};          ///< a source that broke is opened again for this long, >= 0
  std::optional<microseconds> duration;                 ///< > 0; by the host's clock, or of a replay by the camera's
  bool real_time = true;                                ///< real-time priority and locked memory; never for replays
  bool awake = false;                                   ///< keep processor cores awake
  std::optional<transport::NetworkAddress> udp = {};    ///< send a record there at each tick
  std::optional<RobotReporterOptions> robot = {};       ///< report to this robot
  std::optional<SessionRecordingOptions> record = {};   ///< also record the run
  std::optional<characterise::SceneRanges> scene = {};  ///< of the training runs: reports when the scene leaves them
  /// Called with all events as they arrive, on the thread of the source; it must return soon. They may lie outside the sensor.
  std::function<void(std::span<const events::Event>)> see_events = {};
  std::function<void(const std::string&)> inform = [](const std::string&) {};  ///< messages; any thread
  std::function<void(const std::string&)> warn = [](const std::string&) {};    ///< faults and other warnings; any thread
};

/// What the caller does with the ticks while a session runs, on the thread that called `run`. An exception ends the session.
struct TickOutput {
  std::function<void(const ReportedTick&)> episode = [](const auto&) {};          ///< the first tick of a press or slip
  std::function<void(const VerdictEpisode&)> confirmed = [](const auto&) {};      ///< a slip, once it is confirmed
  std::function<void(const VerdictEpisode&)> episode_end = [](const auto&) {};    ///< once it is over, or at the end
  std::function<void(std::span<const ReportedTick>)> ticks = [](const auto&) {};  ///< the ticks since the last call, maybe none
  std::function<void()> end = [] {};                                              ///< after the last tick
  std::function<bool()> interrupted = [] { return false; };                       ///< whether to stop
};

struct DetectionSummary {
  std::string source;
  bool simulated = false, plays = false;  ///< `plays`: a replay, whose ticks have no deadline
  TickDetectorOptions detector;
  std::chrono::microseconds elapsed{};
  double cpu_s = 0;
  std::string ended;  ///< why: "duration", "source ended", "interrupted", or an error
  LiveCounts counts;
  VerdictCounts verdicts;
  DeadlineMonitor deadlines{std::chrono::milliseconds(2)};
  std::optional<microseconds> proposed_slack;  ///< `LateEvents::proposed_slack`
  microseconds longest_packet{0};
  capture::SourceDrops drops;
  std::uint64_t reopened = 0;
  std::map<std::string, std::uint64_t> faults;  ///< how often each kind occurred
  std::vector<DetectionFault> first_faults;
  bool used_real_time = false;
  std::vector<std::string> real_time_refused;  ///< what the system refused of it
  std::optional<std::string> awake_refused;    ///< with `awake`: why cores may sleep, empty if they stay awake
  std::optional<RobotReporterSummary> robot;
  std::optional<std::array<std::uint64_t, 2>> udp;  ///< records sent and failed
  std::optional<capture::RunSummary> recorded;
  std::optional<SceneSummary> scene;
  std::uint64_t ticks_left_out = 0;  ///< ticks that `TickOutput` did not receive, because it was too slow
  std::exception_ptr failure;        ///< an error that ended the session
};

/// Opens the model for a sensor. @throws Error  if it does not suit
using OpenModel = std::function<std::unique_ptr<model::EventClassifier>(events::SensorSize sensor)>;

/// Detects press and slip in one source until it ends: opens it, again if it breaks; reports each tick by UDP, to a robot and to
/// the caller; records the run.
class DetectionSession {
 public:
  /// Opens the source and the outputs.
  /// @throws Error  if the source or an output cannot be opened, or the sensor does not suit the model
  DetectionSession(DetectionOptions options, const OpenModel& open);
  ~DetectionSession();
  DetectionSession(const DetectionSession&) = delete;
  DetectionSession& operator=(const DetectionSession&) = delete;

  /// Detects until the source ends, the duration is over, `output` interrupts, or an error occurs. Once only.
  /// @return  the summary, with the error, if any, as `failure`. @throws Error  if the recording cannot begin
  DetectionSummary run(const TickOutput& output);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::detect
