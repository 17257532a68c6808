#include "tactile/experiments/study/train_models.hpp"

#include <algorithm>
#include <optional>

#include "tactile/evaluation/evaluation.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/study/sample_confusions.hpp"
#include "tactile/experiments/training_step.hpp"

namespace tactile::study {
namespace {

experiments::Step step_to_train(const StudyPlan& plan, const StudyModel& model) {
  const StudyOptions& options = plan.options;
  return experiments::training_step(plan.dataset, model.settings, model.bundle,
                                    {options.data, options.models, experiments::from_folder(options.models, options.out)});
}

experiments::Step step_to_judge(const StudyPlan& plan, const StudyModel& model, const std::string& training) {
  const auto file = samples_file(plan, model);
  const std::vector<std::string> runs = names_of(plan.dataset, model.runs);
  return {.name = "judge-" + model.name(),
          .command = "",
          .inputs = with_engine({{"manifest", plan.dataset.manifest_hash()}, {"runs", runs}}, plan.options.engine),
          .after = training,
          .later_inputs =
              [bundle = model.bundle] {
                return nlohmann::json{{"weights", model::read_description(bundle).weights_sha256}};
              },
          .outputs = [file] { return experiments::hash_of_file(file); },
          .arguments =
              [&plan, model, file, runs](const experiments::StepStart& start) {
                std::vector<std::string> words{"judge",     plan.dataset.file().string(),
                                               "--model",   model.bundle.folder.string(),
                                               "--out",     file.string(),
                                               "--engine",  std::string(name_of(plan.options.engine)),
                                               "--threads", std::to_string(start.threads),
                                               "--runs"};
                words.insert(words.end(), runs.begin(), runs.end());
                return words;
              },
          .kind = "judgement"};
}

void train_and_judge(const StudyPlan& plan, const std::vector<StudyModel>& models, experiments::StepRunner& runner) {
  std::vector<experiments::Step> steps;
  steps.reserve(2 * models.size());
  for (const StudyModel& model : models) steps.push_back(step_to_train(plan, model));
  for (std::size_t i = 0; i < models.size(); ++i) steps.push_back(step_to_judge(plan, models[i], steps[i].name));
  runner.run_side_by_side(steps);
}

/// The history where no run is left to choose one on: that of another training was chosen on runs that this one reports on.
microseconds without_choice(const StudyPlan& plan) {
  const std::vector<microseconds>& histories = plan.options.histories;
  return *std::min_element(histories.begin(), histories.end(), [](microseconds a, microseconds b) {
    return std::chrono::abs(a - default_history) < std::chrono::abs(b - default_history);
  });
}

HistoryComparison compare_histories(const StudyPlan& plan, const NamedRunSet& set, const TrainedModels& trained) {
  HistoryComparison comparison;
  for (const auto& [history, models] : trained.by_history) {
    std::vector<results::RunConfusion>& all = comparison.confusions[history];
    for (const StudyModel& model : models) {
      const auto of_model = confusions_of(plan, model, (plan.trainings[model.training].*set.runs).names);
      all.insert(all.end(), of_model.begin(), of_model.end());
    }
    comparison.accuracies[history] = evaluation::accuracy_of(all);
  }
  comparison.choice = choose_history(comparison.accuracies);
  return comparison;
}

/// The history that one training chooses on its own runs, without those of some objects; nothing without runs of others.
std::optional<microseconds> chosen_by(std::size_t training, const HistoryComparison& on_choice,
                                      const std::vector<std::string>& held_out = {}) {
  AccuracyByHistory accuracies;
  for (const auto& [history, confusions] : on_choice.confusions) {
    std::vector<results::RunConfusion> own;
    std::copy_if(confusions.begin(), confusions.end(), std::back_inserter(own), [&](const results::RunConfusion& run) {
      return run.training == training && std::find(held_out.begin(), held_out.end(), run.object) == held_out.end();
    });
    if (own.empty()) return std::nullopt;
    accuracies[history] = evaluation::accuracy_of(own, {.draws = 1});
  }
  return choose_history(accuracies).history;
}

/// Adds the models without held-out objects to `trained`.
/// @param on_choice  null if no history is chosen
/// @return  those to train, each once: a drawn split may hold out the same objects as the plan
std::vector<StudyModel> add_models_without_objects(const StudyPlan& plan, const HistoryComparison* on_choice,
                                                   TrainedModels& trained) {
  const auto model_without = [&](std::size_t training, const std::vector<std::string>& held_out) {
    const auto chosen = on_choice != nullptr ? chosen_by(training, *on_choice, held_out) : std::nullopt;
    return model_of(plan, chosen.value_or(without_choice(plan)), training, held_out);
  };
  std::vector<StudyModel> due;
  const auto add = [&](const StudyModel& model) {
    const auto has_its_name = [&](const StudyModel& other) { return other.name() == model.name(); };
    if (std::none_of(due.begin(), due.end(), has_its_name)) due.push_back(model);
  };
  for (const std::vector<std::string>& held_out : plan.held_out) {
    auto& models = trained.held_out.emplace_back();
    for (std::size_t training = 0; training < plan.trainings.size(); ++training) {
      models.push_back(model_without(training, held_out));
      add(models.back());
    }
  }
  for (std::size_t i = 0; i < plan.splits.size(); ++i) {
    trained.splits.push_back(model_without(i % plan.trainings.size(), plan.splits[i].held_out));
    add(trained.splits.back());
  }
  return due;
}

}  // namespace

std::filesystem::path samples_file(const StudyPlan& plan, const StudyModel& model) {
  return plan.options.out / "samples" / (model.name() + ".json");
}

std::vector<results::RunConfusion> confusions_of(const StudyPlan& plan, const StudyModel& model,
                                                 const std::vector<std::string>& runs) {
  return confusions_of_runs(read_confusions(samples_file(plan, model)), runs, model.training);
}

TrainedModels train_models(const StudyPlan& plan, experiments::StepRunner& runner) {
  TrainedModels trained;
  std::vector<StudyModel> due;
  for (const microseconds history : plan.options.histories) {
    for (std::size_t training = 0; training < plan.trainings.size(); ++training) {
      due.push_back(model_of(plan, history, training));
      trained.by_history[history].push_back(due.back());
    }
  }
  if (!plan.has_choice()) {
    // The history is known already: all trainings run side by side.
    trained.history = without_choice(plan);
    trained.chosen.assign(plan.trainings.size(), trained.history);
    const std::vector<StudyModel> without_objects = add_models_without_objects(plan, nullptr, trained);
    due.insert(due.end(), without_objects.begin(), without_objects.end());
  }
  train_and_judge(plan, due, runner);
  for (const NamedRunSet& set : run_sets) {
    if (!(plan.trainings.front().*set.runs).runs.empty()) trained.comparisons[set.name] = compare_histories(plan, set, trained);
  }
  trained.paper_history = trained.comparisons.at("all_test").choice.history;
  if (plan.has_choice()) {
    const HistoryComparison& on_choice = trained.comparisons.at("choice");
    trained.history = on_choice.choice.history;
    for (std::size_t training = 0; training < plan.trainings.size(); ++training)
      trained.chosen.push_back(chosen_by(training, on_choice).value_or(without_choice(plan)));
    train_and_judge(plan, add_models_without_objects(plan, &on_choice, trained), runner);
  }
  return trained;
}

}  // namespace tactile::study
