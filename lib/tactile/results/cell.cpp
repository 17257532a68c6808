#include "tactile/results/cell.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <set>
#include <string_view>
#include <tuple>

#include "tactile/core/csv.hpp"
#include "tactile/core/csv_table.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/table_file.hpp"

namespace tactile::results {
namespace {

constexpr std::string_view cause_prefix = "alarms_", early_mark = "early>", missed_mark = ">", unknown_mark = "-";
constexpr std::array<std::pair<std::string_view, TickCount Cell::*>, 3> tick_counts{
    {{"first", &Cell::first}, {"before_last", &Cell::before_last}, {"last", &Cell::last}}};
constexpr std::string_view first_answer = "touch", confirmed_answer = "confirmed slip";

std::string word_of(const TouchOutcome& touch) {
  std::string ms = csv_number(touch.ms);
  switch (touch.outcome) {
    case DetectionOutcome::detected:
      return ms;
    case DetectionOutcome::missed:
      return std::string(missed_mark) + ms;
    case DetectionOutcome::early:
      return std::string(early_mark) + ms;
  }
  return {};
}

std::string words_of(const Cell& cell, Touch touch, bool from_gross) {
  std::string words;
  for (const TouchOutcome& one : cell.touches) {
    if (one.touch != touch) continue;
    words += words.empty() ? "" : " ";
    words += !from_gross ? word_of(one)
             : !one.gross_ms
                 ? std::string(unknown_mark)
                 : std::string(one.outcome == DetectionOutcome::detected ? "" : missed_mark) + csv_number(*one.gross_ms);
  }
  return words;
}

std::string sample_column(Touch truth, Touch predicted) { return fmt::format("{}_as_{}", name_of(truth), name_of(predicted)); }

/// The column of this name. @throws Error  if there is none
std::size_t column_of(const TableFile& table, std::string_view name) {
  const auto column = table.find(name);
  if (!column)
    throw Error(fmt::format("{}: no column {}; expected a table of cells, as 'tactile eval' writes", table.file(), name));
  return *column;
}

class CellReader {
 public:
  explicit CellReader(const std::filesystem::path& file) : table_(file, {.name = "a table of cells", .header = "their columns"}) {
    for (const std::string& name : table_.names()) {
      if (name.starts_with(cause_prefix)) causes_.emplace_back(name.substr(cause_prefix.size()), column_of(table_, name));
    }
  }

  bool next() {
    while (table_.next()) {
      if (!table_.is_blank()) return true;
    }
    return false;
  }

  Cell cell() const {
    if (!table_.is_whole()) table_.refuse_row();
    Cell cell{{text("object"), text("run"), count("training")}};
    cell.world = text("world");
    cell.setting = text("setting");
    cell.confirmed = text("answer") == confirmed_answer;
    if (!cell.confirmed && text("answer") != first_answer)
      table_.refuse(column_of(table_, "answer"), fmt::format("'{}' or '{}'", first_answer, confirmed_answer));
    if (!text("threshold").empty()) cell.threshold = number("threshold");
    cell.tick_ms = amount("tick_ms");
    if (cell.tick_ms <= 0) table_.refuse(column_of(table_, "tick_ms"), "a time above 0 ms");
    cell.by_truth = text("judged_by") == "truth";
    if (!cell.by_truth && text("judged_by") != "labels") table_.refuse(column_of(table_, "judged_by"), "truth or labels");
    cell.outside_s = amount("outside_s");
    cell.in_alarm_s = amount("in_alarm_s");
    cell.wrong_class = count("wrong_class");
    if (!text("false_slips").empty()) cell.false_slips = count("false_slips");
    for (const auto& [cause, column] : causes_) {
      const auto alarms = table_.bits_at(column);
      if (alarms > 0) cell.alarms[cause] = alarms;
    }
    if (cell.alarm_count() != count("alarms")) table_.refuse(column_of(table_, "alarms"), "the sum of the columns alarms_CAUSE");
    add_touches(cell, Touch::press, "press_ms", {});
    add_touches(cell, Touch::slip, "slip_ms", words("gross_slip_ms"));
    for (const auto& [part, counts] : tick_counts)
      cell.*counts = {count(fmt::format("{}_ticks", part)), count(fmt::format("{}_right", part))};
    for (const Touch truth : all_touches) {
      for (const Touch predicted : all_touches) cell.samples.at(truth, predicted) = count(sample_column(truth, predicted));
    }
    return cell;
  }

