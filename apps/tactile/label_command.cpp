#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <map>
#include <opencv2/core/types.hpp>
#include <utility>

#include "camera_time.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "label_edits.hpp"
#include "label_exchange.hpp"
#include "label_pictures.hpp"
#include "label_tables.hpp"
#include "labelled_run.hpp"
#include "option_checks.hpp"
#include "rendering_arguments.hpp"
#include "robot_columns.hpp"
#include "run_places.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/robot/robot_log.hpp"
#include "truth_tables.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct LabelArguments {
  std::vector<std::string> places{"data"};
  bool compare_truth = false;
  bool force = false;
  bool summary = false;
  bool strict = false;
  bool no_pictures = false;
  bool camera_time = false;
  labels::DoubtLimits doubt;
  std::string roi;
  std::string robot_columns;
  std::string mask;
  std::string session;
  LabelExchangeArguments exchange;
  LabelEditArguments edits;
};

constexpr int widest_film = 8192;  // [px]

/// "x,y,width,height" as a part of a picture; nothing if it is none.
std::optional<cv::Rect> region_in(std::string_view text) {
  std::array<int, 4> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t end = std::min(text.find(','), text.size());
    const auto number = whole_number_in(text.substr(0, end));
    const bool is_last = i + 1 == numbers.size();
    if (!number || *number < (i < 2 ? 0 : 1) || *number > widest_film || (end == text.size()) != is_last) return std::nullopt;
    numbers[i] = static_cast<int>(*number);
    if (!is_last) text.remove_prefix(end + 1);
  }
  return cv::Rect(numbers[0], numbers[1], numbers[2], numbers[3]);
}

Check is_region() {
  return Check{[](std::string& text) {
                 return region_in(text) ? std::string()
                                        : fmt::format(
                                              "'{}' is no part of a picture; expected x,y,width,height in whole pixels, such as "
                                              "100,50,640,480",
                                              text);
               },
               "x,y,width,height [px]"};
}

/// The results of the runs, to print and to check.
struct Outcome {
  std::vector<LabelledRun> labelled;
  std::vector<std::string> kept;      ///< names of runs whose labels were left as they were: nothing has changed
  std::vector<std::string> failures;  ///< errors, one a run
};

CameraTime first_event_of(const labels::Labels& labels, const RunFolder& run) {
  if (const auto us = labels.provenance.find("first_event_us"); us != labels.provenance.end() && us->is_number_integer())
    return camera_time(us->get<std::int64_t>());
  // Labels that were not made here: their times still count from the recording's start.
  const events::RecordingReader recording(run.events());
  CameraTime first = CameraTime::max();
  for (const events::PacketRecord& packet : recording.packets()) {
    if (packet.elements > 0 && recording.stream(packet.stream_id).type == events::StreamType::events)
      first = std::min(first, packet.first);
  }
  return first;
}

Outcome label_all(const CommonArguments& common, const LabelArguments& arguments, const std::vector<RunFolder>& runs) {
  labels::LabelRunsOptions options{.label = {}, .force = arguments.force, .threads = common.threads};
  options.label.doubt = arguments.doubt;
  if (!arguments.roi.empty()) options.label.signals.video.region = region_in(arguments.roi);
  options.label.signals.robot.columns = arguments.robot_columns;
  if (!arguments.mask.empty()) options.label.signals.rate.mask = events::read_mask(arguments.mask);
  LabelPictures pictures;
  if (!arguments.no_pictures) {
    // A picture that is older than the labels shows them as they were before an edit.
    options.has_companions = [](const RunFolder& run) {
      std::error_code missing;
      const auto drawn = fs::last_write_time(label_picture_of(run), missing);
      return !missing && drawn >= fs::last_write_time(run.labels(), missing);
    };
    options.make_companions = [&](const alignment::RunSignals& signals, const labels::Labels&) { pictures.draw(signals); };
  }
  Outcome outcome;
  std::size_t labelled = 0;
  for (labels::RunOutcome& run : labels::label_runs(runs, options, progress_line(common))) {
    if (!run.error.empty()) {
      outcome.failures.push_back(std::move(run.error));
      continue;
    }
    (run.unchanged ? outcome.kept.emplace_back(run.run.name()), labelled : ++labelled);
    const CameraTime first = first_event_of(run.labels, run.run);
    outcome.labelled.push_back({std::move(run.run), std::move(run.labels), first, zero_of_times(arguments.camera_time, first)});
  }
  pictures.warn_of_failures();
  const auto so_many = [](std::size_t count) { return count == 1 ? std::string("1 run") : fmt::format("{} runs", count); };
  if (!outcome.kept.empty())
    spdlog::info("{} unchanged and not labelled again; --force labels again, and discards a person's edits",
                 so_many(outcome.kept.size()));
  spdlog::info("{} labelled; {} flagged", so_many(labelled),
               so_many(static_cast<std::size_t>(std::count_if(outcome.labelled.begin(), outcome.labelled.end(), is_flagged))));
  return outcome;
}

