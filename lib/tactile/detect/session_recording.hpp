#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/capture/run_recorder.hpp"
#include "tactile/detect/recorded_copy.hpp"

namespace tactile::detect {

/// The run to record.
struct SessionRecordingOptions {
  std::filesystem::path data = "data";  ///< folder of runs
  std::string object = "unnamed";
  std::string run = {};  ///< its number; empty: the next free one
};

/// Records the packets of a detection into a run folder.
class SessionRecording {
 public:
  /// Creates the run folder and begins.
  /// @param source    its packets are recorded; see `RecordedCopy`
  /// @param settings  kept in run.json
  /// @throws Error  if the folder or a file cannot be created
  SessionRecording(const SessionRecordingOptions& options, capture::CameraSource& source, bool waits,
                   const nlohmann::json& settings, std::function<void(const std::string&)> warn);

  /// @return  false once the camera's clock has started again: the recording ends there
  bool put(const capture::CameraPacket& packet);
  /// Waits until all packets are written. @param why  kept in run.json
  capture::RunSummary end(const std::string& why);

  const RunFolder& run() const { return run_; }

 private:
  RecordedCopy* copy_;  ///< belongs to the recorder
  std::unique_ptr<capture::RunRecorder> recorder_;
  RunFolder run_;
};

}  // namespace tactile::detect
