#include "model_arguments.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "field_options.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "tactile/core/confirmation.hpp"
#include "tactile/core/error.hpp"
#include "tactile/model/training/split_remarks.hpp"
#include "tactile/windows/without_samples.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::cli {
namespace {

/// @throws Error  if no object has the training run, in the dataset or next to it: most likely a mistyped run
void check_train_run(const windows::Dataset& dataset, const std::string& wanted) {
  std::set<std::string> ids;
  for (const windows::DatasetRun& run : dataset.runs()) {
    if (run.run == wanted || std::filesystem::exists(windows::run_of(dataset, run.object, wanted).events())) return;
    ids.insert(run.run);
  }
  throw Error(fmt::format("--train-run {}: no object has such a run; expected one of {}", wanted, fmt::join(ids, ", ")));
}

/// The split. If there is none, a warning explains why runs have no samples.
windows::Split split_or_reasons(const windows::Dataset& dataset, const windows::SplitOptions& options) {
  check_train_run(dataset, options.train_run);
  try {
    return model::split_of(dataset, options);
  } catch (const Error&) {
    std::vector<RunFolder> runs;
    for (const windows::DatasetRun& run : dataset.runs()) runs.push_back(windows::run_of(dataset, run.object, run.run));
    const std::vector<windows::RunWithoutSamples> without = windows::runs_without_samples(dataset, runs);
    if (!without.empty())
      spdlog::warn("{}", windows::sentence_on(without, runs.size(), windows::data_folder_of(dataset), "tactile windows"));
    throw;
  }
}

}  // namespace

std::filesystem::path dataset_file(const std::string& data) {
  return std::filesystem::is_regular_file(data) ? std::filesystem::path(data) : std::filesystem::path(data) / "dataset.h5";
}

Check is_confirmation() { return readable_by(confirmation_in); }

namespace {

constexpr const char* by_kind = "by-kind";

/// "off", or a text that `read` reads. @param word  allowed too
template <class Read>
Check is_off_or(const Read& read, const std::string& word = "off") {
  return readable_by([read, word](const std::string& text) {
    if (text != "off" && text != word) read(text);
  });
}

}  // namespace

std::optional<windows::DatasetSummary> make_missing_dataset(const std::string& data, bool strict, const CommonArguments& common) {
  const std::filesystem::path file = dataset_file(data);
  if (std::filesystem::exists(file)) return std::nullopt;
  if (!std::filesystem::is_directory(data)) throw Error(data + ": no such folder; expected one with runs");
  spdlog::info("{} is missing: it is created with the defaults of 'tactile windows'", file.string());
  windows::DatasetSummary summary = windows::write_dataset(data, file, {.strict = strict}, common.threads, progress_line(common));
  for (const std::string& warning : summary.warnings) spdlog::warn("{}", warning);
  spdlog::info("{}: {} samples", file.string(), summary.samples);
  return summary;
}

std::vector<std::string> warn_of_splits(const windows::Dataset& dataset, std::span<const windows::SplitOptions> splits,
                                        bool strict) {
  std::vector<std::string> sentences;
  std::optional<RunFolder> flagged;
  const auto add = [&](const std::vector<std::string>& some) {
    for (const std::string& sentence : some) {
      if (std::find(sentences.begin(), sentences.end(), sentence) == sentences.end()) sentences.push_back(sentence);
    }
  };
  for (const windows::SplitOptions& options : splits) {
    const model::SplitRemarks remarks = model::remarks_on(dataset, options, split_or_reasons(dataset, options));
    if (strict) windows::refuse_objects_left_out(remarks.left_out);
    add(remarks.substitutes);
    add(remarks.left_out);
    if (splits.size() == 1) add(remarks.untested);
    if (!flagged) flagged = remarks.flagged;
  }
  if (flagged) sentences.push_back(windows::how_to_lift_flags(*flagged, "tactile windows"));
  for (const std::string& sentence : sentences) spdlog::warn("{}", sentence);
  return sentences;
}

