#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/capture/run_recorder.hpp"
#include "tactile/detect/live_detector.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/robot/robot_inputs.hpp"

namespace tactile {

/// A maximal row of ticks of one beginning with one verdict other than none.
struct ToldEpisode {
  Touch touch = Touch::none;
  CameraTime first{}, last{};
};

struct ToldToRobot {
  RobotInputsState state;
  std::uint64_t raised = 0;      ///< how often a bit rose
  DurationHistogram from_event;  ///< from the arrival of the last event to the register's write, of those
};

/// What became of a detection.
struct DetectSummary {
  std::string model, source, engine, precision;
  bool simulated = false;
  HeatmapOptions rendering;
  Confirmation confirmation{};
  std::optional<std::uint64_t> gate;
  bool plays = false;
  std::chrono::microseconds elapsed{};
  double cpu_s = 0;
  std::string ended;
  LiveCounts counts;
  DeadlineMonitor deadlines{std::chrono::milliseconds(2)};
  microseconds longest_packet{0};
  SourceDrops drops;
  std::uint64_t reopened = 0;
  std::array<std::uint64_t, touch_count> verdicts{};  ///< ticks
  std::array<std::uint64_t, touch_count> episodes{};
  std::vector<ToldEpisode> first_episodes;
  std::optional<CameraTime> first_tick, last_tick;
  std::map<std::string, std::uint64_t> faults;  ///< how often each kind
  std::vector<DetectionFault> first_faults;
  std::vector<std::string> real_time;  ///< what was not permitted; empty where all was, or nothing was asked for
  bool asked_for_real_time = false;
  std::optional<std::string> may_sleep;  ///< why processors may sleep, where they should not; empty if they do not
  std::optional<ToldToRobot> robot;
  std::optional<std::array<std::uint64_t, 2>> udp;  ///< sent, failed
  std::optional<RunSummary> recorded;
  std::uint64_t ticks_left_out = 0;  ///< of --ticks and --plot, since they could not be written fast enough
};

inline constexpr std::size_t most_episodes_told = 10'000, most_faults_told = 1'000;

std::string text_of(const DetectSummary& summary);
nlohmann::json json_of(const DetectSummary& summary);

}  // namespace tactile
