#include "truth_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/labels/clock_fit.hpp"
#include "tactile/labels/truth_comparison.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

constexpr microseconds far_off{20'000};     ///< an unflagged error beyond this is named
constexpr microseconds clock_goal{10'000};  ///< a clock with a symmetric anchor should be off by no more
constexpr std::array symmetric_anchors{AnchorKind::imu, AnchorKind::sync_tap, AnchorKind::ring_down};

/// A run beside its truth, and what its labels could be taken from.
struct ComparedRun {
  const LabelledRun* labelled = nullptr;
  TruthComparison comparison;
  bool has_stage_command = false, has_imu = false, shares_session = false;
  bool has_both = false;  ///< truly a press and a slip
  bool damaged = false;   ///< unfinished, or a file is missing or of another size than run.json says
};

struct Quantity {
  const char* key;
  const char* name;
};
constexpr std::array<Quantity, 8> quantities{{{"press_onset", "press onset"},
                                              {"press_onset_to_first_event", "press onset, first event"},
                                              {"press_end", "press end"},
                                              {"slip_onset", "slip onset"},
                                              {"slip_onset_to_first_event", "slip onset, first event"},
                                              {"slip_end", "slip end"},
                                              {"robot_clock", "robot clock's offset"},
                                              {"video_clock", "video clock's offset"}}};

bool plan_says(const nlohmann::json& parameters, const char* key) {
  const auto plan = parameters.find("plan");
  if (plan == parameters.end() || !plan->is_object()) return false;
  const auto value = plan->find(key);
  return value != plan->end() && value->is_boolean() && value->get<bool>();
}

bool is_damaged(const RunFolder& run) {
  if (!is_there(run.info())) return true;
  const RunInfo info = read_run_info(run);
  if (!info.complete) return true;
  const RunFiles files = check_files(run, info, FileComparison::size);
  return files.told && !(files.missing.empty() && files.changed.empty());
}

std::string session_of(const RunFolder& run) {
  try {
    return is_there(run.info()) ? read_run_info(run).session : std::string();
  } catch (const Error&) {
    return {};  // comparing the run names it
  }
}

/// @param errors  takes why a run could not be compared
std::vector<ComparedRun> compare(const std::vector<LabelledRun>& runs, std::vector<std::string>& errors) {
  std::map<std::string, std::size_t> sessions;
  for (const LabelledRun& labelled : runs) ++sessions[session_of(labelled.run)];
  std::vector<ComparedRun> compared;
  const auto compare_one = [&](const LabelledRun& labelled) {
    const Truth truth = read_truth(labelled.run.truth());
    ComparedRun run;
    run.labelled = &labelled;
    run.comparison = compare_with_truth(labelled.labels, truth);
    run.has_stage_command = plan_says(truth.parameters, "stage_on_robot_output");
    run.has_imu = plan_says(truth.parameters, "has_imu");
    const std::string session = session_of(labelled.run);
    run.shares_session = !session.empty() && sessions[session] > 1;
    const auto has = [&](Touch touch) {
      return std::any_of(run.comparison.intervals.begin(), run.comparison.intervals.end(),
                         [&](const IntervalComparison& interval) { return interval.touch == touch; });
    };
    run.has_both = has(Touch::press) && has(Touch::slip);
    run.damaged = is_damaged(labelled.run);
    compared.push_back(std::move(run));
  };
  for (const LabelledRun& labelled : runs) {
    if (!is_there(labelled.run.truth())) continue;
    try {
      compare_one(labelled);
    } catch (const std::exception& e) {
      errors.push_back(sentence_of(e, labelled.run.name()));
    }
  }
  return compared;
}

/// Errors of one quantity over some runs.
class Errors {
 public:
  void add(const Deviation& deviation, bool flagged) {
    errors_ms_.push_back(std::abs(static_cast<double>(deviation.error.count())) / 1000);
    widths_ms_.push_back(static_cast<double>(deviation.width.count()) / 1000);
    covered_ += deviation.covered ? 1 : 0;
    flagged_ += flagged ? 1 : 0;
  }
  std::size_t n() const { return errors_ms_.size(); }

  nlohmann::json json(bool with_interval) const {
    nlohmann::json object = {{"n", n()},
                             {"flagged", flagged_},
                             {"median", nearest_rank_quantile(errors_ms_, 0.5)},
                             {"p95", nearest_rank_quantile(errors_ms_, 0.95)},
                             {"max", nearest_rank_quantile(errors_ms_, 1)}};
    if (with_interval) {
      object["covered"] = covered_;
      object["median_width"] = nearest_rank_quantile(widths_ms_, 0.5);
    }
    return object;
  }

  std::vector<std::string> cells(const std::string& name, bool with_interval) const {
    return {"  " + name,
            std::to_string(n()),
            std::to_string(flagged_),
            fmt::format("{:.2f}", nearest_rank_quantile(errors_ms_, 0.5)),
            fmt::format("{:.2f}", nearest_rank_quantile(errors_ms_, 0.95)),
            fmt::format("{:.2f}", nearest_rank_quantile(errors_ms_, 1)),
            with_interval ? fmt::format("{:.0f} %", 100 * static_cast<double>(covered_) / static_cast<double>(n())) : "",
            with_interval ? fmt::format("{:.2f}", nearest_rank_quantile(widths_ms_, 0.5)) : ""};
  }

 private:
  std::vector<double> errors_ms_, widths_ms_;
  std::size_t covered_ = 0, flagged_ = 0;
};

/// The 95 % interval is that of the onset by its definition, not of the first event.
bool has_interval(const Quantity& quantity) {
  return std::string_view(quantity.key).find("first_event") == std::string_view::npos;
}

void add_errors(const ComparedRun& run, const std::optional<bool>& flagged, std::map<std::string, Errors>& errors) {
  const auto add = [&](const std::string& key, const std::optional<Deviation>& deviation, bool is_flagged) {
    if (deviation && (!flagged || *flagged == is_flagged)) errors[key].add(*deviation, is_flagged);
  };
  for (const IntervalComparison& interval : run.comparison.intervals) {
    const std::string touch(name_of(interval.touch));
    add(touch + "_onset", interval.start, interval.flagged);
    add(touch + "_onset_to_first_event", interval.first_event, interval.flagged);
    add(touch + "_end", interval.end, interval.flagged);
  }
  add("robot_clock", run.comparison.robot_clock, run.comparison.clocks_flagged);
  add("video_clock", run.comparison.video_clock, run.comparison.clocks_flagged);
}

/// Of every quantity that was compared at all.
nlohmann::json json_of(const std::map<std::string, Errors>& errors) {
  nlohmann::json object = nlohmann::json::object();
  for (const Quantity& quantity : quantities) {
    if (const auto found = errors.find(quantity.key); found != errors.end() && found->second.n() > 0)
      object[quantity.key] = found->second.json(has_interval(quantity));
  }
  return object;
}

struct Group {
  const char* key;
  const char* name;
  std::function<bool(const ComparedRun&)> holds;
  std::optional<bool> flagged = {};  ///< only what is flagged, or only what is not
};

std::vector<Group> all_groups() {
  const auto any = [](const ComparedRun&) { return true; };
  return {{"all", "all", any},
          {"unflagged", "unflagged", any, false},
          {"flagged", "flagged", any, true},
          {"stage_command", "stage command", [](const ComparedRun& r) { return r.has_stage_command; }},
          {"no_stage_command", "no stage command", [](const ComparedRun& r) { return !r.has_stage_command; }},
          {"imu", "IMU", [](const ComparedRun& r) { return r.has_imu; }},
          {"no_imu", "no IMU", [](const ComparedRun& r) { return !r.has_imu; }},
          {"shared_session", "shared session", [](const ComparedRun& r) { return r.shares_session; }},
          {"own_clocks", "clocks of its own", [](const ComparedRun& r) { return !r.shares_session; }}};
}

/// Whether an anchor that lies alike on either side of its moment places the robot's clock: no lag of skin or stage enters it.
bool has_symmetric_anchor(const ComparedRun& run) {
  const std::vector<FittedClock>& clocks = run.labelled->labels.robot_clocks;
  return std::any_of(clocks.begin(), clocks.end(), [](const FittedClock& clock) {
    return std::any_of(symmetric_anchors.begin(), symmetric_anchors.end(),
                       [&](AnchorKind kind) { return clock.method.find(name_of(kind)) != std::string::npos; });
  });
}

/// The error of the robot's clock by what placed it.
struct ClocksByAnchor {
  Errors errors;
  std::size_t within = 0;  ///< `clock_goal`
};

std::array<ClocksByAnchor, 2> clocks_by_anchor(const std::vector<ComparedRun>& runs) {
  std::array<ClocksByAnchor, 2> groups;
  for (const ComparedRun& run : runs) {
    if (!run.comparison.robot_clock) continue;
    ClocksByAnchor& group = groups[has_symmetric_anchor(run) ? 0 : 1];
    group.errors.add(*run.comparison.robot_clock, run.comparison.clocks_flagged);
    group.within += std::chrono::abs(run.comparison.robot_clock->error) <= clock_goal ? 1 : 0;
  }
  return groups;
}

constexpr std::array<const char*, 2> anchor_groups{"symmetric", "others"};

nlohmann::json json_of(const std::array<ClocksByAnchor, 2>& groups) {
  nlohmann::json object = nlohmann::json::object();
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].errors.n() == 0) continue;
    object[anchor_groups[i]] = groups[i].errors.json(true);
    object[anchor_groups[i]]["within_10_ms"] = groups[i].within;
  }
  return object;
}

