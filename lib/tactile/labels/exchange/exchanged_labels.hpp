#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// The formats for other tools. Both hold many runs, and keep the ids of intervals, so that an edited file can be imported.
enum class ExchangeFormat : std::uint8_t { label_studio, csv };

std::string_view name_of(ExchangeFormat format);    ///< "label-studio", "csv"
std::string_view ending_of(ExchangeFormat format);  ///< ".json", ".csv"
std::optional<ExchangeFormat> exchange_format_named(std::string_view name);
std::optional<ExchangeFormat> exchange_format_by_ending(const std::filesystem::path& file);

/// The origin of the times in a file: a run's first event, none (camera time itself), or the film's first frame, in video time.
enum class TimeOrigin : std::uint8_t { first_event, camera, video };

std::string_view name_of(TimeOrigin origin);  ///< "first-event", "camera", "video"
std::optional<TimeOrigin> time_origin_named(std::string_view name);

/// A file's time axis, as the file declares it: time 0 is `zero_us` after the run's first event (before it, if negative), and the
/// axis drifts against the camera's clock. With the origin `camera` both are meaningless.
struct FileTimes {
  TimeOrigin origin = TimeOrigin::first_event;
  std::int64_t zero_us = 0;
  double drift_ppm = 0;

  /// From the file's microseconds to camera time and back.
  ClockRelation to_camera(CameraTime first_event) const;
};

/// The curves that Label Studio shows above the labels, with their time axis in the file's seconds; all of the same length.
struct LabelSignals {
  std::vector<double> time_s = {};
  std::vector<std::pair<std::string, std::vector<double>>> curves = {};  ///< by name
};

/// One run's labels for another tool.
struct LabelsToExport {
  std::string run;  ///< "fan/01"
  Labels labels;
  FileTimes times;
  CameraTime first_event{}, last_event{};
  LabelSignals signals = {};  ///< only for Label Studio
};

/// An interval in another tool's file.
struct ImportedInterval {
  std::string id = {};  ///< empty if the tool has none
  Touch touch = Touch::none;
  std::int64_t start_us = 0, end_us = 0;                    ///< on the file's axis
  std::int64_t start_rounding_us = 1, end_rounding_us = 1;  ///< resolution of the file, > 0
  bool confirmed = false;
  std::string where;  ///< for errors: "labels.csv, line 3"
};

/// One run's part of another tool's file.
struct ImportedLabels {
  std::string where;                      ///< the file
  std::optional<std::string> run = {};    ///< "fan/01", if the file names it
  std::optional<TimeOrigin> origin = {};  ///< if the file names it
  std::optional<FileTimes> times = {};    ///< if the file declares the whole axis: with the origin `video` also its zero
  bool looked_at = true;                  ///< false: no person has annotated this run yet, so it is not changed
  std::vector<ImportedInterval> intervals = {};
};

/// Limits that no real file reaches. They bound the cost of malicious files.
inline constexpr std::size_t most_imported_intervals = 100'000, most_imported_runs = 10'000;

/// @throws Error  that names the file, if `count` is more than `most`
void check_count(std::size_t count, std::size_t most, std::string_view of_what, const std::filesystem::path& file);

/// @throws Error  if an id does not survive in another tool: allowed are a letter, then at most 63 letters, digits, '-', '_' and
///                '.'
void check_ids(const LabelsToExport& labels);

/// The reasons of the unconfirmed flags, separated by "; ": those of one interval, or of the whole run.
std::string doubts_of(const Labels& labels, std::optional<std::size_t> interval_index);

/// Seconds with six decimals, exact for any microsecond: "-0.000250".
std::string seconds_text(std::int64_t us);

struct ReadSeconds {
  std::int64_t us = 0;
  std::int64_t rounding_us = 1;  ///< half a unit of the last decimal, 1 to 500
};

/// Digits, with or without a decimal point or comma; nothing if `text` is anything else, or exceeds int64 in microseconds.
std::optional<ReadSeconds> seconds_in(std::string_view text);

}  // namespace tactile::labels
