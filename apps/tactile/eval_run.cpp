#include "eval_run.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "model_arguments.hpp"
#include "openmp_threads.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/report/prediction_picture.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

/// The run that is meant, and its place in the dataset if it has one.
struct ChosenRun {
  RunFolder folder;
  std::optional<std::uint32_t> in_dataset;
};

ChosenRun chosen_run(const std::string& given, const EvalArguments& args, const std::optional<Dataset>& dataset) {
  if (dataset) {
    for (std::uint32_t i = 0; i < dataset->runs().size(); ++i) {
      const DatasetRun& run = dataset->runs()[i];
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

ModelBundle model_for_runs(const EvalArguments& args, const std::optional<Dataset>& dataset) {
  if (!args.model.empty()) return bundle_named(args);
  std::optional<ModelBundle> found;
  if (dataset) found = newest_of(args, *dataset, SplitKind::single_run);
  if (!found) found = newest_bundle(args.models, [](const ModelDescription&) { return true; });
  if (!found) throw Error(fmt::format("{}: no model; expected one, run '{}' first", args.models, train_command(args, {})));
  return *found;
}

/// How an interval was met; "in doubt" where its labels are.
std::string words_of(const TouchInterval& interval, const RunPrediction& prediction) {
  for (const Detection& detection : prediction.detections) {
    if (detection.interval.start == interval.start && detection.interval.touch == interval.touch) return words_of(detection);
  }
  return "in doubt";
}

PredictionPicture picture_of(const RunPrediction& prediction, const Classifier& classifier, const Confirmation& confirmation,
                             bool learned_from) {
  PredictionPicture picture;
  picture.title = fmt::format("{}{} as {} sees it{}", prediction.run, prediction.simulated ? " (simulated)" : "",
                              classifier.bundle().filename().string(), learned_from ? ", which learned from this run" : "");
  const double history_ms = static_cast<double>(classifier.rendering().history.count()) / 1000;
  for (std::size_t k = 0; k < prediction.verdicts.size(); ++k) {
    const Probabilities& p = prediction.full.probabilities[k];
    picture.ticks.push_back({prediction.full.ticks.at(static_cast<std::int64_t>(k)),
                             static_cast<double>(prediction.full.events[k]) / history_ms,
                             static_cast<double>(p[static_cast<std::size_t>(Touch::press)]),
                             static_cast<double>(p[static_cast<std::size_t>(Touch::slip)]), prediction.verdicts[k]});
  }
  picture.has_labels = !prediction.truth.labels.empty();
  for (const SampledInterval& label : prediction.truth.labels)
    picture.labels.push_back({label.interval, words_of(label.interval, prediction)});
  picture.has_truth = prediction.truth.has_truth;
  picture.truth = prediction.truth.true_ones;
  picture.unlabelled = prediction.truth.unlabelled;
  std::string settings = fmt::format("History t_h {} ms, a tick every {} ms", history_ms,
                                     static_cast<double>(classifier.rendering().tick.count()) / 1000);
  if (confirmation.of > 1)
    settings += fmt::format("; said in at least {} of the last {} ticks", confirmation.needed, confirmation.of);
  picture.remarks.push_back(settings + ".");
  if (picture.has_labels) {
    const FalseAlarms& alarms = prediction.false_alarms;
    picture.remarks.push_back(fmt::format(
        "Over each labelled interval: the detection delay. False alarms: {}; begun just after an interval: {}, in motion that "
        "nobody labels: {}.",
        alarms.alarms, alarms.after_intervals, alarms.unlabelled));
  }
  return picture;
}

nlohmann::json json_of(const RunPrediction& prediction, const ModelBundle& bundle, bool learned_from, const fs::path& stem) {
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
  for (const Detection& detection : prediction.detections) {
    const bool detected = detection.outcome == DetectionOutcome::detected;
    json["intervals"].push_back(
        {{"class", name_of(detection.interval.touch)},
         {"start_us", us_of(detection.interval.start)},
         {"end_us", us_of(detection.interval.end)},
         {"outcome", detected                                        ? "detected"
                     : detection.outcome == DetectionOutcome::missed ? "missed"
                                                                     : "early"},
         {"delay_ms", detected ? nlohmann::json(static_cast<double>(detection.delay.count()) / 1000) : nlohmann::json()}});
  }
  json["false_alarms"] = prediction.truth.labels.empty() ? nlohmann::json() : nlohmann::json(prediction.false_alarms.alarms);
  return json;
}

/// The same with a name of its own for each run: object and run, whatever the folder above it is.
fs::path stem_of(const EvalArguments& args, const ModelBundle& bundle, const RunFolder& run) {
  return (args.out.empty() ? bundle.folder / "runs" : fs::path(args.out)) / (run.object + "-" + run.run);
}

}  // namespace

void show_runs(const EvalArguments& args, const CommonArguments& common) {
  let_openmp_threads_sleep();
  std::optional<Dataset> dataset;
  if (fs::exists(dataset_file(args.data))) dataset.emplace(dataset_file(args.data));
  std::vector<std::string> errors;  // of runs that cannot be shown; the others are
  const auto attempt = [&errors](const auto& step) {
    try {
      step();
    } catch (const std::exception& e) {
      errors.push_back(sentence_of(e));
    }
  };
  std::vector<ChosenRun> asked_for;
  for (const std::string& given : args.runs) attempt([&] { asked_for.push_back(chosen_run(given, args, dataset)); });
  if (asked_for.empty()) return end_with(errors);
  const ModelBundle bundle = model_for_runs(args, dataset);
  const Classifier classifier = open_classifier(bundle.folder, common.threads, engine_named(args.engine));
  const ModelDescription& model = classifier.model();
  spdlog::info("every tick as {} sees it", bundle.folder.string());

  PredictionOptions options{.confirmation = confirmation_in(args.confirm), .threads = common.threads};
  if (args.gate) options.gate = gate_limit(bundle, model);
  if (dataset) options.guard = dataset->sampling().guard;
  if (dataset) options.include_flagged = member<bool>(dataset->settings(), "include_flagged", dataset->file().string());
  if (args.guard_ms >= 0) options.guard = microseconds{std::llround(args.guard_ms * 1000)};

  const bool of_this_dataset = dataset && model.manifest_hash == dataset->manifest_hash();
  std::vector<ChosenRun> runs;
  std::uint64_t total = 0, done = 0;
  for (const ChosenRun& run : asked_for) {
    attempt([&] {
      if (of_this_dataset && run.in_dataset) check_unchanged(*dataset, *run.in_dataset);
      total += expected_ticks(run.folder.events(), classifier.rendering());
      runs.push_back(run);
    });
  }

  const ProgressCallback progress = progress_line(common);
  nlohmann::json json = {
      {"model", bundle.folder.string()}, {"confirm", args.confirm}, {"engine", args.engine}, {"runs", nlohmann::json::array()}};
  std::vector<std::vector<std::string>> rows;
  const auto show = [&](const ChosenRun& run) {
    const std::string name = run.folder.name();
    // Of this dataset's runs the hash is known, and was held against the file.
    const bool learned_from =
        tactile::learned_from(model, of_this_dataset && run.in_dataset ? dataset->runs()[*run.in_dataset].events_sha256
                                                                       : sha256_of_file(run.folder.events()));
    const RunPrediction prediction = predict_run(run.folder, classifier, options, [&](std::size_t ticks) {
      done += ticks;
      tell(progress, done, total, "every tick of " + name);
    });
    if (prediction.verdicts.empty()) {
      throw Error(fmt::format("{}: shorter than the history of {} ms; expected a full tick at least", name,
                              static_cast<double>(classifier.rendering().history.count()) / 1000));
    }
    std::map<CameraTime, Touch> samples;
    if (of_this_dataset && run.in_dataset) {
      for (const Sample& sample : dataset->samples()) {
        if (sample.run_index == *run.in_dataset) samples[sample.t] = sample.touch;
      }
    }
    const fs::path stem = stem_of(args, bundle, run.folder);
    write_prediction(stem.string() + ".csv", prediction, samples);
    write_json(stem.string() + ".json", outcome_json(prediction));
    const PredictionPicture picture = picture_of(prediction, classifier, options.confirmation, learned_from);
    for (const char* extension : {".png", ".svg"}) draw_prediction(picture, stem.string() + extension);
    json["runs"].push_back(json_of(prediction, bundle, learned_from, stem));

    std::string met;
    for (const Detection& detection : prediction.detections)
      met += fmt::format("{}{} {}", met.empty() ? "" : ", ", name_of(detection.interval.touch), words_of(detection));
    rows.push_back({name + (learned_from ? " (learned from)" : ""), std::to_string(prediction.verdicts.size()),
                    prediction.truth.labels.empty() ? "-" : std::to_string(prediction.false_alarms.alarms),
                    met.empty() ? "no labels" : met});
    spdlog::info("{}: {}", name, stem.string() + ".csv, .png, .svg");
  };
  for (const ChosenRun& run : runs) attempt([&] { show(run); });
  if (rows.empty()) return end_with(errors);
  print_result(common, json,
               fmt::format("Every tick as {} sees it\n\n", bundle.name()) +
                   text_table({"run", "ticks", "false alarms", "intervals and their delay"}, rows) + "\nWritten to " +
                   stem_of(args, bundle, runs.front().folder).parent_path().string() + ": a CSV, JSON, PNG and SVG each\n");
  end_with(errors);
}

}  // namespace tactile
