#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "log_rows.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_health.hpp"

namespace tactile::cli {

struct ReportOptions {
  std::string stream;         ///< only this event stream, by id or source; empty: all
  std::int64_t gap_ms = 100;  ///< report gaps without data longer than this [ms], > 0
  bool check = false;         ///< compare checksums
  bool verbose = false;       ///< of several recordings, show each in full
  bool camera_time = false;   ///< show camera times instead of seconds since the first event
};

/// A recording, or a run with its recording.
struct RecordingPlace {
  std::string name;  ///< as the user wrote it
  std::filesystem::path file;
  std::optional<RunFolder> run;
};

/// What `info` shows of a recording.
struct RecordingReport {
  RecordingPlace place;
  events::RecordingHealth health;
  std::optional<RunInfo> run;
  RunFiles files;
  std::optional<LogRows> robot, video;
  bool has_film = false;  ///< `video` lacks where a film came without the times of its frames
};

/// @throws Error  if the recording cannot be read
RecordingReport examine(const RecordingPlace& place, const ReportOptions& options, unsigned threads,
                        const ProgressCallback& progress);

nlohmann::json json_of(const RecordingReport& report, const ReportOptions& options);
std::string text_of(const RecordingReport& report, const ReportOptions& options);

/// One line per recording: length, events, rate, files and health; then how many are healthy.
std::string summary_of(std::span<const RecordingReport> reports, const ReportOptions& options);

/// State of the data table: "used", "missing" or "unusable"; "none" if the format has none.
std::string table_state(const events::RecordingHealth& health);
/// The first event stream, which names the camera; null if there is none.
const events::StreamHealth* main_stream(const events::RecordingHealth& health);

}  // namespace tactile::cli
