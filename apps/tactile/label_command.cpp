#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "command.hpp"
#include "commands.hpp"
#include "label_exchange.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/labels/human_edits.hpp"
#include "tactile/labels/label_run.hpp"
#include "tactile/labels/truth_comparison.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

struct LabelArguments {
  std::vector<std::string> places{"data"};
  bool compare_truth = false;
  bool force = false;
  LabelExchangeArguments exchange;
};

/// Runs, and data folders as all of their runs; each once.
std::vector<RunFolder> runs_in(const std::vector<std::string>& places) {
  std::vector<RunFolder> runs;
  for (const std::string& place : places) {
    if (fs::exists(fs::path(place) / "events.aedat4")) {
      runs.push_back(run_folder_at(place));
      continue;
    }
    const std::vector<RunFolder> found = find_runs(place);
    if (found.empty())
      throw Error(place + ": holds no run; expected DATA/<object>/<run>/events.aedat4, as 'tactile simulate' makes them");
    runs.insert(runs.end(), found.begin(), found.end());
  }
  return runs;
}

bool somebody_confirmed(const RunFolder& run) { return fs::exists(run.labels()) && has_human_edits(read_labels(run.labels())); }

std::string ms(const std::optional<microseconds>& time) {
  return time ? fmt::format("{:.1f}", static_cast<double>(time->count()) / 1000.0) : "-";
}

nlohmann::json us_or_null(const std::optional<microseconds>& time) {
  return time ? nlohmann::json(time->count()) : nlohmann::json(nullptr);
}

struct LabelledRun {
  RunFolder run;
  Labels labels;
  CameraTime first_event{};
};

const LabelledInterval* first_of(const Labels& labels, Touch touch) {
  const auto found = std::find_if(labels.intervals.begin(), labels.intervals.end(),
                                  [&](const LabelledInterval& interval) { return interval.touch == touch; });
  return found == labels.intervals.end() ? nullptr : &*found;
}

std::optional<microseconds> lag_of(const Labels& labels) {
  const LabelledInterval* slip = first_of(labels, Touch::slip);
  if (slip == nullptr || !slip->evidence.robot) return std::nullopt;
  return between(*slip->evidence.robot, slip->start.at);
}

std::string onset_text(const LabelledRun& labelled, Touch touch) {
  const LabelledInterval* interval = first_of(labelled.labels, touch);
  if (interval == nullptr) return "-";
  return fmt::format("{} ±{}", ms(between(labelled.first_event, interval->start.at)),
                     ms(between(interval->start.low, interval->start.high) / 2));
}

std::string length_text(const Labels& labels, Touch touch) {
  const LabelledInterval* interval = first_of(labels, touch);
  return interval == nullptr ? "-" : ms(between(interval->start.at, interval->end.at));
}

std::string table_of(const std::vector<LabelledRun>& runs) {
  std::vector<std::vector<std::string>> rows;
  for (const LabelledRun& labelled : runs) {
    const auto standing = std::count_if(labelled.labels.flags.begin(), labelled.labels.flags.end(),
                                        [](const LabelFlag& flag) { return !flag.confirmed; });
    rows.push_back({labelled.run.name(), onset_text(labelled, Touch::press), length_text(labelled.labels, Touch::press),
                    onset_text(labelled, Touch::slip), length_text(labelled.labels, Touch::slip), ms(lag_of(labelled.labels)),
                    standing == 0 ? "" : std::to_string(standing)});
  }
  std::string text = text_table({"run", "press at [ms]", "lasts", "slip at [ms]", "lasts", "lift to slip", "flags"}, rows);
  for (const LabelledRun& labelled : runs) {
    const auto presses = std::count_if(labelled.labels.intervals.begin(), labelled.labels.intervals.end(),
                                       [](const LabelledInterval& interval) { return interval.touch == Touch::press; });
    if (presses > 1)
      text += wrapped(fmt::format("{}: {} presses, of which the first is shown", labelled.run.name(), presses), 2) + "\n";
    for (const LabelFlag& flag : labelled.labels.flags)
      text += wrapped(fmt::format("{}: {}", labelled.run.name(), flag.reason), 2) + "\n";
  }
  return text +
         wrapped(
             "Times in ms; onsets count from a run's first event, ± is half their 95 % interval. Lift to slip holds the "
             "robot clock's error, some 10 ms.") +
         "\n";
}

