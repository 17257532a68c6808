#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tactile/core/time.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::results {

/// Episodes of one run that began without a touch, and the time without a touch.
///
/// `alarms` and its siblings count an episode once, however long it lasts. The forms after them count it again for each further
/// 500 ms, and have the time in alarm: a detector that stays on one class has few episodes, but is in alarm all the time.
struct FalseAlarms {
  std::uint64_t alarms = 0;           ///< false alarms proper
  std::uint64_t after_intervals = 0;  ///< begun within the guard after an interval
  std::uint64_t releases = 0;         ///< begun in a release that `label` found, or within the guard after it
  std::uint64_t unlabelled = 0;       ///< begun in unlabelled motion
  microseconds none_time{0};          ///< ticks in no interval or release, not within the guard after one, and in no unlabelled
                                      ///< interval
  microseconds after_intervals_time{0};
  microseconds releases_time{0};
  microseconds unlabelled_time{0};

  std::uint64_t outside_labels =
      0;  ///< alarms in no labelled interval: after intervals, in releases and in unlabelled motion too
  microseconds outside_labels_time{0};      ///< ticks in no labelled interval
  microseconds outside_labels_in_alarm{0};  ///< the part of them with a verdict of press or slip
  std::uint64_t outside_motion = 0;         ///< the same three without unlabelled true motion, which only simulated runs know
  microseconds outside_motion_time{0};
  microseconds outside_motion_in_alarm{0};
  microseconds none_in_alarm{0};     ///< the part of none time with a verdict of press or slip
  std::uint64_t wrong_class = 0;     ///< episodes of another class in a labelled interval
  microseconds wrong_class_time{0};  ///< ticks of labelled intervals with the verdict of another class
  microseconds labelled_time{0};     ///< ticks in labelled intervals that are not in doubt
  microseconds tick{0};              ///< of the verdicts; 0: not known, as in a table of several runs that was read from a file

  FalseAlarms& operator+=(const FalseAlarms& other);

  std::optional<double> per_min() const;                 ///< `alarms` of none time; nothing where there was none
  std::optional<double> outside_labels_per_min() const;  ///< nothing where there was no such time, as for the others
  std::optional<double> outside_labels_share() const;    ///< in alarm, in [0, 1]
  std::optional<double> outside_motion_per_min() const;
  std::optional<double> outside_motion_share() const;
  std::optional<double> none_in_alarm_share() const;
  std::optional<double> wrong_class_per_min() const;  ///< of labelled time
  std::optional<double> wrong_class_share() const;
};

/// Over all runs, objects drawn first, then runs; of each object, runs drawn. The intervals of rates are widened by few alarms.
struct FalseAlarmTable {
  Figure per_min{};                         ///< all alarms / all none time
  std::map<std::string, Figure> objects{};  ///< the same of each object
  Figure outside_labels_per_min{}, outside_motion_per_min{}, wrong_class_per_min{};
  Figure outside_labels_share{}, outside_motion_share{}, none_in_alarm_share{}, wrong_class_share{};  ///< of time
  FalseAlarms total{};
};

/// {"count", "none_min", "per_min", "objects", "after_intervals": {"count", "min"}, "releases": {"count", "min"}, "unlabelled":
/// {"count", "min"}, "outside_labels": {"count", "min", "per_min", "alarm_min", "share"}, "outside_motion": the same,
/// "none_in_alarm": {"min", "share"}, "wrong_class": {"count", "wrong_min", "min", "per_min", "share"}}
void to_json(nlohmann::json& json, const FalseAlarmTable& table);
void from_json(const JsonView& json, FalseAlarmTable& table);

/// Of one run: {"count", "after_intervals", "releases", "unlabelled", "none_min", "none_in_alarm_min", "after_intervals_min",
/// "releases_min", "unlabelled_min", "outside_labels", "outside_labels_min", "outside_labels_alarm_min", "outside_motion",
/// "outside_motion_min", "outside_motion_alarm_min", "wrong_class", "wrong_min", "labelled_min"}
void to_json(nlohmann::json& json, const FalseAlarms& of_run);
void from_json(const JsonView& json, FalseAlarms& of_run);  ///< files of older versions lack some of them: 0

/// Of one run, in sentences: episodes outside labels, the same without unlabelled motion, the share of none time in alarm, and
/// episodes of the wrong class. A rate or share of a time that is 0 is left out.
std::string words_of(const FalseAlarms& of_run);

double in_minutes(microseconds time);

}  // namespace tactile::results