 private:
  std::string text(std::string_view column) const { return std::string(table_.cells()[column_of(table_, column)]); }
  double number(std::string_view column) const { return table_.number_at(column_of(table_, column)); }
  double amount(std::string_view column) const {
    const double value = number(column);
    if (!std::isfinite(value) || value < 0) table_.refuse(column_of(table_, column), "a finite number, 0 or more");
    return value;
  }
  std::uint64_t count(std::string_view column) const { return table_.bits_at(column_of(table_, column)); }
  std::vector<std::string_view> words(std::string_view column) const {
    const std::string_view all = table_.cells()[column_of(table_, column)];
    return all.empty() ? std::vector<std::string_view>() : split_cells(all, ' ');
  }

  double ms_of(std::string_view column, std::string_view word) const {
    const auto ms = number_in(word);
    if (!ms || !std::isfinite(*ms))
      table_.refuse(column_of(table_, column), "delays in ms with blanks between them, such as '4 >500 early>500 -'");
    return *ms;
  }

  void add_touches(Cell& cell, Touch touch, std::string_view column, const std::vector<std::string_view>& gross) const {
    std::size_t i = 0;
    const std::vector<std::string_view> all = words(column);
    if (touch == Touch::slip && gross.size() != all.size())
      table_.refuse(column_of(table_, "gross_slip_ms"), "as many words as slip_ms has");
    for (std::string_view word : all) {
      TouchOutcome one{.touch = touch, .outcome = DetectionOutcome::detected};
      for (const auto& [mark, outcome] :
           {std::pair(early_mark, DetectionOutcome::early), std::pair(missed_mark, DetectionOutcome::missed)}) {
        if (one.outcome != DetectionOutcome::detected || !word.starts_with(mark)) continue;
        one.outcome = outcome;
        word.remove_prefix(mark.size());
      }
      one.ms = ms_of(column, word);
      if (i < gross.size() && gross[i] != unknown_mark) {
        const bool is_detected = one.outcome == DetectionOutcome::detected;
        if (gross[i].starts_with(missed_mark) == is_detected)
          table_.refuse(column_of(table_, "gross_slip_ms"), "a '>' before the slips that slip_ms has as not detected");
        one.gross_ms = ms_of("gross_slip_ms", gross[i].substr(is_detected ? 0 : missed_mark.size()));
      }
      cell.touches.push_back(one);
      ++i;
    }
  }