nlohmann::json json_of(const std::vector<LabelledRun>& runs) {
  nlohmann::json result = nlohmann::json::array();
  for (const LabelledRun& labelled : runs) {
    nlohmann::json intervals = nlohmann::json::array();
    for (const LabelledInterval& interval : labelled.labels.intervals) {
      intervals.push_back({{"class", name_of(interval.touch)},
                           {"start_us", us_of(interval.start.at)},
                           {"start_low_us", us_of(interval.start.low)},
                           {"start_high_us", us_of(interval.start.high)},
                           {"end_us", us_of(interval.end.at)}});
    }
    nlohmann::json flags = nlohmann::json::array();
    for (const LabelFlag& flag : labelled.labels.flags) flags.push_back(flag.reason);
    result.push_back({{"run", labelled.run.name()},
                      {"intervals", intervals},
                      {"lift_to_slip_us", us_or_null(lag_of(labelled.labels))},
                      {"flags", flags}});
  }
  return result;
}

/// Errors of one kind over all runs.
class Errors {
 public:
  void add(const std::optional<microseconds>& error) {
    if (error) values_ms_.push_back(std::abs(static_cast<double>(error->count())) / 1000.0);
  }
  std::size_t count() const { return values_ms_.size(); }
  double quantile_ms(double share) {
    std::sort(values_ms_.begin(), values_ms_.end());
    const auto index = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values_ms_.size())));
    return values_ms_[index > 0 ? index - 1 : 0];
  }

 private:
  std::vector<double> values_ms_;
};

struct Comparison {
  nlohmann::json json;
  std::string text;
};

Comparison compare_all(const std::vector<LabelledRun>& runs) {
  Errors press_start, press_end, slip_start, slip_end, press_first, slip_first, clock;
  std::size_t covered = 0, truly = 0, missed = 0, spurious = 0, compared = 0;
  for (const LabelledRun& labelled : runs) {
    if (!fs::exists(labelled.run.truth())) continue;
    ++compared;
    const TruthComparison comparison = compare_with_truth(labelled.labels, read_truth(labelled.run.truth()));
    for (const IntervalComparison& interval : comparison.intervals) {
      const bool press = interval.touch == Touch::press;
      (press ? press_start : slip_start).add(interval.start_error);
      (press ? press_end : slip_end).add(interval.end_error);
      (press ? press_first : slip_first).add(interval.first_event_error);
      ++truly;
      covered += interval.covered ? 1 : 0;
      missed += interval.start_error ? 0 : 1;
    }
    spurious += comparison.spurious;
    clock.add(comparison.robot_clock_error);
  }
  if (compared == 0) throw Error("--compare-truth: none of the runs has a truth.json; expected simulated runs");

  nlohmann::json json = {{"runs", compared},     {"intervals", truly},        {"missed", missed},
                         {"spurious", spurious}, {"onsets_covered", covered}, {"errors_ms", nlohmann::json::object()}};
  std::vector<std::vector<std::string>> rows;
  const std::vector<std::pair<std::string, Errors*>> kinds = {
      {"press_onset", &press_start}, {"press_onset_to_first_event", &press_first}, {"press_end", &press_end},
      {"slip_onset", &slip_start},   {"slip_onset_to_first_event", &slip_first},   {"slip_end", &slip_end},
      {"robot_clock", &clock}};
  for (const auto& [name, errors] : kinds) {
    if (errors->count() == 0) continue;
    json["errors_ms"][name] = {{"n", errors->count()},
                               {"median", errors->quantile_ms(0.5)},
                               {"p95", errors->quantile_ms(0.95)},
                               {"max", errors->quantile_ms(1.0)}};
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    rows.push_back({words, std::to_string(errors->count()), fmt::format("{:.2f}", errors->quantile_ms(0.5)),
                    fmt::format("{:.2f}", errors->quantile_ms(0.95)), fmt::format("{:.2f}", errors->quantile_ms(1.0))});
  }
  std::string text =
      "\n" +
      wrapped(fmt::format("Against the truth of {} simulated {}: {} intervals, {} missed, {} spurious; {} of {} onsets inside "
                          "their 95 % interval.",
                          compared, compared == 1 ? "run" : "runs", truly, missed, spurious, covered, truly)) +
      "\n";
  text += text_table({"absolute error [ms]", "n", "median", "95th percentile", "largest"}, rows);
  return {json, text};
}

