#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/labels/labels.hpp"

namespace tactile {

/// What other tools read and write. All four keep the intervals' ids, so that an edited file finds its way back.
enum class ExchangeFormat : std::uint8_t { audacity, elan, label_studio, csv };

std::string_view name_of(ExchangeFormat format);    ///< "audacity", "elan", "label-studio", "csv"
std::string_view ending_of(ExchangeFormat format);  ///< ".txt", ".eaf", ".json", ".csv"
bool holds_many_runs(ExchangeFormat format);        ///< in one file: Label Studio and CSV do
std::optional<ExchangeFormat> exchange_format_named(std::string_view name);
std::optional<ExchangeFormat> exchange_format_by_ending(const std::filesystem::path& file);

/// What times in a file count from: a run's first event, nothing (camera time itself), or the film's first frame, in the film's
/// own time.
enum class TimeOrigin : std::uint8_t { first_event, camera, video };

std::string_view name_of(TimeOrigin origin);  ///< "first-event", "camera", "video"
std::optional<TimeOrigin> time_origin_named(std::string_view name);

/// A file's time axis, as the file itself says it: time 0 lies `zero_us` after the run's first event (before it, if negative),
/// and drifts against the camera's clock as a film may. Of the origin `camera` both mean nothing.
struct FileTimes {
  TimeOrigin origin = TimeOrigin::first_event;
  std::int64_t zero_us = 0;
  double drift_ppm = 0;

  /// From the file's microseconds to camera time and back.
  ClockRelation to_camera(CameraTime first_event) const;
};

/// What Label Studio draws above the labels: a time axis in the file's seconds, and curves on it, each as long.
struct LabelSignals {
  std::vector<double> time_s = {};
  std::vector<std::pair<std::string, std::vector<double>>> curves = {};  ///< by name
};

/// One run's labels on their way to another tool.
struct LabelsToExport {
  std::string run;  ///< "fan/01"
  Labels labels;
  FileTimes times;
  CameraTime first_event{}, last_event{};
  std::filesystem::path film = {};                  ///< empty if the run has none
  std::optional<std::int64_t> film_begins_us = {};  ///< its first frame after the file's time 0; nothing without a video clock
  std::int64_t written_s = 0;                       ///< when the labels were, in Unix time
  LabelSignals signals = {};                        ///< empty but for Label Studio
};

/// An interval as it stands in another tool's file.
struct ImportedInterval {
  std::string id = {};  ///< empty where the tool has none
  Touch touch = Touch::none;
  std::int64_t start_us = 0, end_us = 0;                    ///< on the file's axis
  std::int64_t start_rounding_us = 1, end_rounding_us = 1;  ///< as near as the file can tell, > 0
  bool confirmed = false;
  std::string where;  ///< for errors: "labels.txt, line 3"
};

/// One run's part of another tool's file.
struct ImportedLabels {
  std::string where;                    ///< the file
  std::optional<std::string> run = {};  ///< "fan/01", if the file says
  std::optional<FileTimes> times = {};  ///< if the file says
  bool looked_at = true;                ///< false: nobody has answered for this run yet, so nothing follows from it
  std::vector<ImportedInterval> intervals = {};
};

/// No file holds so many of either: what hostile bytes cost stays bounded.
inline constexpr std::size_t most_imported_intervals = 100'000, most_imported_runs = 10'000;

/// @throws Error  that names the file, if `count` is more than `most`
void check_count(std::size_t count, std::size_t most, std::string_view of_what, const std::filesystem::path& file);

/// @throws Error  if an id would be lost in another tool: expected a letter, then at most 63 letters, digits, '-', '_' and '.',
/// and no class's name
void check_ids(const LabelsToExport& labels);

/// The flags that stand, in words, "; " between: those of one interval, or of the whole run.
std::string doubts_of(const Labels& labels, std::optional<std::size_t> interval_index);

/// Seconds with six decimals, exact for any microsecond: "-0.000250".
std::string seconds_text(std::int64_t us);

struct ReadSeconds {
  std::int64_t us = 0;
  std::int64_t rounding_us = 1;  ///< half a unit of the last decimal, 1 to 500
};

/// Digits with a decimal point or comma or neither; nothing if `text` is anything else, or beyond int64 in microseconds.
std::optional<ReadSeconds> seconds_in(std::string_view text);

/// "press-1 press 95% ±1.0 ms ok": an id or none, a class, whatever else, and "ok" at the end once confirmed. Fills in id, class
/// and mark. @throws Error  that names `where` if no class is there
void read_words(std::string_view text, const std::string& where, ImportedInterval& interval);

/// For errors: what stands there, at most 40 characters, none that could upset a terminal.
std::string shown_text(std::string_view text);

}  // namespace tactile
