#include "eval_run.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "camera_time.hpp"
#include "chosen_model.hpp"
#include "model_arguments.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/evaluation/scene_remarks.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/pictures/prediction_picture.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

/// A run, and its index in the dataset, if any.
struct ChosenRun {
  RunFolder folder;
  std::optional<std::uint32_t> in_dataset;
};

ChosenRun chosen_run(const std::string& given, const EvalArguments& args, const std::optional<windows::Dataset>& dataset) {
  if (dataset) {
    for (std::uint32_t i = 0; i < dataset->runs().size(); ++i) {
      const windows::DatasetRun& run = dataset->runs()[i];
      std::error_code unreadable;
      if (name_of(run) == given || fs::equivalent(dataset->run_folder(i), given, unreadable))
        return {{dataset->run_folder(i), run.object, run.run}, i};
    }
  }
  const fs::path data = fs::is_regular_file(args.data) ? fs::path(args.data).parent_path() : fs::path(args.data);
  const fs::path folder = fs::is_directory(given) ? fs::path(given) : data / given;
  if (!fs::is_directory(folder)) {
    throw Error(
        fmt::format("{}: no such run; expected object/run of {}, such as fan/02, or a run's folder", given, data.string()));
  }
  recording_in(folder);
  return {named_run_at(folder), {}};
}

ChosenModel model_for_runs(const EvalArguments& args, const std::optional<windows::Dataset>& dataset) {
  if (!args.model.empty()) return {bundle_named(args), {}};
  const std::string hash = dataset ? dataset->manifest_hash() : std::string();
  auto chosen = model_without_name(args.models, dataset ? &hash : nullptr);
  if (!chosen) chosen = model_without_name(args.models);
  if (!chosen) throw Error(fmt::format("{}: no model; expected one, run '{}' first", args.models, train_command(args, {})));
  return *std::move(chosen);
}

/// The outcome of an interval; "in doubt" if its labels are.
std::string words_of(const TouchInterval& interval, const std::vector<results::Detection>& detections) {
  for (const results::Detection& detection : detections) {
    if (detection.interval.start == interval.start && detection.interval.touch == interval.touch) return words_of(detection);
  }
  return "in doubt";
}

pictures::PredictionPicture picture_of(const evaluation::RunPrediction& prediction, const model::Classifier& classifier,
                                       const model::Decision& decision, bool learned_from) {
  pictures::PredictionPicture picture;
  picture.title = fmt::format("{}{}, predicted by {}{}", prediction.run, prediction.simulated ? " (simulated)" : "",
                              classifier.bundle().filename().string(), learned_from ? ", which learned from this run" : "");
  picture.first_event = prediction.first_event;
  const double history_ms = in_ms(classifier.rendering().history);
  for (std::size_t k = 0; k < prediction.verdicts.size(); ++k) {
    const model::Probabilities& p = prediction.full.probabilities[k];
    picture.ticks.push_back({prediction.full.ticks.at(static_cast<std::int64_t>(k)),
                             static_cast<double>(prediction.full.events[k]) / history_ms,
                             static_cast<double>(p[static_cast<std::size_t>(Touch::press)]),
                             static_cast<double>(p[static_cast<std::size_t>(Touch::slip)]), prediction.verdicts[k]});
  }
  picture.has_labels = !prediction.truth.labels.empty();
  for (const windows::SampledInterval& label : prediction.truth.labels)
    picture.labels.push_back({label.interval, words_of(label.interval, prediction.detections)});
  picture.has_truth = prediction.truth.has_truth;
  for (const results::Detection& detection : prediction.true_detections)
    picture.truth.push_back({detection.interval, words_of(detection)});
  picture.unlabelled = prediction.truth.unlabelled;
  std::string settings = fmt::format("History t_h {} ms, a tick every {} ms", history_ms, in_ms(classifier.rendering().tick));
  if (decision.thresholds) {
    settings += "; decided by the thresholds " + text_of(*decision.thresholds);
  } else if (decision.confirmation.of > 1) {
    settings +=
        fmt::format("; predicted in at least {} of the last {} ticks", decision.confirmation.needed, decision.confirmation.of);
  }
  picture.remarks.push_back(settings + ".");
  if (prediction.truth.is_known()) picture.remarks.push_back(results::words_of(prediction.judged));
  return picture;
}

