#include "tactile/splitting/cut_devices.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>

#include "tactile/core/error.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/film_part.hpp"

namespace tactile::splitting {
namespace fs = std::filesystem;
namespace {

/// A text file that is written line by line.
class Lines {
 public:
  explicit Lines(const fs::path& file) : name_(file.string()), out_(file, std::ios::binary) {}

  void write(std::string_view line, bool with_end = true) {
    out_ << line;
    if (with_end) out_ << '\n';
  }
  void close() {
    out_.close();
    if (!out_) throw Error(name_ + ": cannot be written; expected a disk with room");
  }

 private:
  std::string name_;
  std::ofstream out_;
};

std::size_t needed_column(const TableFile& table, std::string_view name) {
  if (const auto column = table.find(name)) return *column;
  throw Error(fmt::format("{}: no column '{}'; expected a header row that names it", table.file(), name));
}

std::string header_of(const std::vector<std::string>& columns, char separator) {
  std::string header;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i > 0) header += separator;
    header += columns[i].empty() ? fmt::format("unused_{}", i + 1) : columns[i];
  }
  return header;
}

/// The times of a film's frames, and the rows that they come from.
struct FilmRows {
  std::string header = "index,pts_us";
  std::vector<std::int64_t> placed_us;  ///< on the clock that places them
  std::vector<std::string> rest;        ///< of each row, after the index
};

FilmRows rows_of(const SplitSource& source, const DeviceClock& clock, const video::FilmFrames& frames) {
  FilmRows rows;
  if (!source.video_times) {
    rows.placed_us = frames.times_us;
    for (const std::int64_t us : frames.times_us) rows.rest.push_back(std::to_string(us));
    return rows;
  }
  TableFile table(*source.video_times,
                  {.name = "the times of a film's frames", .header = "index,pts_us", .ends_in_any_bytes = true});
  const std::size_t index = needed_column(table, "index");
  const std::size_t placed_by = needed_column(table, clock.is_by_host() ? "host_time_us" : "pts_us");
  rows.header = "index";
  for (std::size_t i = 0; i < table.names().size(); ++i) rows.header += i == index ? "" : "," + table.names()[i];
  while (table.next() && table.is_ended()) {
    if (table.is_blank()) continue;
    if (!table.is_whole()) table.refuse_row();
    rows.placed_us.push_back(table.whole_number_at(placed_by));
    std::string rest;
    for (std::size_t i = 0; i < table.cells().size(); ++i) {
      if (i == index) continue;
      if (!rest.empty()) rest += ',';
      rest += table.cells()[i];
    }
    rows.rest.push_back(std::move(rest));
  }
  return rows;
}

}  // namespace

std::vector<DeviceSpan> spans_of(const DeviceClock& clock, std::span<const CameraTime> cuts, microseconds margin) {
  const std::int64_t wider = saturating_add(margin.count(), clock.within.count());
  std::vector<DeviceSpan> spans(cuts.size() + 1);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const std::int64_t cut = clock.device_us_at(cuts[i]);
    spans[i].end = saturating_add(cut, wider);
    spans[i + 1].begin = saturating_subtract(cut, wider);
  }
  return spans;
}

std::vector<std::uint64_t> cut_robot_log(const SplitSource& source, const std::optional<DeviceClock>& clock,
                                         std::span<const DeviceSpan> spans, std::span<const fs::path> logs) {
  const std::vector<std::string> columns =
      source.robot_columns.empty() ? std::vector<std::string>() : robot::column_names(source.robot_columns);
  TableFile table(*source.robot, {.name = "a robot log",
                                  .header = "RTDE's names",
                                  .columns = columns,
                                  .columns_option = "--robot-columns",
                                  .ends_in_any_bytes = true});
  const bool is_by_host = clock && clock->is_by_host();
  const std::size_t time = needed_column(table, is_by_host ? "host_time_us" : "timestamp");
  const std::string header = columns.empty() ? std::string(table.row()) : header_of(columns, table.separator());
  std::deque<Lines> pieces;
  for (const fs::path& file : logs) pieces.emplace_back(file).write(header);
  std::vector<std::uint64_t> rows(spans.size());
  std::vector<bool> goes_to(spans.size(), !clock);  // of the row before
  while (table.next()) {
    const bool has_time = table.is_ended() && table.is_whole();
    if (has_time && clock) {
      const std::int64_t us = is_by_host ? table.whole_number_at(time) : std::llround(1e6 * table.number_at(time));
      for (std::size_t i = 0; i < spans.size(); ++i) goes_to[i] = spans[i].holds(us);
    }
    for (std::size_t i = 0; i < spans.size(); ++i) {
      if (!goes_to[i]) continue;
      pieces[i].write(table.row(), table.is_ended());
      rows[i] += has_time ? 1 : 0;
    }
  }
  for (Lines& piece : pieces) piece.close();
  return rows;
}

std::vector<std::uint64_t> cut_film(const SplitSource& source, const DeviceClock& clock, std::span<const DeviceSpan> spans,
                                    std::span<const FilmFiles> files) {
  const video::FilmFrames frames = video::film_frames(*source.video);
  const FilmRows rows = rows_of(source, clock, frames);
  if (rows.rest.size() < frames.times_us.size()) {
    throw Error(fmt::format("{}: has {} rows for the {} frames of {}; expected a row for each", source.video_times->string(),
                            rows.rest.size(), frames.times_us.size(), source.video->string()));
  }
  std::vector<std::uint64_t> counts(spans.size());
  for (std::size_t i = 0; i < spans.size(); ++i) {
    const auto begin = rows.placed_us.begin(), end = begin + static_cast<std::ptrdiff_t>(frames.times_us.size());
    const auto place_of = [&](std::optional<std::int64_t> us, std::size_t otherwise) {
      return us ? static_cast<std::size_t>(std::lower_bound(begin, end, *us) - begin) : otherwise;
    };
    const video::FilmPart wanted{place_of(spans[i].begin, 0), place_of(spans[i].end, frames.times_us.size())};
    if (wanted.begin >= wanted.end) continue;
    const video::FilmPart copied = video::copy_film_part(*source.video, frames, wanted, files[i].film);
    Lines times(files[i].times);
    times.write(rows.header);
    for (std::size_t frame = copied.begin; frame < copied.end; ++frame)
      times.write(fmt::format("{},{}", frame - copied.begin, rows.rest[frame]));
    times.close();
    counts[i] = copied.end - copied.begin;
  }
  return counts;
}

}  // namespace tactile::splitting
