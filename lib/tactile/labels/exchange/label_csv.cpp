#include "tactile/labels/exchange/label_csv.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tactile/core/csv.hpp"
#include "tactile/core/csv_table.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::labels {
namespace {

constexpr std::string_view header =
    "run,id,class,start_s,end_s,confirmed,source,start_low_s,start_high_s,end_low_s,end_high_s,events_s,robot_s,video_s,imu_s,"
    "visible_s,probability,flags,origin,zero_s,drift_ppm";

bool is_confirmed(std::string_view cell, const std::string& where) {
  const std::string word = lower_case(trimmed(cell));
  constexpr std::array yes{"true", "yes", "ok", "x", "1"};
  constexpr std::array no{"", "false", "no", "0"};
  if (std::find(yes.begin(), yes.end(), word) != yes.end()) return true;
  if (std::find(no.begin(), no.end(), word) != no.end()) return false;
  throw Error(fmt::format("{}, column 'confirmed' holds {}; expected true or false", where, shown_text(cell)));
}

/// The header row of a file, which gives access to cells by name.
class Columns {
 public:
  Columns(const std::vector<std::string_view>& names, std::string file)
      : names_(names.begin(), names.end()), file_(std::move(file)) {
    for (std::string& name : names_) name = lower_case(trimmed(name));
    for (const std::string_view needed : {"class", "start_s", "end_s"}) {
      if (!index_of(needed))
        throw Error(fmt::format("{}: no column '{}'; expected a header row with class, start_s, end_s, as --export writes it",
                                file_, needed));
    }
  }

  std::size_t count() const { return names_.size(); }

  /// Empty if there is no such column.
  std::string_view cell(const std::vector<std::string_view>& cells, std::string_view name) const {
    const std::optional<std::size_t> index = index_of(name);
    return index ? trimmed(cells[*index]) : std::string_view();
  }

 private:
  std::optional<std::size_t> index_of(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    return found == names_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - names_.begin()));
  }

  std::vector<std::string> names_;
  std::string file_;
};

ReadSeconds seconds_at(std::string_view cell, std::string_view column, const std::string& where) {
  const std::optional<ReadSeconds> seconds = seconds_in(cell);
  if (!seconds)
    throw Error(fmt::format("{}, column '{}' holds {}; expected seconds, such as 1.250000", where, column, shown_text(cell)));
  return *seconds;
}

std::optional<TimeOrigin> origin_in(const Columns& columns, const std::vector<std::string_view>& cells,
                                    const std::string& where) {
  const std::string_view name = columns.cell(cells, "origin");
  if (name.empty()) return std::nullopt;
  const std::optional<TimeOrigin> origin = time_origin_named(name);
  if (!origin)
    throw Error(fmt::format("{}, column 'origin' holds {}; expected first-event, camera or video", where, shown_text(name)));
  return origin;
}

/// Nothing if the times count from the film's first frame, and the row does not say when that was.
std::optional<FileTimes> times_in(TimeOrigin origin, const Columns& columns, const std::vector<std::string_view>& cells,
                                  const std::string& where) {
  FileTimes times{.origin = origin};
  const std::string_view zero = columns.cell(cells, "zero_s");
  if (!zero.empty()) times.zero_us = seconds_at(zero, "zero_s", where).us;
  if (std::string drift(columns.cell(cells, "drift_ppm")); !drift.empty()) {
    std::replace(drift.begin(), drift.end(), ',', '.');
    const std::optional<double> ppm = number_in(drift);
    if (!ppm || !(std::abs(*ppm) < 1e5)) {
      throw Error(
          fmt::format("{}, column 'drift_ppm' holds {}; expected a number between -100000 and 100000", where, shown_text(drift)));
    }
    times.drift_ppm = *ppm;
  }
  return origin == TimeOrigin::video && zero.empty() ? std::nullopt : std::optional(times);
}

bool same(const FileTimes& a, const FileTimes& b) {
  return a.origin == b.origin && a.zero_us == b.zero_us && a.drift_ppm == b.drift_ppm;
}

/// Adds what a row says of the run's times. What it leaves out is as in the run's other rows.
void add_times(ImportedLabels& labels, const Columns& columns, const std::vector<std::string_view>& cells,
               const std::string& where) {
  const std::optional<TimeOrigin> origin = origin_in(columns, cells, where);
  if (!origin) return;
  const std::optional<FileTimes> times = times_in(*origin, columns, cells, where);
  if (*origin != labels.origin.value_or(*origin) || (times && labels.times && !same(*times, *labels.times)))
    throw Error(fmt::format("{}: the times of {} have another origin than in the rows before; expected one origin per run", where,
                            shown_text(labels.run.value_or(""))));
  labels.origin = origin;
  if (times) labels.times = times;
}

}  // namespace