nlohmann::json json_of(const evaluation::RunPrediction& prediction, const model::ModelBundle& bundle, bool learned_from,
                       const fs::path& stem) {
  nlohmann::json json{{"run", prediction.run},
                      {"model", bundle.name()},
                      {"simulated", prediction.simulated},
                      {"learned_from", learned_from},
                      {"ticks", prediction.verdicts.size()},
                      {"close_ticks", prediction.full.close},
                      {"csv", stem.string() + ".csv"},
                      {"json", stem.string() + ".json"},
                      {"png", stem.string() + ".png"},
                      {"svg", stem.string() + ".svg"},
                      {"intervals", nlohmann::json::array()}};
  for (const results::Detection& detection : prediction.detections) json["intervals"].push_back(detection);
  json["false_alarms"] = prediction.truth.is_known() ? nlohmann::json(prediction.judged.alarm_count()) : nlohmann::json();
  return json;
}

fs::path stem_of(const EvalArguments& args, const model::ModelBundle& bundle, const RunFolder& run) {
  return (args.out.empty() ? bundle.results() / "runs" : fs::path(args.out)) / (run.object + "-" + run.run);
}

evaluation::PredictionOptions prediction_options(const EvalArguments& args, unsigned threads,
                                                 const std::optional<windows::Dataset>& dataset, model::ModelKind kind) {
  evaluation::PredictionOptions options{.decision = decision_of(args.decision, kind), .threads = threads};
  if (dataset) options.include_flagged = member<bool>(dataset->settings(), "include_flagged", dataset->file().string());
  return options;
}

std::map<CameraTime, Touch> samples_of(const windows::Dataset& dataset, std::uint32_t run) {
  std::map<CameraTime, Touch> samples;
  for (const windows::Sample& sample : dataset.samples()) {
    if (sample.run_index == run) samples[sample.t] = sample.touch;
  }
  return samples;
}

/// The row of a run in the table.
std::vector<std::string> row_of(const evaluation::RunPrediction& prediction, bool learned_from) {
  const auto count = [&](std::uint64_t alarms) { return prediction.truth.is_known() ? std::to_string(alarms) : "-"; };
  return {prediction.run, std::to_string(prediction.verdicts.size()), count(prediction.judged.alarm_count()),
          count(prediction.judged.wrong_class), learned_from ? "learned from" : ""};
}

/// The rows of a run's intervals in their table.
std::vector<std::vector<std::string>> interval_rows(const evaluation::RunPrediction& prediction, bool camera_time) {
  std::vector<std::vector<std::string>> rows;
  const CameraTime zero = zero_of_times(camera_time, prediction.first_event.value_or(CameraTime{}));
  for (const results::Detection& detection : prediction.detections) {
    rows.push_back({prediction.run, std::string(name_of(detection.interval.touch)),
                    fmt::format("{:.4f}", in_s(between(zero, detection.interval.start))), words_of(detection)});
  }
  return rows;
}

/// Predicts runs at every tick with one model, and writes the files of each.
struct RunsOfModel {
  const EvalArguments& args;
  const std::optional<windows::Dataset>& dataset;
  const model::ModelBundle& bundle;
  const model::Classifier& classifier;
  const evaluation::PredictionOptions& options;
  nlohmann::json json = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows = {}, intervals = {};

  /// The run's index in the dataset, if the model was trained on this dataset.
  std::optional<std::uint32_t> index_of(const ChosenRun& run) const {
    const bool is_known = dataset && classifier.model().manifest_hash == dataset->manifest_hash();
    return is_known ? run.in_dataset : std::nullopt;
  }
  void show(const ChosenRun& run, const std::function<void(std::size_t)>& progress);
};