/// Writes the session into run.json of the runs; into none if one has no run.json.
void set_session(const std::vector<RunFolder>& runs, const std::string& session) {
  std::vector<std::pair<RunFolder, RunInfo>> changed;
  std::vector<std::string> before;
  for (const RunFolder& run : runs) {
    if (!is_there(run.info()))
      throw Error("--session: " + run.name() + " has no run.json; expected a run that 'tactile import' or 'tactile record' made");
    RunInfo info = read_run_info(run);
    if (info.session == session) continue;
    before.push_back(fmt::format("{} '{}'", run.name(), std::exchange(info.session, session)));
    changed.emplace_back(run, std::move(info));
  }
  for (const auto& [run, info] : changed) write_run_info(run, info);
  if (!before.empty()) spdlog::info("session is now '{}'; it was: {}", session, fmt::join(before, ", "));
}

/// The robot log or film of one recording may lie beside another: then both runs have the same file.
void warn_of_shared_files(const std::vector<LabelledRun>& runs) {
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> runs_of;  // by file and hash
  for (const LabelledRun& labelled : runs) {
    const nlohmann::json inputs = labelled.labels.provenance.value("inputs", nlohmann::json::object());
    for (const fs::path& file : {labelled.run.robot(), labelled.run.video()}) {
      const std::string name = file.filename().string();
      if (const std::string hash = inputs.value(name, ""); !hash.empty()) runs_of[{name, hash}].push_back(labelled.run.name());
    }
  }
  for (const auto& [file, sharing] : runs_of) {
    if (sharing.size() > 1)
      spdlog::warn("{} have the same {}; this is right only if it contains all of these runs", fmt::join(sharing, ", "),
                   file.first);
  }
}

/// Of the labels that are there.
Outcome read_runs(std::vector<RunFolder> runs, bool camera_time) {
  std::vector<std::string> without;
  std::erase_if(runs, [&](const RunFolder& run) {
    if (is_there(run.labels())) return false;
    without.push_back(run.name());
    return true;
  });
  if (runs.empty()) throw Error("--summary: none of the runs has labels; expected labels, run 'tactile label' first");
  if (!without.empty()) spdlog::warn("left out, because they have no labels: {}", fmt::join(without, ", "));
  Outcome outcome;
  for (const RunFolder& run : runs) {
    try {
      labels::Labels labels = labels::read_labels(run.labels());
      const CameraTime first = first_event_of(labels, run);
      outcome.labelled.push_back({run, std::move(labels), first, zero_of_times(camera_time, first)});
    } catch (const std::exception& e) {
      outcome.failures.push_back(sentence_of(e, run.name()));
    }
  }
  return outcome;
}

/// What else than editing is asked for.
std::vector<std::string> other_work(const LabelArguments& arguments) {
  std::vector<std::string> options;
  for (const auto& [option, is_given] :
       {std::pair{"--import", arguments.exchange.imports()}, std::pair{"--export", arguments.exchange.exports()},
        std::pair{"--summary", arguments.summary}, std::pair{"--compare-truth", arguments.compare_truth},
        std::pair{"--force", arguments.force}, std::pair{"--strict", arguments.strict},
        std::pair{"--roi", !arguments.roi.empty()}, std::pair{"--robot-columns", !arguments.robot_columns.empty()},
        std::pair{"--mask", !arguments.mask.empty()}, std::pair{"--session", !arguments.session.empty()}}) {
    if (is_given) options.emplace_back(option);
  }
  return options;
}