std::string text_of(const std::array<ClocksByAnchor, 2>& groups) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].errors.n() == 0) continue;
    std::vector<std::string> cells = groups[i].errors.cells(i == 0 ? "symmetric" : "others", true);
    cells.push_back(std::to_string(groups[i].within));
    rows.push_back(std::move(cells));
  }
  if (rows.empty()) return {};
  return "\n" +
         text_table({"robot clock [ms]", "n", "flagged", "median", "p95", "largest", "covered", "width", "≤ 10 ms"}, rows) +
         wrapped(
             "Symmetric anchors: an inertial sensor, sync taps or the arm's ring-down, which lie alike on either side of their "
             "moment. "
             "Others follow from when something was touched or dragged, and say a wider interval.") +
         "\n";
}

/// What is wrong without a flag that says so, one sentence each.
std::vector<std::string> silent_errors(const std::vector<ComparedRun>& runs) {
  std::vector<std::string> named;
  for (const ComparedRun& run : runs) {
    const std::string name = run.labelled->run.name();
    const auto at_s = [&](CameraTime t) { return 1e-6 * static_cast<double>(between(run.labelled->first_event, t).count()); };
    for (const IntervalComparison& interval : run.comparison.intervals) {
      if (interval.flagged) continue;
      if (!interval.start) {
        named.push_back(
            fmt::format("{}: {} at {:.3f} s was not found", name, name_of(interval.touch), at_s(interval.true_start)));
      } else if (std::chrono::abs(interval.start->error) > far_off) {
        named.push_back(fmt::format("{}: {} onset is off by {:+.1f} ms", name, name_of(interval.touch),
                                    static_cast<double>(interval.start->error.count()) / 1000));
      }
    }
    for (const SpuriousLabel& label : run.comparison.spurious) {
      if (!label.flagged)
        named.push_back(
            fmt::format("{}: {} at {:.3f} s is spurious", name, name_of(label.interval.touch), at_s(label.interval.start)));
    }
  }
  return named;
}