std::vector<std::string> objects_to_hold_out(const std::vector<std::string>& named, const windows::Dataset& dataset) {
  std::set<std::string> objects, with_samples, flagged;
  for (const windows::DatasetRun& run : dataset.runs()) objects.insert(run.object);
  for (const windows::Sample& sample : dataset.samples()) with_samples.insert(dataset.runs()[sample.run_index].object);
  for (const windows::RunWithoutSamples& run : windows::runs_of_objects_left_out(dataset)) flagged.insert(run.object);
  std::vector<std::string> held_out;
  for (const std::string& object : named.empty() ? windows::default_held_out() : named) {
    // A flagged object that is not in the dataset is left out. The split rejects an unknown name.
    if (objects.contains(object) || (!named.empty() && !flagged.contains(object))) held_out.push_back(object);
  }
  std::set<std::string> left = with_samples;
  for (const std::string& object : held_out) left.erase(object);
  const bool any_known = std::any_of(held_out.begin(), held_out.end(), [&](const std::string& object) {
    return with_samples.contains(object) || !objects.contains(object);
  });
  if (any_known && !left.empty()) return held_out;
  throw Error(fmt::format("{}: {} of its objects with samples is {}; expected --held-out with some of {}",
                          dataset.file().string(), any_known ? "every one" : "none",
                          named.empty() ? "among the paper's five to hold out" : "held out", fmt::join(with_samples, ", ")));
}

std::string training_size(const windows::Dataset& dataset, const model::ModelSettings& settings) {
  const std::size_t samples = model::samples_of_runs(dataset, model::split_of(dataset, settings.split).train_runs).size();
  const std::string length = settings.kind == model::ModelKind::stream ? counted(settings.stream.steps, "step")
                                                                       : counted(settings.training.epochs, "epoch");
  return fmt::format("{}, {}", counted(samples, "sample"), length);
}

void TrainingEstimate::begin(unsigned epoch, double done) {
  has_begun_ = true;
  measured_from_ = Clock::now();
  measured_from_epochs_ = epoch - 1 + done;
}

void TrainingEstimate::see(const Progress& progress) {
  const std::uint64_t of_an_epoch = progress.total / epochs_;
  const auto epoch = static_cast<unsigned>(of_an_epoch > 0 ? progress.done / of_an_epoch : 0);
  const bool ends_an_epoch = of_an_epoch > 0 && epoch > measured_from_epochs_ && progress.done % of_an_epoch == 0;
  if (has_begun_ && ends_an_epoch) {
    using Seconds = std::chrono::duration<double>;
    const Clock::time_point now = Clock::now();
    const Seconds left = Seconds(now - measured_from_) * ((epochs_ - epoch) / (epoch - measured_from_epochs_));
    const Clock::time_point end = now + std::chrono::duration_cast<Clock::duration>(left);
    const bool was_right = expected_end_ && std::abs(Seconds(end - *expected_end_).count()) <= left.count() / 4;
    if (epoch < epochs_ && !was_right) {
      spdlog::info("epoch {} of {} is done: about {} more (min:s)", epoch, epochs_, clock_text(left.count()));
      expected_end_ = end;
    }
    measured_from_ = now;
    measured_from_epochs_ = epoch;
  }
  if (progress_) progress_(progress);
}

void add_engine_option(Command command, model::EngineKind& engine) {
  add_word(command, "--engine", engine, model::training_engines,
           "Inference engine: fast (tactile's own) or libtorch (supports every activation and pooling)");
}

void add_confirm_option(Command command, DecisionArguments& args) {
  command
      .add_option("--confirm", args.confirm, "Report a class only if it was predicted in at least K of the last N ticks; K > N/2")
      .check(is_off_or(confirmation_in))
      .type_name("K/N")
      .show_default();
}

void add_thresholds_option(Command command, DecisionArguments& args) {
  command
      .add_option("--thresholds", args.thresholds,
                  std::string("Report a class from log-odds ON until they are below OFF for HOLD ms, and confirm a slip from "
                              "CONFIRMED; instead of --confirm") +
                      (args.usual_thresholds == by_kind ? "; by-kind: those of 'detect' for a stream, off for others" : ""))
      .check(is_off_or(model::two_thresholds_in, args.usual_thresholds))
      .type_name("ON:OFF:HOLD:CONFIRMED")
      .show_default();
}

Confirmation confirmation_of(const DecisionArguments& args) {
  return args.confirm == "off" ? Confirmation{} : confirmation_in(args.confirm);
}

std::optional<model::TwoThresholds> thresholds_of(const DecisionArguments& args, model::ModelKind kind) {
  if (args.thresholds == "off") return std::nullopt;
  if (args.confirm == "off")
    return args.thresholds == by_kind ? model::usual_thresholds(kind) : model::two_thresholds_in(args.thresholds);
  if (args.thresholds == args.usual_thresholds) return std::nullopt;
  throw Error(fmt::format("--thresholds {}: cannot be combined with --confirm {}; expected one of the two", args.thresholds,
                          args.confirm));
}

model::Decision decision_of(const DecisionArguments& args, model::ModelKind kind) {
  return {.confirmation = confirmation_of(args), .thresholds = thresholds_of(args, kind)};
}

}  // namespace tactile::cli