std::string label_csv_text(std::span<const LabelsToExport> runs) {
  CsvTable table(header);
  for (const LabelsToExport& run : runs) {
    check_ids(run);
    const ClockRelation clock = run.times.to_camera(run.first_event);
    const auto seconds = [&](CameraTime t) { return seconds_text(clock.clock_us_from(t)); };
    const auto if_known = [&](const std::optional<CameraTime>& t) { return t ? seconds(*t) : std::string(); };
    const std::array<std::string, 3> axis{std::string(name_of(run.times.origin)), seconds_text(run.times.zero_us),
                                          fmt::format("{}", run.times.drift_ppm)};
    const std::string of_run = doubts_of(run.labels, std::nullopt);
    const std::array<std::string, 14> no_cells{};
    if (run.labels.intervals.empty()) table.add_row(run.run, "", "none", no_cells, of_run, axis);
    for (std::size_t i = 0; i < run.labels.intervals.size(); ++i) {
      const LabelledInterval& interval = run.labels.intervals[i];
      const std::string own = doubts_of(run.labels, i);
      const std::string flags = fmt::format("{}{}{}", own, own.empty() || of_run.empty() ? "" : "; ", of_run);
      const Evidence& evidence = interval.evidence;
      table.add_row(run.run, interval.id, name_of(interval.touch), seconds(interval.start.at), seconds(interval.end.at),
                    interval.confirmed ? "true" : "false", interval.source, seconds(interval.start.low),
                    seconds(interval.start.high), seconds(interval.end.low), seconds(interval.end.high),
                    if_known(evidence.events), if_known(evidence.robot), if_known(evidence.video), if_known(evidence.imu),
                    if_known(interval.visible), interval.probability ? fmt::format("{:.4g}", *interval.probability) : "", flags,
                    axis);
    }
  }
  return table.text();
}

std::vector<ImportedLabels> read_label_csv(const std::filesystem::path& file) {
  const std::string text = read_text(file, std::size_t{8} << 20);
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  CsvRows rows(rest, {.separator = separator_of(rest.substr(0, rest.find('\n'))), .has_quotes = true});
  const Columns columns(rows.cells(), file.string());
  std::vector<ImportedLabels> runs;
  std::map<std::string, std::size_t> run_index;
  std::size_t intervals = 0;
  while (rows.next()) {
    const std::vector<std::string_view>& cells = rows.cells();
    if (std::all_of(cells.begin(), cells.end(), [](std::string_view cell) { return cell.empty(); })) continue;
    const std::string where = fmt::format("{}, line {}", file.string(), rows.line());
    if (cells.size() != columns.count())
      throw Error(fmt::format("{} has {} values; expected {}, as its header", where, cells.size(), columns.count()));
    const std::string run(columns.cell(cells, "run"));
    const auto [found, is_new] = run_index.try_emplace(run, runs.size());
    if (is_new) {
      runs.push_back({.where = file.string(), .run = run.empty() ? std::nullopt : std::optional(run)});
      check_count(runs.size(), most_imported_runs, "runs", file);
    }
    ImportedLabels& labels = runs[found->second];
    add_times(labels, columns, cells, where);
    const std::string touch = lower_case(columns.cell(cells, "class"));
    if (touch == name_of(Touch::none)) continue;
    ImportedInterval interval{.id = std::string(columns.cell(cells, "id")), .where = where};
    if (touch != name_of(Touch::press) && touch != name_of(Touch::slip)) {
      throw Error(fmt::format("{}, column 'class' holds {}; expected press, slip, or none to remove it", where,
                              shown_text(columns.cell(cells, "class"))));
    }
    interval.touch = touch_named(touch);
    const ReadSeconds start = seconds_at(columns.cell(cells, "start_s"), "start_s", where);
    const ReadSeconds end = seconds_at(columns.cell(cells, "end_s"), "end_s", where);
    interval.start_us = start.us;
    interval.end_us = end.us;
    interval.start_rounding_us = start.rounding_us;
    interval.end_rounding_us = end.rounding_us;
    interval.confirmed = is_confirmed(columns.cell(cells, "confirmed"), where);
    labels.intervals.push_back(std::move(interval));
    check_count(++intervals, most_imported_intervals, "intervals", file);
  }
  if (runs.empty()) throw Error(file.string() + ": has no row; expected intervals, as --export writes them");
  return runs;
}

}  // namespace tactile::labels
