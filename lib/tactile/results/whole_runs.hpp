#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/results/delay_table.hpp"
#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"

namespace tactile::results {

/// What a detector does on whole runs, at one threshold. Counts are sums over runs and trainings.
struct OperatingPoint {
  std::optional<double> threshold{};  ///< log-odds from which a touch is reported; nothing: the verdicts as they were decided
  Figure alarms_per_min{};            ///< false alarms, of the time outside of touches
  std::uint64_t alarms = 0;
  double outside_min = 0;                                      ///< that time [min]
  double in_alarm = std::numeric_limits<double>::quiet_NaN();  ///< the share of it with a verdict of press or slip, in [0, 1]
  CensoredQuantile median_ms{}, p90_ms{};                      ///< delay, over all touches
  CensoredQuantile press_median_ms{}, press_p90_ms{}, slip_median_ms{}, slip_p90_ms{};
  CensoredQuantile gross_median_ms{};  ///< over slips whose gross slip is known, from it; negative: ahead of it
  Figure within_50_ms{};               ///< share of touches that are detected within 50 ms, in [0, 1]
  Figure missed{};                     ///< share of touches that are not detected, missed or early, in [0, 1]
  std::uint64_t touches = 0, misses = 0, early = 0;
  Figure wrong_class{};  ///< episodes of the other class per touch
  std::uint64_t wrong_classes = 0;
  Figure false_slips{};                          ///< share of lifts without slip in which slip is reported, in [0, 1]
  std::uint64_t lifts = 0, lifts_with_slip = 0;  ///< lifts without slip, and those of them in which slip is reported
};

template <class Members>
void list_members(Members& members, OperatingPoint& point) {
  members("threshold", point.threshold);
  members("alarms_per_min", point.alarms_per_min);
  members("alarms", point.alarms);
  members("outside_min", point.outside_min);
  members("in_alarm", point.in_alarm);
  members("median_ms", point.median_ms);
  members("p90_ms", point.p90_ms);
  members("press_median_ms", point.press_median_ms);
  members("press_p90_ms", point.press_p90_ms);
  members("slip_median_ms", point.slip_median_ms);
  members("slip_p90_ms", point.slip_p90_ms);
  members("gross_median_ms", point.gross_median_ms);
  members("within_50_ms", point.within_50_ms);
  members("missed", point.missed);
  members("touches", point.touches);
  members("misses", point.misses);
  members("early", point.early);
  members("wrong_class", point.wrong_class);
  members("wrong_classes", point.wrong_classes);
  members("false_slips", point.false_slips);
  members("lifts", point.lifts);
  members("lifts_with_slip", point.lifts_with_slip);
}

/// The lowest threshold of the curve from which on there are at most so many false alarms a minute.
struct CalmPoint {
  double at_most_per_min = 0;
  std::optional<OperatingPoint> point{};  ///< nothing: no threshold that detects a touch has so few
};

template <class Members>
void list_members(Members& members, CalmPoint& calm) {
  members("at_most_per_min", calm.at_most_per_min);
  members("point", calm.point);
}

/// A published detector on the same whole runs, fitted to the same training runs.
struct Baseline {
  OperatingPoint decided{};       ///< by the thresholds that are usual
  std::vector<CalmPoint> calm{};  ///< as `WholeRuns::calm`
};

template <class Members>
void list_members(Members& members, Baseline& baseline) {
  members("decided", baseline.decided);
  members("calm", baseline.calm);
}

/// A run that is not judged.
struct LeftOutRun {
  std::string run;  ///< "fan/03"; empty where `why` names a folder
  std::string why;  ///< in words
};

template <class Members>
void list_members(Members& members, LeftOutRun& run) {
  members("run", run.run);
  members("why", run.why);
}

/// A detector on every run, whole: also those without a press or a slip, firm lifts, and flagged ones.
struct WholeRuns {
  std::vector<std::string> runs{};      ///< "fan/03", of several worlds "501/fan/03": that are judged, each once
  std::vector<std::string> by_truth{};  ///< those of them that are judged by their truth; the others by their labels
  std::vector<LeftOutRun> left_out{};
  std::string units = "objects";  ///< what intervals are over: "worlds", "objects", or "runs" of one or two objects
  OperatingPoint decided{};       ///< the verdicts as they were decided
  std::map<std::string, OperatingPoint> objects{};  ///< the same of each object
  std::map<std::string, std::uint64_t> causes{};    ///< false alarms of `decided` by cause
  std::vector<OperatingPoint> curve{};              ///< two thresholds, by ascending `on`; without intervals
  std::vector<CalmPoint> calm{};                    ///< at most 20, 6, 2 and 0.6 a minute
  std::optional<OperatingPoint> confirmed{};        ///< the slips that are confirmed, alone
  std::vector<OperatingPoint> confirmed_curve{};    ///< by ascending `confirmed`; without intervals
};

template <class Members>
void list_members(Members& members, WholeRuns& whole) {
  members("runs", whole.runs);
  members("by_truth", whole.by_truth);
  members("left_out", whole.left_out);
  members("units", whole.units);
  members("decided", whole.decided);
  members("objects", whole.objects);
  members("causes", whole.causes);
  members("curve", whole.curve);
  members("calm", whole.calm);
  members("confirmed", whole.confirmed);
  members("confirmed_curve", whole.confirmed_curve);
}

}  // namespace tactile::results
