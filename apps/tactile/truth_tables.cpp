#include "truth_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/labels/truth_comparison.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

constexpr microseconds far_off{20'000};  ///< an unflagged error beyond this is named

/// A run, its comparison with the truth, and the sources that its labels have.
struct ComparedRun {
  const LabelledRun* labelled = nullptr;
  labels::TruthComparison comparison;
  bool has_stage_command = false, has_imu = false, shares_session = false;
  bool has_both = false;  ///< the truth has a press and a slip
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
  return files.is_listed && !(files.missing.empty() && files.changed.empty());
}

std::string session_of(const RunFolder& run) {
  try {
    return is_there(run.info()) ? read_run_info(run).session : std::string();
  } catch (const Error&) {
    return {};  // the comparison of the run gives the error
  }
}

/// @param errors  gets why a run could not be compared
std::vector<ComparedRun> compare(const std::vector<LabelledRun>& runs, std::vector<std::string>& errors) {
  std::map<std::string, std::size_t> sessions;
  for (const LabelledRun& labelled : runs) ++sessions[session_of(labelled.run)];
  std::vector<ComparedRun> compared;
  const auto compare_one = [&](const LabelledRun& labelled) {
    const Truth truth = read_truth(labelled.run.truth());
    ComparedRun run;
    run.labelled = &labelled;
    run.comparison = labels::compare_with_truth(labelled.labels, truth);
    run.has_stage_command = plan_says(truth.parameters, "stage_on_robot_output");
    run.has_imu = plan_says(truth.parameters, "has_imu");
    const std::string session = session_of(labelled.run);
    run.shares_session = !session.empty() && sessions[session] > 1;
    const auto has = [&](Touch touch) {
      return std::any_of(run.comparison.intervals.begin(), run.comparison.intervals.end(),
                         [&](const labels::IntervalComparison& interval) { return interval.touch == touch; });
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
  void add(const labels::Deviation& deviation, bool flagged) {
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
  const auto add = [&](const std::string& key, const std::optional<labels::Deviation>& deviation, bool is_flagged) {
    if (deviation && (!flagged || *flagged == is_flagged)) errors[key].add(*deviation, is_flagged);
  };
  for (const labels::IntervalComparison& interval : run.comparison.intervals) {
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

/// Errors that no flag names, one sentence each.
std::vector<std::string> silent_errors(const std::vector<ComparedRun>& runs) {
  std::vector<std::string> named;
  for (const ComparedRun& run : runs) {
    const std::string name = run.labelled->run.name();
    const auto at_s = [&](CameraTime t) { return in_s(between(run.labelled->zero, t)); };
    for (const labels::IntervalComparison& interval : run.comparison.intervals) {
      if (interval.flagged) continue;
      if (!interval.start) {
        named.push_back(
            fmt::format("{}: {} at {:.3f} s was not found", name, name_of(interval.touch), at_s(interval.true_start)));
      } else if (std::chrono::abs(interval.start->error) > far_off) {
        named.push_back(fmt::format("{}: {} onset is off by {:+.1f} ms", name, name_of(interval.touch),
                                    static_cast<double>(interval.start->error.count()) / 1000));
      }
    }
    for (const labels::SpuriousLabel& label : run.comparison.spurious) {
      if (!label.flagged)
        named.push_back(
            fmt::format("{}: {} at {:.3f} s is spurious", name, name_of(label.interval.touch), at_s(label.interval.start)));
    }
  }
  return named;
}

/// Counts over all runs.
struct Totals {
  std::size_t damaged = 0, damaged_flagged = 0, undamaged_flagged = 0;
  std::size_t plain = 0, plain_flagged = 0;  ///< undamaged, with press and slip
  std::size_t intervals = 0, covered = 0, missed = 0, spurious = 0, robot_clocks_missed = 0, video_clocks_missed = 0;

  explicit Totals(const std::vector<ComparedRun>& runs) {
    const auto count = [](bool holds) { return holds ? std::size_t{1} : std::size_t{0}; };
    for (const ComparedRun& run : runs) {
      const labels::TruthComparison& comparison = run.comparison;
      damaged += count(run.damaged);
      damaged_flagged += count(run.damaged && comparison.flagged);
      undamaged_flagged += count(!run.damaged && comparison.flagged);
      plain += count(!run.damaged && run.has_both);
      plain_flagged += count(!run.damaged && run.has_both && comparison.flagged);
      intervals += comparison.intervals.size();
      spurious += comparison.spurious.size();
      robot_clocks_missed += count(comparison.robot_clock_sought && !comparison.robot_clock);
      video_clocks_missed += count(comparison.video_clock_sought && !comparison.video_clock);
      for (const labels::IntervalComparison& interval : comparison.intervals) {
        covered += count(interval.start && interval.start->covered);
        missed += count(!interval.start);
      }
    }
  }
};

/// By group, then quantity.
using ErrorsByGroup = std::map<std::string, std::map<std::string, Errors>>;

ErrorsByGroup errors_by_group(const std::vector<ComparedRun>& runs, const std::vector<Group>& groups) {
  ErrorsByGroup errors;
  for (const Group& group : groups) {
    for (const ComparedRun& run : runs) {
      if (group.holds(run)) add_errors(run, group.flagged, errors[group.key]);
    }
  }
  return errors;
}

nlohmann::json groups_json(const std::vector<ComparedRun>& runs, const std::vector<Group>& groups, ErrorsByGroup& errors) {
  nlohmann::json json = nlohmann::json::object();
  for (const Group& group : groups) {
    json[group.key] = {{"errors_ms", json_of(errors[group.key])}};
    if (!group.flagged) json[group.key]["runs"] = std::count_if(runs.begin(), runs.end(), group.holds);
  }
  return json;
}

std::vector<std::vector<std::string>> error_rows(const std::vector<Group>& groups, ErrorsByGroup& errors_in) {
  std::vector<std::vector<std::string>> rows;
  for (const Quantity& quantity : quantities) {
    const std::size_t whole = errors_in["all"][quantity.key].n();
    if (whole == 0) continue;
    rows.push_back({quantity.name});
    for (const Group& group : groups) {
      const Errors& errors = errors_in[group.key][quantity.key];
      // A group that holds all runs, or none, adds nothing.
      if (errors.n() == 0 || (errors.n() == whole && std::string_view(group.key) != "all")) continue;
      rows.push_back(errors.cells(group.name, has_interval(quantity)));
    }
  }
  return rows;
}

std::string flagged_text(const Totals& totals, std::size_t runs) {
  std::string text = fmt::format("Flagged: {} of {} undamaged runs; {} of {} of them with press and slip",
                                 totals.undamaged_flagged, runs - totals.damaged, totals.plain_flagged, totals.plain);
  if (totals.damaged > 0) text += fmt::format("; {} of {} damaged runs", totals.damaged_flagged, totals.damaged);
  return wrapped(text + ".") + "\n";
}

std::string silent_text(const std::vector<std::string>& silent) {
  const auto limit_ms = far_off.count() / 1000;
  if (silent.empty())
    return wrapped(fmt::format("No unflagged onset is missed, spurious or off by more than {} ms.", limit_ms)) + "\n";
  std::string text =
      wrapped(fmt::format("Onsets without a flag that are missed, spurious or off by more than {} ms:", limit_ms)) + "\n";
  for (const std::string& sentence : silent) text += wrapped("  " + sentence, 4) + "\n";
  return text;
}

}  // namespace

TruthTables compare_all(const std::vector<LabelledRun>& labelled) {
  TruthTables tables;
  const std::vector<ComparedRun> runs = compare(labelled, tables.errors);
  if (runs.empty() && !tables.errors.empty()) return tables;
  if (runs.empty()) throw Error("--compare-truth: none of the runs has a truth.json; expected simulated runs");
  const Totals totals(runs);
  const std::vector<Group> groups = all_groups();
  ErrorsByGroup errors = errors_by_group(runs, groups);
  const std::vector<std::string> silent = silent_errors(runs);
  tables.json = {{"runs", runs.size()},
                 {"intervals", totals.intervals},
                 {"missed", totals.missed},
                 {"spurious", totals.spurious},
                 {"onsets_covered", totals.covered},
                 {"robot_clocks_missed", totals.robot_clocks_missed},
                 {"video_clocks_missed", totals.video_clocks_missed},
                 {"flagged",
                  {{"damaged", {{"runs", totals.damaged}, {"flagged", totals.damaged_flagged}}},
                   {"undamaged", {{"runs", runs.size() - totals.damaged}, {"flagged", totals.undamaged_flagged}}},
                   {"undamaged_with_press_and_slip", {{"runs", totals.plain}, {"flagged", totals.plain_flagged}}}}},
                 {"unflagged_errors", silent},
                 {"errors_ms", json_of(errors["all"])},
                 {"groups", groups_json(runs, groups, errors)}};
  tables.text =
      "\n" +
      wrapped(fmt::format("Against the truth of {} simulated {}: {} intervals, {} missed, {} spurious; {} of {} onsets inside "
                          "their 95 % interval; {} robot clocks and {} video clocks not found.",
                          runs.size(), runs.size() == 1 ? "run" : "runs", totals.intervals, totals.missed, totals.spurious,
                          totals.covered, totals.intervals, totals.robot_clocks_missed, totals.video_clocks_missed)) +
      "\n" +
      text_table({"absolute error [ms]", "n", "flagged", "median", "p95", "largest", "covered", "width"},
                 error_rows(groups, errors)) +
      wrapped(
          "Covered: truths inside the 95 % interval; width: the median of these intervals. A clock's offset is compared "
          "where the lift starts.") +
      "\n" + flagged_text(totals, runs.size()) + silent_text(silent);
  return tables;
}

}  // namespace tactile::cli