std::string of_count(std::size_t part, std::size_t whole, const std::string& what) {
  return fmt::format("{} of {} {}", part, whole, what);
}

}  // namespace

TruthTables compare_all(const std::vector<LabelledRun>& labelled) {
  std::vector<std::string> unread;
  const std::vector<ComparedRun> runs = compare(labelled, unread);
  if (runs.empty() && !unread.empty()) return {.json = {}, .text = {}, .errors = unread};
  if (runs.empty()) throw Error("--compare-truth: none of the runs has a truth.json; expected simulated runs");
  const auto count = [&](const std::function<bool(const ComparedRun&)>& holds) {
    return static_cast<std::size_t>(std::count_if(runs.begin(), runs.end(), holds));
  };
  const std::size_t damaged = count([](const ComparedRun& r) { return r.damaged; });
  const std::size_t damaged_flagged = count([](const ComparedRun& r) { return r.damaged && r.comparison.flagged; });
  const std::size_t undamaged_flagged = count([](const ComparedRun& r) { return !r.damaged && r.comparison.flagged; });
  const std::size_t plain = count([](const ComparedRun& r) { return !r.damaged && r.has_both; });
  const std::size_t plain_flagged = count([](const ComparedRun& r) { return !r.damaged && r.has_both && r.comparison.flagged; });
  std::size_t intervals = 0, covered = 0, missed = 0, spurious = 0, robot_clocks_missed = 0, video_clocks_missed = 0;
  for (const ComparedRun& run : runs) {
    const TruthComparison& comparison = run.comparison;
    intervals += comparison.intervals.size();
    spurious += comparison.spurious.size();
    robot_clocks_missed += comparison.robot_clock_sought && !comparison.robot_clock ? 1 : 0;
    video_clocks_missed += comparison.video_clock_sought && !comparison.video_clock ? 1 : 0;
    for (const IntervalComparison& interval : comparison.intervals) {
      covered += interval.start && interval.start->covered ? 1 : 0;
      missed += interval.start ? 0 : 1;
    }
  }

  nlohmann::json groups = nlohmann::json::object();
  std::map<std::string, std::vector<std::vector<std::string>>> rows_of;
  const std::vector<Group> all = all_groups();
  std::map<std::string, std::map<std::string, Errors>> errors_in;
  for (const Group& group : all) {
    for (const ComparedRun& run : runs) {
      if (group.holds(run)) add_errors(run, group.flagged, errors_in[group.key]);
    }
    groups[group.key] = {{"errors_ms", json_of(errors_in[group.key])}};
    if (!group.flagged) groups[group.key]["runs"] = count(group.holds);
  }
  std::vector<std::vector<std::string>> rows;
  for (const Quantity& quantity : quantities) {
    const std::size_t whole = errors_in["all"][quantity.key].n();
    if (whole == 0) continue;
    rows.push_back({quantity.name});
    for (const Group& group : all) {
      const Errors& errors = errors_in[group.key][quantity.key];
      // A group that holds all, or none, says nothing of its own.
      if (errors.n() == 0 || (errors.n() == whole && std::string_view(group.key) != "all")) continue;
      rows.push_back(errors.cells(group.name, has_interval(quantity)));
    }
  }

  const std::vector<std::string> silent = silent_errors(runs);
  const std::array<ClocksByAnchor, 2> by_anchor = clocks_by_anchor(runs);
  TruthTables tables;
  tables.errors = std::move(unread);
  tables.json = {{"runs", runs.size()},
                 {"intervals", intervals},
                 {"missed", missed},
                 {"spurious", spurious},
                 {"onsets_covered", covered},
                 {"robot_clocks_missed", robot_clocks_missed},
                 {"video_clocks_missed", video_clocks_missed},
                 {"flagged",
                  {{"damaged", {{"runs", damaged}, {"flagged", damaged_flagged}}},
                   {"undamaged", {{"runs", runs.size() - damaged}, {"flagged", undamaged_flagged}}},
                   {"undamaged_with_press_and_slip", {{"runs", plain}, {"flagged", plain_flagged}}}}},
                 {"unflagged_errors", silent},
                 {"errors_ms", json_of(errors_in["all"])},
                 {"robot_clock_by_anchor", json_of(by_anchor)},
                 {"groups", groups}};
  std::string text =
      "\n" +
      wrapped(fmt::format("Against the truth of {} simulated {}: {} intervals, {} missed, {} spurious; {} of {} onsets inside "
                          "their 95 % interval; {} robot clocks and {} video clocks not found.",
                          runs.size(), runs.size() == 1 ? "run" : "runs", intervals, missed, spurious, covered, intervals,
                          robot_clocks_missed, video_clocks_missed)) +
      "\n";
  text += text_table({"absolute error [ms]", "n", "flagged", "median", "p95", "largest", "covered", "width"}, rows);
  text += wrapped(
              "Covered: truths inside the 95 % interval; width: the median of these intervals. A clock's offset is compared "
              "where the "
              "lift starts.") +
          "\n";
  text += text_of(by_anchor);
  text += wrapped(fmt::format("Flagged: {}; {}{}.", of_count(undamaged_flagged, runs.size() - damaged, "undamaged runs"),
                              of_count(plain_flagged, plain, "of them that hold press and slip"),
                              damaged == 0 ? "" : "; " + of_count(damaged_flagged, damaged, "damaged runs"))) +
          "\n";
  if (silent.empty())
    text +=
        wrapped(fmt::format("No unflagged onset is missed, spurious or off by more than {} ms.", far_off.count() / 1000)) + "\n";
  else
    text += wrapped(fmt::format("Onsets not flagged, yet missed, spurious or off by more than {} ms:", far_off.count() / 1000)) +
            "\n";
  for (const std::string& sentence : silent) text += wrapped("  " + sentence, 4) + "\n";
  tables.text = std::move(text);
  return tables;
}

}  // namespace tactile