  TableFile table_;
  std::vector<std::pair<std::string, std::size_t>> causes_;
};

/// A time from an onset to a tick, as the whole ticks that begin after the onset.
double in_ticks(double ms, double tick_ms) {
  constexpr double rounding = 1e-6;  // of times in whole microseconds
  return std::ceil(ms / tick_ms - rounding) * tick_ms;
}

auto members_of(const Cell& cell) {
  return std::tie(cell.object, cell.run, cell.training, cell.world, cell.setting, cell.confirmed, cell.threshold, cell.tick_ms,
                  cell.by_truth, cell.touches, cell.outside_s, cell.in_alarm_s, cell.alarms, cell.wrong_class, cell.false_slips,
                  cell.first, cell.before_last, cell.last, cell.samples);
}

}  // namespace

std::uint64_t Cell::alarm_count() const {
  std::uint64_t count = 0;
  for (const auto& [cause, alarms_of_cause] : alarms) count += alarms_of_cause;
  return count;
}

double Cell::delay_ms(const TouchOutcome& touch) const {
  return touch.outcome == DetectionOutcome::detected ? in_ticks(touch.ms, tick_ms) : touch.ms;
}

std::optional<double> Cell::gross_delay_ms(const TouchOutcome& touch) const {
  if (!touch.gross_ms || touch.outcome != DetectionOutcome::detected) return touch.gross_ms;
  return in_ticks(*touch.gross_ms, tick_ms);
}

bool operator==(const Cell& a, const Cell& b) { return members_of(a) == members_of(b); }

std::string words_of(const Cell& cell) {
  const auto counted = [](std::uint64_t count, std::string_view what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
  };
  std::string causes;
  for (const auto& [cause, alarms] : cell.alarms) causes += fmt::format("{}{} {}", causes.empty() ? "" : ", ", alarms, cause);
  std::string words =
      fmt::format("By the {}: {} in {:.1f} s outside of touches{}", cell.by_truth ? "truth" : "labels",
                  counted(cell.alarm_count(), "false alarm"), cell.outside_s, causes.empty() ? "" : " (" + causes + ")");
  if (cell.alarm_count() > 0 && cell.outside_s > 0)
    words += fmt::format("; in alarm for {:.1f} % of that time", 100 * cell.in_alarm_s / cell.outside_s);
  words += ". " + counted(cell.wrong_class, "episode") + " of the wrong class.";
  if (cell.false_slips && *cell.false_slips > 0) words += " Slip is reported in a lift without slip.";
  return words;
}

std::string cells_csv(std::span<const Cell> cells) {
  std::set<std::string> causes;
  for (const Cell& cell : cells) {
    for (const auto& [cause, alarms] : cell.alarms) causes.insert(cause);
  }
  std::string columns =
      "world,object,run,training,setting,answer,threshold,tick_ms,judged_by,outside_s,in_alarm_s,wrong_class,false_slips,"
      "alarms";
  for (const std::string& cause : causes) columns += "," + csv_cell(std::string(cause_prefix) + cause);
  columns += ",press_ms,slip_ms,gross_slip_ms";
  for (const auto& [part, counts] : tick_counts) columns += fmt::format(",{0}_ticks,{0}_right", part);
  for (const Touch truth : all_touches) {
    for (const Touch predicted : all_touches) columns += "," + sample_column(truth, predicted);
  }
  CsvTable table(columns);
  for (const Cell& cell : cells) {
    std::vector<std::string> by_cause;
    for (const std::string& cause : causes) {
      const auto found = cell.alarms.find(cause);
      by_cause.push_back(std::to_string(found == cell.alarms.end() ? 0 : found->second));
    }
    std::vector<std::string> counted;
    for (const auto& [part, counts] : tick_counts) {
      counted.push_back(std::to_string((cell.*counts).ticks));
      counted.push_back(std::to_string((cell.*counts).right));
    }
    for (const auto& row : cell.samples.counts) {
      for (const std::uint64_t count : row) counted.push_back(std::to_string(count));
    }
    table.add_row(cell.world, cell.object, cell.run, cell.training, cell.setting,
                  cell.confirmed ? confirmed_answer : first_answer, csv_number(cell.threshold), csv_number(cell.tick_ms),
                  cell.by_truth ? "truth" : "labels", csv_number(cell.outside_s), csv_number(cell.in_alarm_s), cell.wrong_class,
                  cell.false_slips, cell.alarm_count(), std::span<const std::string>(by_cause),
                  words_of(cell, Touch::press, false), words_of(cell, Touch::slip, false), words_of(cell, Touch::slip, true),
                  std::span<const std::string>(counted));
  }
  return table.text();
}

std::vector<Cell> read_cells(const std::filesystem::path& file) {
  CellReader reader(file);
  std::vector<Cell> cells;
  while (reader.next()) cells.push_back(reader.cell());
  return cells;
}

}  // namespace tactile::results
