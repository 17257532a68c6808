#include "tactile/experiments/stress/stress_judgements.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/experiments/file_step.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string name_of(const StressJudgement& judgement) {
  const std::string at = judgement.series ? fmt::format("{}-{:g}", judgement.series->name, judgement.severity)
                         : judgement.runs == JudgedRuns::by_truth ? "truth"
                                                                  : "clean";
  return fmt::format("{}{}-{}", judgement.runs == JudgedRuns::quiet ? "quiet-" : "", judgement.training->bundle.name(), at);
}

std::string description_of(const StressPlan& plan, const StressJudgement& judgement) {
  const std::string model = plan.options.models.size() > 1 ? judgement.training->bundle.name() + ", " : "";
  const std::string how =
      judgement.series
          ? fmt::format("{} {:g} {}", judgement.series->name, judgement.severity, judgement.series->unit)
          : fmt::format("unchanged, judged by their {}", judgement.runs == JudgedRuns::by_truth ? "truth" : "labels");
  return fmt::format("{}{}: {}", model, judgement.runs == JudgedRuns::quiet ? "quiet recordings" : "runs", how);
}

fs::path file_of(const StressPlan& plan, const StressJudgement& judgement) {
  return plan.options.out / "judged" / (name_of(judgement) + ".csv");
}

/// @param quiet_files  names and hashes
json inputs_of(const StressPlan& plan, const StressJudgement& judgement, const json& quiet_files) {
  const StressTraining& training = *judgement.training;
  const model::Decision decision = model::usual_decision(training.description.settings.kind, {});
  json of = {{"weights", training.description.weights_sha256},
             {"thresholds", decision.thresholds ? json(text_of(*decision.thresholds)) : json()},
             {"temperature", experiments::hash_of_file(model::temperature_file(training.bundle))},
             {"engine", model::name_of(plan.options.engine)},
             {"by", static_cast<int>(judgement.runs)},
             {"series", judgement.series ? json_of(*judgement.series, judgement.severity) : json()}};
  if (judgement.runs == JudgedRuns::quiet) {
    of["files"] = quiet_files;
  } else {
    of["manifest"] = plan.dataset->manifest_hash();
    of["events"] = experiments::hashes_of_runs(training.folders());
    of["runs"] = training.names();
    of["truth"] = experiments::truth_hashes(training.folders());
  }
  return of;
}

void judge(const StressPlan& plan, const StressJudgement& judgement, const ProgressCallback& progress) {
  const auto& [training, series, severity, runs] = judgement;
  const JudgedBy by = runs == JudgedRuns::by_truth ? JudgedBy::truth : JudgedBy::labels;
  const std::vector<results::Cell> cells = runs == JudgedRuns::quiet
                                               ? judged_quiet(plan, *training, series, severity, progress)
                                               : judged_runs(plan, *training, series, severity, by, progress);
  write_whole(file_of(plan, judgement), results::cells_csv(cells));
}

}  // namespace

bool has_runs(const StressGroup& group) {
  return std::any_of(group.trainings.begin(), group.trainings.end(),
                     [](const StressTraining& training) { return !training.runs.empty(); });
}

std::vector<PlannedCurve> curves_of(const StressPlan& plan, const StressGroup& group) {
  std::vector<PlannedCurve> curves;
  for (const StressSeries& series : plan.options.series) {
    if (has_runs(group)) curves.push_back({&series, series.world.empty() ? JudgedRuns::by_labels : JudgedRuns::by_truth});
  }
  for (const StressSeries& series : plan.options.series) {
    if (!plan.options.quiet.empty() && series.world.empty()) curves.push_back({&series, JudgedRuns::quiet});
  }
  return curves;
}

std::vector<double> severities_of(const StressSeries& series) {
  std::vector<double> severities{0};
  severities.insert(severities.end(), series.severities.begin(), series.severities.end());
  return severities;
}

std::vector<StressJudgement> judgements_at(const StressGroup& group, const PlannedCurve& curve, double severity) {
  std::vector<StressJudgement> judgements;
  for (const StressTraining& training : group.trainings)
    judgements.push_back({&training, severity > 0 ? curve.series : nullptr, severity, curve.runs});
  return judgements;
}

std::vector<StressJudgement> unchanged_runs(const StressGroup& group) {
  return judgements_at(group, {.series = nullptr, .runs = JudgedRuns::by_labels}, 0);
}

std::vector<StressJudgement> judgements_of(const StressPlan& plan) {
  std::vector<StressJudgement> all;
  std::set<std::string> names;
  const auto add = [&](const std::vector<StressJudgement>& some) {
    for (const StressJudgement& judgement : some) {
      if (names.insert(name_of(judgement)).second) all.push_back(judgement);
    }
  };
  for (const StressGroup& group : plan.groups) {
    if (has_runs(group)) add(unchanged_runs(group));
    for (const PlannedCurve& curve : curves_of(plan, group)) {
      for (const double severity : severities_of(*curve.series)) add(judgements_at(group, curve, severity));
    }
  }
  return all;
}

std::vector<experiments::Step> steps_of(const StressPlan& plan) {
  json quiet_files = json::array();
  for (const fs::path& file : plan.options.quiet)
    quiet_files.push_back({file.filename().string(), experiments::hash_of_file(file)});
  std::vector<experiments::Step> steps;
  for (const StressJudgement& judgement : judgements_of(plan)) {
    steps.push_back(experiments::file_step(
        name_of(judgement), inputs_of(plan, judgement, quiet_files), file_of(plan, judgement),
        [&plan, judgement](const ProgressCallback& progress) { judge(plan, judgement, progress); },
        description_of(plan, judgement)));
    steps.back().kind = "judgement";
    if (plan.options.task) {
      steps.back().on_cluster = [&plan, name = name_of(judgement), &model = judgement.training->bundle.folder] {
        return plan.options.task(name, model);
      };
    }
  }
  return steps;
}

void do_step(const StressPlan& plan, const std::string& name, const ProgressCallback& progress) {
  const std::vector<StressJudgement> judgements = judgements_of(plan);
  const auto found = std::find_if(judgements.begin(), judgements.end(),
                                  [&](const StressJudgement& judgement) { return name_of(judgement) == name; });
  if (found == judgements.end()) throw Error(fmt::format("'{}': is no step of this stress; expected one of its steps", name));
  judge(plan, *found, progress);
}

std::vector<results::Cell> cells_of(const StressPlan& plan, const std::vector<StressJudgement>& judgements) {
  std::vector<results::Cell> all;
  for (std::size_t i = 0; i < judgements.size(); ++i) {
    for (results::Cell& cell : results::read_cells(file_of(plan, judgements[i]))) {
      cell.training = i;
      all.push_back(std::move(cell));
    }
  }
  return all;
}

}  // namespace tactile::stress
