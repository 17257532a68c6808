#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/detection.hpp"
#include "tactile/results/judged_run.hpp"
#include "tactile/results/members.hpp"

namespace tactile::results {

/// How one touch was detected.
struct TouchOutcome {
  Touch touch = Touch::none;
  DetectionOutcome outcome = DetectionOutcome::missed;
  double ms = 0;  ///< from the onset to the tick that detects it; of one that is not detected, how long it could be
  std::optional<double> gross_ms{};  ///< of a slip: the same from gross slip, where it is known; negative if ahead of it

  friend bool operator==(const TouchOutcome&, const TouchOutcome&) = default;
};

/// Ticks, and how many of them have the right verdict.
struct TickCount {
  std::uint64_t ticks = 0, right = 0;

  friend bool operator==(const TickCount&, const TickCount&) = default;
};

/// A whole run, judged at one setting of one training: what every figure of whole runs is made from.
struct Cell : JudgedRun {
  std::string setting{};                          ///< "stream", "th040"
  bool confirmed = false;                         ///< of confirmed slips alone, without presses; else of press and slip at once
  std::optional<double> threshold{};              ///< log-odds of a touch, or of a confirmed slip; nothing: as it was decided
  double tick_ms = 2;                             ///< > 0
  bool by_truth = false;                          ///< judged by truth.json; else by labels.json
  std::vector<TouchOutcome> touches{};            ///< not in doubt: presses, then slips, each by onset
  double outside_s = 0;                           ///< time outside of all touches, also of those in doubt
  double in_alarm_s = 0;                          ///< the part of it with a verdict of press or slip
  std::map<std::string, std::uint64_t> alarms{};  ///< false alarms by cause, each above 0
  std::uint64_t wrong_class = 0;                  ///< episodes that began in a touch of the other class
  std::optional<std::uint64_t> false_slips{};     ///< in a lift without slip; nothing where the run has none
  TickCount first{};                              ///< in the first 500 ms of touches
  TickCount before_last{}, last{};                ///< of touches longer than 200 ms: before their last 200 ms, and in them
  Confusion samples{};                            ///< of the balanced samples, by the labels

  std::uint64_t alarm_count() const;

  /// The delay of a detected touch, (k - k0 + 1) tick with k0 the first tick after its onset; of one that is not detected, how
  /// long it could be [ms].
  double delay_ms(const TouchOutcome& touch) const;
  std::optional<double> gross_delay_ms(const TouchOutcome& touch) const;  ///< from gross slip, in the same way

  friend bool operator==(const Cell&, const Cell&);
};

/// The counts of a run: {"by_truth", "outside_s", "in_alarm_s", "alarms": {CAUSE: COUNT}, "wrong_class", "false_slips"}
template <class Members>
void list_members(Members& members, Cell& cell) {
  members("by_truth", cell.by_truth);
  members("outside_s", cell.outside_s);
  members("in_alarm_s", cell.in_alarm_s);
  members("alarms", cell.alarms);
  members("wrong_class", cell.wrong_class);
  members("false_slips", cell.false_slips);
}

/// "By the truth: 3 false alarms in 4.2 s outside of touches (2 firm lift, 1 release); in alarm for 1.2 % of that time. 1 episode
/// of the wrong class."
std::string words_of(const Cell& cell);

/// A row each: world, object, run, training, setting, answer, threshold, tick_ms, judged_by, outside_s, in_alarm_s, wrong_class,
/// false_slips, alarms, a column alarms_CAUSE of every cause that occurs, press_ms, slip_ms, gross_slip_ms, first_ticks,
/// first_right, before_last_ticks, before_last_right, last_ticks, last_right, and nine columns press_as_slip of balanced samples:
/// their class, and that of the verdict. The three in ms have a word for each touch, with blanks between them: the time from its
/// onset to its detection, ">500" of a missed one, "early>500" of an early one, "-" where it is unknown. From gross slip, ">480"
/// of one that is not detected.
std::string cells_csv(std::span<const Cell> cells);

/// The cells of such a table. @throws Error  if the file is missing or has another form
std::vector<Cell> read_cells(const std::filesystem::path& file);

}  // namespace tactile::results