CameraTime first_event_of(const RunFolder& run) {
  const RecordingReader recording(run.events());
  CameraTime first = CameraTime::max();
  for (const PacketRecord& packet : recording.packets()) {
    if (packet.elements > 0 && recording.stream(packet.stream_id).type == StreamType::events)
      first = std::min(first, packet.first);
  }
  return first;
}

void label_runs(const CommonArguments& common, const LabelArguments& arguments) {
  const std::vector<RunFolder> runs = runs_in(arguments.places);
  if (arguments.exchange.imports()) return import_labels(common, arguments.exchange, runs);
  if (arguments.exchange.exports()) {
    return export_labels(common, arguments.exchange, runs, arguments.force, [&](std::span<const RunFolder> unlabelled) {
      parallel_for(unlabelled.size(), common.threads,
                   [&](std::size_t i) { write_labels(unlabelled[i].labels(), label_run(unlabelled[i])); });
    });
  }
  const ProgressCallback progress = progress_line(common);
  std::vector<std::optional<LabelledRun>> outcomes(runs.size());
  std::vector<std::string> failures(runs.size()), kept(runs.size());
  std::mutex guard;
  std::size_t done = 0;
  parallel_for(runs.size(), common.threads, [&](std::size_t i) {
    // One run that cannot be read does not keep the others from being labelled.
    try {
      if (!arguments.force && somebody_confirmed(runs[i])) {
        kept[i] = runs[i].name();
        outcomes[i] = {runs[i], read_labels(runs[i].labels()), first_event_of(runs[i])};
      } else {
        Labels labels = label_run(runs[i]);
        write_labels(runs[i].labels(), labels);
        outcomes[i] = {runs[i], std::move(labels), first_event_of(runs[i])};
      }
    } catch (const std::exception& e) {
      failures[i] = e.what();
    }
    const std::scoped_lock lock(guard);
    tell(progress, ++done, runs.size(), runs[i].name());
  });

  std::vector<LabelledRun> labelled;
  for (std::optional<LabelledRun>& outcome : outcomes) {
    if (outcome) labelled.push_back(std::move(*outcome));
  }
  std::erase(kept, "");
  std::erase(failures, "");
  if (!kept.empty()) spdlog::warn("kept as a person confirmed them, --force replaces them: {}", fmt::join(kept, ", "));
  nlohmann::json json = {{"runs", json_of(labelled)}, {"kept", kept}, {"failed", failures}};
  std::string text = labelled.empty() ? "" : table_of(labelled);
  if (arguments.compare_truth && !labelled.empty()) {
    const Comparison comparison = compare_all(labelled);
    json["truth"] = comparison.json;
    text += comparison.text;
  }
  const auto flagged =
      std::count_if(labelled.begin(), labelled.end(), [](const LabelledRun& run) { return !run.labels.flags.empty(); });
  spdlog::info("{} labelled, {} of them flagged", labelled.size() == 1 ? "1 run" : fmt::format("{} runs", labelled.size()),
               flagged);
  print_result(common, json, text);
  for (std::size_t i = 0; i + 1 < failures.size(); ++i) spdlog::error("{}", failures[i]);
  if (!failures.empty()) throw Error(failures.back());
}

}  // namespace

void add_label_command(CLI::App& app) {
  auto arguments = std::make_shared<LabelArguments>();
  auto* command = add_command(app, "label", "Align the clocks of runs, and find when press and slip begin and end",
                              [arguments](const CommonArguments& common) { label_runs(common, *arguments); });
  command->add_option("data", arguments->places, "Folders of runs, or single runs")->capture_default_str();
  CLI::Option* compare_truth = command->add_flag("--compare-truth", arguments->compare_truth,
                                                 "Print errors against truth.json, where simulated runs have one");
  CLI::Option* force = command->add_flag("--force", arguments->force,
                                         "Replace labels that a person confirmed, too; with --export, files that are there");
  add_label_exchange_options(*command, arguments->exchange, compare_truth, force);
}

}  // namespace tactile