void RunsOfModel::show(const ChosenRun& run, const std::function<void(std::size_t)>& progress) {
  const std::optional<std::uint32_t> index = index_of(run);
  // `check_unchanged` has compared the hash of a run in the dataset with its file.
  const bool learned_from = index ? tactile::model::learned_from(classifier.model(), dataset->runs()[*index])
                                  : tactile::model::learned_from(classifier.model(), run.folder.events());
  const evaluation::RunPrediction prediction = evaluation::predict_run(run.folder, classifier, options, progress);
  if (prediction.verdicts.empty()) {
    throw Error(fmt::format("{}: shorter than the history of {} ms; expected at least one full tick", run.folder.name(),
                            in_ms(classifier.rendering().history)));
  }
  const evaluation::WatchedRun watched{run.folder.name(), run.folder.events()};
  const std::string remark = evaluation::scene_remark(classifier.model(), {&watched, 1}, 1);
  if (!remark.empty()) spdlog::warn("{}", remark);
  const fs::path stem = stem_of(args, bundle, run.folder);
  evaluation::write_prediction(stem.string() + ".csv", prediction,
                               index ? samples_of(*dataset, *index) : std::map<CameraTime, Touch>());
  write_json(stem.string() + ".json", evaluation::outcome_json(prediction));
  const pictures::PredictionPicture picture = picture_of(prediction, classifier, options.decision, learned_from);
  for (const char* extension : {".png", ".svg"}) pictures::draw_prediction(picture, stem.string() + extension);
  json.push_back(json_of(prediction, bundle, learned_from, stem));
  json.back()["warnings"] = remark.empty() ? nlohmann::json::array() : nlohmann::json{remark};
  rows.push_back(row_of(prediction, learned_from));
  for (std::vector<std::string>& row : interval_rows(prediction, args.camera_time)) intervals.push_back(std::move(row));
  spdlog::info("{}: {}", run.folder.name(), stem.string() + ".csv, .png, .svg");
}

}  // namespace

void show_runs(const EvalArguments& args, const CommonArguments& common) {
  std::optional<windows::Dataset> dataset;
  if (fs::exists(dataset_file(args.data))) dataset.emplace(dataset_file(args.data));
  std::vector<std::string> errors;  // of runs that cannot be shown; the others are shown
  const auto attempt = [&errors](const auto& step) {
    try {
      step();
    } catch (const std::exception& e) {
      errors.push_back(sentence_of(e));
    }
  };
  std::vector<ChosenRun> chosen;
  for (const std::string& given : args.runs) attempt([&] { chosen.push_back(chosen_run(given, args, dataset)); });
  if (chosen.empty()) return end_with(errors);
  const ChosenModel by = model_for_runs(args, dataset);
  const model::ModelBundle& bundle = by.bundle;
  const model::Classifier classifier = model::open_classifier(bundle.folder, common.threads, args.engine);
  log_choice("every tick, predicted by", by);
  const evaluation::PredictionOptions options = prediction_options(args, common.threads, dataset, classifier.kind());
  RunsOfModel shown{.args = args, .dataset = dataset, .bundle = bundle, .classifier = classifier, .options = options};

  std::vector<ChosenRun> runs;
  std::uint64_t total = 0, done = 0;
  for (const ChosenRun& run : chosen) {
    attempt([&] {
      if (const auto index = shown.index_of(run)) windows::check_unchanged(*dataset, *index);
      total += evaluation::expected_ticks(run.folder.events(), classifier.rendering());
      runs.push_back(run);
    });
  }
  const ProgressCallback progress = progress_line(common);
  for (const ChosenRun& run : runs) {
    attempt([&] {
      shown.show(run, [&](std::size_t ticks) {
        done += ticks;
        report_progress(progress, done, total, "every tick of " + run.folder.name());
      });
    });
  }
  if (shown.rows.empty()) return end_with(errors);
  const fs::path folder = stem_of(args, bundle, runs.front().folder).parent_path();
  write_settings(common, folder / "settings.json", {{"model", bundle.folder.string()}});
  print_result(common,
               {{"model", bundle.folder.string()},
                {"confirm", text_of(options.decision.confirmation)},
                {"engine", name_of(classifier.engine())},
                {"runs", shown.json}},
               fmt::format("Every tick, predicted by {}\n\n", bundle.name()) +
                   text_table({"run", "ticks", "false alarms", "of wrong class", ""}, shown.rows) +
                   (shown.intervals.empty() ? "" : "\n" + text_table({"run", "label", "onset [s]", "delay"}, shown.intervals)) +
                   "\nWritten to " + folder.string() + ": a CSV, JSON, PNG and SVG each\n");
  end_with(errors);
}

}  // namespace tactile::cli