void run_label(const CommonArguments& common, const LabelArguments& arguments) {
  check_exchange(arguments.exchange);
  check_edits(arguments.edits, other_work(arguments));
  if (!arguments.edits.edits.empty()) return edit_labels(common, arguments.edits, arguments.places, !arguments.no_pictures);
  const RunsBelow found = runs_in(arguments.places);
  const std::vector<RunFolder>& runs = found.runs;
  if (arguments.edits.edits_labels()) return go_through_history(common, arguments.edits, found, !arguments.no_pictures);
  if (!arguments.session.empty() && (arguments.exchange.imports() || arguments.exchange.exports()))
    throw Error("--session: labels runs; expected it without --import and --export");
  if (arguments.exchange.imports()) {
    return import_labels(
        common, arguments.exchange, found,
        {.note = arguments.edits.note(), .dry_run = arguments.edits.dry_run, .draw_pictures = !arguments.no_pictures});
  }
  if (arguments.exchange.exports()) {
    return export_labels(common, arguments.exchange, found, arguments.force, [&](std::span<const RunFolder> unlabelled) {
      return label_all(common, arguments, {unlabelled.begin(), unlabelled.end()}).failures;
    });
  }
  if (!arguments.session.empty()) set_session(runs, arguments.session);
  Outcome outcome = arguments.summary ? read_runs(runs, arguments.camera_time) : label_all(common, arguments, runs);
  outcome.failures.insert(outcome.failures.end(), found.unreadable.begin(), found.unreadable.end());
  const std::vector<LabelledRun>& labelled = outcome.labelled;
  warn_of_shared_files(labelled);
  nlohmann::json json = {
      {"runs", runs_json(labelled)}, {"kept", outcome.kept}, {"failed", outcome.failures}, {"misnamed", found.misnamed}};
  std::string text = labelled.empty() ? "" : runs_table(labelled, arguments.summary);
  if (arguments.summary && !labelled.empty()) {
    json["objects"] = objects_json(labelled);
    json["differences"] = differences_json(labelled);
    text += "\n" + objects_table(labelled) + "\n" + differences_table(labelled);
    if (const std::string remarks = remarks_text(labelled); !remarks.empty()) text += "\n" + remarks;
  }
  if (arguments.compare_truth && !labelled.empty()) {
    const TruthTables truth = compare_all(labelled);
    json["truth"] = truth.json;
    text += truth.text;
    outcome.failures.insert(outcome.failures.end(), truth.errors.begin(), truth.errors.end());
    json["failed"] = outcome.failures;
  }
  print_result(common, json, text);
  end_with(outcome.failures);
  if (arguments.strict && std::any_of(labelled.begin(), labelled.end(), is_flagged)) throw CheckFailed{};
}

}  // namespace

void add_label_command(CLI::App& app) {
  auto arguments = std::make_shared<LabelArguments>();
  Command command = add_command(app, "label", "Align the clocks of runs, and find the start and end of press and slip",
                                [arguments](const CommonArguments& common) { run_label(common, *arguments); });
  const Option data = command.add_option("data", arguments->places, "Folders of runs, or single runs").show_default();
  const Option compare_truth =
      command.add_flag("--compare-truth", arguments->compare_truth, "Print errors against truth.json, for simulated runs");
  const Option summary = command.add_flag(
      "--summary", arguments->summary, "Only print tables of the existing labels and of the differences between their sources");
  command.add_flag("--strict", arguments->strict, "Exit with 2 if a run has an unconfirmed flag");
  command.add_flag("--no-pictures", arguments->no_pictures, "Do not draw labels.png").excludes(summary);
  command.add_option("--least-probability", arguments->doubt.least_probability, "Flag a touch that is less probable")
      .type_name("P")
      .check(in_range(0.5, 1.0))
      .show_default()
      .excludes(summary);
  command
      .add_option("--widest-onset", arguments->doubt.widest_onset_ms,
                  "Flag an onset with a 95 % interval wider than this many ms")
      .type_name("MS")
      .check(in_range(1.0, 1e5))
      .show_default()
      .excludes(summary);
  command.add_option("--roi", arguments->roi, "Part of the video that shows press and slip")
      .type_name("X,Y,W,H")
      .check(is_region())
      .excludes(summary);
  add_robot_columns_option(command, arguments->robot_columns).excludes(summary);
  add_mask_option(command, arguments->mask).excludes(summary);
  command
      .add_option("--session", arguments->session,
                  "Write this session into run.json of the runs of DATA: they share their clocks, so one clock is fitted to all")
      .type_name("NAME")
      .check(Check{[](std::string& text) { return text.empty() ? std::string("is empty") : std::string(); }, ""})
      .needs(data)  // without it, all runs would get one session
      .excludes(summary);
  const Option force =
      command
          .add_flag("--force", arguments->force,
                    "Also label unchanged runs again, and discard a person's edits; with --export, replace existing files")
          .excludes(summary);
  add_camera_time_option(command, arguments->camera_time);
  add_label_exchange_options(command, arguments->exchange, compare_truth, force);
  add_label_edit_options(command, arguments->edits);
}

}  // namespace tactile::cli
