#include "tactile/experiments/study/train_models.hpp"

#include <algorithm>

#include "tactile/evaluation/evaluation.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/study/sample_confusions.hpp"
#include "tactile/experiments/training_step.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::study {
namespace {

experiments::Step step_to_train(const StudyPlan& plan, const StudyModel& model) {
  const StudyOptions& options = plan.options;
  return experiments::training_step(plan.dataset, model.settings, model.bundle,
                                    {options.data, options.models, experiments::from_folder(options.models, options.out)});
}

experiments::Step step_to_judge(const StudyPlan& plan, const StudyModel& model) {
  const auto file = samples_file(plan, model);
  return experiments::file_step("judge-" + model.name(),
                                with_engine({{"manifest", plan.dataset.manifest_hash()},
                                             {"weights", model::read_description(model.bundle).weights_sha256},
                                             {"runs", names_of(plan.dataset, model.runs)}},
                                            plan.options.engine),
                                file, [&plan, model, file](const ProgressCallback& progress) {
                                  const unsigned threads = plan.options.threads;
                                  const model::Classifier classifier =
                                      model::open_classifier(model.bundle.folder, threads, plan.options.engine);
                                  const auto confusions = evaluation::sample_confusions(plan.dataset, classifier, model.runs,
                                                                                        {.threads = threads}, progress);
                                  const std::vector<std::string> names = names_of(plan.dataset, model.runs);
                                  std::vector<NamedConfusion> named;
                                  for (std::size_t i = 0; i < names.size(); ++i)
                                    named.push_back({names[i], confusions[i].object, confusions[i].confusion});
                                  write_confusions(file, named);
                                });
}

void train_and_judge(const StudyPlan& plan, const std::vector<StudyModel>& models, experiments::StepRunner& runner) {
  std::vector<experiments::Step> steps;
  for (const StudyModel& model : models) steps.push_back(step_to_train(plan, model));
  runner.run_side_by_side(steps);
  for (const StudyModel& model : models) runner.run(step_to_judge(plan, model));
}

microseconds nearest_to_default(const std::vector<microseconds>& histories) {
  return *std::min_element(histories.begin(), histories.end(), [](microseconds a, microseconds b) {
    return std::chrono::abs(a - default_history) < std::chrono::abs(b - default_history);
  });
}

/// Adds the models without held-out objects, of the history chosen, to `trained`.
/// @return  those to train, each once: a drawn split may hold out the same objects as the plan
std::vector<StudyModel> add_models_without_objects(const StudyPlan& plan, TrainedModels& trained) {
  for (unsigned training = 0; training < plan.options.seeds && !plan.held_out.empty(); ++training)
    trained.held_out.push_back(model_of(plan, trained.history, plan.seed_of(training), plan.held_out));
  std::vector<StudyModel> due = trained.held_out;
  for (const HeldOutSplit& split : plan.splits) {
    trained.splits.push_back(model_of(plan, trained.history, plan.seed_of(0), split.held_out));
    const auto has_its_name = [&](const StudyModel& model) { return model.name() == trained.splits.back().name(); };
    if (std::none_of(due.begin(), due.end(), has_its_name)) due.push_back(trained.splits.back());
  }
  return due;
}

HistoryComparison compare_histories(const StudyPlan& plan, const RunSet& set, const TrainedModels& trained) {
  HistoryComparison comparison;
  for (const auto& [history, models] : trained.by_history) {
    comparison.confusions[history] = confusions_of(plan, models, set.names);
    comparison.accuracies[history] = evaluation::accuracy_of(comparison.confusions[history]);
  }
  comparison.choice = choose_history(comparison.accuracies);
  return comparison;
}

}  // namespace

std::filesystem::path samples_file(const StudyPlan& plan, const StudyModel& model) {
  return plan.options.out / "samples" / (model.name() + ".json");
}

std::vector<results::RunConfusion> confusions_of(const StudyPlan& plan, const std::vector<StudyModel>& models,
                                                 const std::vector<std::string>& runs) {
  std::vector<std::vector<results::RunConfusion>> each;
  for (const StudyModel& model : models) each.push_back(confusions_of_runs(read_confusions(samples_file(plan, model)), runs));
  return sum_over_models(each);
}

TrainedModels train_models(const StudyPlan& plan, experiments::StepRunner& runner) {
  TrainedModels trained;
  std::vector<StudyModel> due;
  for (const microseconds history : plan.options.histories) {
    for (unsigned training = 0; training < plan.options.seeds; ++training) {
      due.push_back(model_of(plan, history, plan.seed_of(training)));
      trained.by_history[history].push_back(due.back());
    }
  }
  const bool chosen_on_runs = !plan.choice.runs.empty();
  if (!chosen_on_runs) {
    // The history is known already: all trainings run side by side.
    trained.history = nearest_to_default(plan.options.histories);
    const std::vector<StudyModel> without_objects = add_models_without_objects(plan, trained);
    due.insert(due.end(), without_objects.begin(), without_objects.end());
  }
  train_and_judge(plan, due, runner);
  for (const RunSet* set : plan.run_sets()) {
    if (!set->runs.empty()) trained.comparisons[set->name] = compare_histories(plan, *set, trained);
  }
  trained.paper_history = trained.comparisons.at("all_test").choice.history;
  if (chosen_on_runs) {
    trained.history = trained.comparisons.at("choice").choice.history;
    train_and_judge(plan, add_models_without_objects(plan, trained), runner);
  }
  return trained;
}

}  // namespace tactile::study
