#include "label_exchange.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <mutex>
#include <optional>
#include <utility>

#include "label_pictures.hpp"
#include "option_checks.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/exchange/label_csv.hpp"
#include "tactile/labels/exchange/label_studio.hpp"
#include "tactile/labels/exchange/run_exchange.hpp"
#include "tactile/labels/saved_labels.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

std::optional<labels::ExchangeFormat> format_in(const LabelExchangeArguments& arguments) {
  return labels::exchange_format_named(arguments.format);
}

std::optional<labels::TimeOrigin> origin_in(const LabelExchangeArguments& arguments) {
  return labels::time_origin_named(arguments.origin);
}

/// A file of an export: its range of runs, and its text once it is made.
struct FileToWrite {
  fs::path path;
  std::size_t first_run = 0, runs = 0;
  std::string text = {};
};

/// One file if `to` has an ending of a format, else a folder with a file for each run.
std::vector<FileToWrite> files_of(const fs::path& to, labels::ExchangeFormat format, const std::vector<RunFolder>& runs) {
  if (labels::exchange_format_by_ending(to) && !fs::is_directory(to)) return {{.path = to, .first_run = 0, .runs = runs.size()}};
  std::vector<FileToWrite> files;
  for (std::size_t i = 0; i < runs.size(); ++i)
    files.push_back(
        {.path = to / (labels::file_stem_of(runs[i]) + std::string(labels::ending_of(format))), .first_run = i, .runs = 1});
  return files;
}

/// A run's own files are no place for an export, whatever --force says.
void check_place(const fs::path& file, const std::vector<RunFolder>& runs) {
  std::error_code ignored;
  for (const RunFolder& run : runs) {
    if (!fs::equivalent(fs::absolute(file).parent_path(), run.folder, ignored)) continue;
    for (const fs::path& own : {run.labels(), run.truth(), run.info(), run.robot(), run.video_times()}) {
      if (own.filename() == file.filename())
        throw Error(fmt::format("--export {}: is a file of the run itself; expected a name of its own", file.string()));
    }
  }
}

bool holds(const FileToWrite& file) {
  std::error_code unknown;
  return fs::is_regular_file(file.path, unknown) && fs::file_size(file.path, unknown) == file.text.size() &&
         read_text(file.path) == file.text;
}

void check_free(const FileToWrite& file, bool replace) {
  if (replace || !is_there(file.path) || holds(file)) return;
  throw Error(fmt::format("{}: exists already, perhaps with a person's edits; expected another name, or --force to replace it",
                          file.path.string()));
}

std::string text_of(labels::ExchangeFormat format, std::span<const labels::LabelsToExport> labels) {
  switch (format) {
    case labels::ExchangeFormat::label_studio:
      return labels::label_studio_text(labels);
    case labels::ExchangeFormat::csv:
      return labels::label_csv_text(labels);
  }
  return {};
}

/// Label Studio's configuration is next to the tasks.
fs::path config_beside(const fs::path& to, const FileToWrite& tasks) {
  return tasks.path == to ? fs::path(to).replace_extension(".xml") : to / "label-studio.xml";
}

labels::ExchangeFormat format_to_export(const LabelExchangeArguments& arguments) {
  const auto format = format_in(arguments) ? format_in(arguments) : labels::exchange_format_by_ending(arguments.to);
  if (format) return *format;
  throw Error(fmt::format(
      "--export {}: its ending names no format; expected .json (Label Studio) or .csv, or a folder and --format", arguments.to));
}

bool has_no_labels(const RunFolder& run) { return !is_there(run.labels()); }

/// The labels of the runs. A run whose labels cannot be exported leaves `runs`, and `errors` gets the reason.
std::vector<labels::LabelsToExport> labels_to_export(const CommonArguments& common, const LabelExchangeArguments& arguments,
                                                     labels::ExchangeFormat format, std::vector<RunFolder>& runs,
                                                     std::vector<std::string>& errors) {
  const ProgressCallback progress = progress_line(common);
  std::vector<labels::LabelsToExport> labels(runs.size());
  std::vector<std::string> why_not(runs.size());
  std::mutex guard;
  std::size_t done = 0;
  parallel_for(runs.size(), common.threads, [&](std::size_t i) {
    try {
      labels[i] = labels::labels_to_export(runs[i], origin_in(arguments).value_or(labels::TimeOrigin::first_event));
      if (format == labels::ExchangeFormat::label_studio) labels[i].signals = labels::signals_of(runs[i], labels[i]);
    } catch (const std::exception& e) {
      why_not[i] = sentence_of(e, runs[i].name());
    }
    const std::scoped_lock lock(guard);
    report_progress(progress, ++done, runs.size(), runs[i].name());
  });
  for (std::size_t i = runs.size(); i-- > 0;) {
    if (why_not[i].empty()) continue;
    errors.push_back(why_not[i]);
    const auto place = static_cast<std::ptrdiff_t>(i);
    runs.erase(runs.begin() + place);
    labels.erase(labels.begin() + place);
  }
  return labels;
}

std::span<const labels::LabelsToExport> runs_of(const FileToWrite& file, std::span<const labels::LabelsToExport> labels) {
  return labels.subspan(file.first_run, file.runs);
}

/// @param files  the one without runs is Label Studio's configuration
void print_export(const CommonArguments& common, std::span<const FileToWrite> files,
                  std::span<const labels::LabelsToExport> labels, std::span<const RunFolder> labelled,
                  const std::vector<std::string>& errors) {
  nlohmann::json json = {
      {"exported", nlohmann::json::array()}, {"labelled", nlohmann::json::array()}, {"config", nullptr}, {"failed", errors}};
  std::vector<std::vector<std::string>> rows;
  std::string config;
  for (const FileToWrite& file : files) {
    const std::string path = file.path.string();
    for (const labels::LabelsToExport& run : runs_of(file, labels)) {
      const std::size_t intervals = run.labels.intervals.size();
      const std::string_view origin = name_of(run.times.origin);
      json["exported"].push_back({{"run", run.run}, {"file", path}, {"intervals", intervals}, {"origin", origin}});
      rows.push_back({run.run, std::to_string(intervals), std::string(origin), path});
    }
    if (file.runs > 0) continue;
    json["config"] = path;
    config = fmt::format("{}: their labelling configuration\n", path);
  }
  for (const RunFolder& run : labelled) json["labelled"].push_back(run.name());
  print_result(common, json, text_table({"run", "intervals", "times from", ""}, rows) + config);
}

/// The files that --import names. A folder stands for all of its files with a known format and the name of a run.
std::vector<fs::path> files_in(const LabelExchangeArguments& arguments, const std::vector<RunFolder>& runs) {
  const std::optional<labels::ExchangeFormat> format = format_in(arguments);
  std::vector<fs::path> files;
  for (const std::string& from : arguments.from) {
    std::error_code unknown;
    if (!fs::is_directory(from, unknown)) {
      files.emplace_back(from);
      continue;
    }
    const std::size_t before = files.size();
    for (const RunFolder& run : runs) {
      for (const char* name : {"label-studio", "csv"}) {
        const auto known = labels::exchange_format_named(name);
        const fs::path file = fs::path(from) / (labels::file_stem_of(run) + std::string(labels::ending_of(*known)));
        if ((!format || format == known) && is_there(file)) files.push_back(file);
      }
    }
    if (files.size() == before) {
      throw Error(fmt::format("--import {}: holds no file of the runs; expected files such as {}.csv, as --export names them",
                              from, runs.empty() ? "fan-01" : labels::file_stem_of(runs.front())));
    }
  }
  return files;
}

}  // namespace

void add_label_exchange_options(Command command, LabelExchangeArguments& arguments, const Option compare_truth,
                                const Option force) {
  const Option to = command
                        .add_option("--export", arguments.to,
                                    "Write labels for another tool: .json (Label Studio) or .csv; a folder gets one file per run")
                        .type_name("FILE")
                        .excludes(compare_truth);
  command
      .add_option("--import", arguments.from,
                  "Read edits from another tool into labels.json: a file or a folder; may be repeated")
      .type_name("FILE")
      .one_value_each_time()
      .excludes(to)
      .excludes(compare_truth)
      .excludes(force);
  command.add_option("--format", arguments.format, "Format for --export and --import; default: by the file's extension")
      .check(one_of({"label-studio", "csv"}));
  command
      .add_option("--origin", arguments.origin,
                  "Time zero of the exchanged file: first-event, camera or video. Default: first-event")
      .check(one_of({"first-event", "camera", "video"}));
}

void check_exchange(const LabelExchangeArguments& arguments) {
  if (arguments.exports() || arguments.imports()) return;
  for (const auto& [option, value] : {std::pair{"--format", &arguments.format}, std::pair{"--origin", &arguments.origin}}) {
    if (!value->empty())
      throw Error(fmt::format("{} {}: is only for exchanged labels; expected --export or --import too", option, *value));
  }
}

void export_labels(const CommonArguments& common, const LabelExchangeArguments& arguments, const RunsBelow& found, bool replace,
                   const std::function<std::vector<std::string>(std::span<const RunFolder>)>& label_first) {
  const labels::ExchangeFormat format = format_to_export(arguments);
  std::vector<RunFolder> runs = found.runs;
  for (const FileToWrite& file : files_of(arguments.to, format, runs)) check_place(file.path, runs);
  std::vector<RunFolder> unlabelled;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(unlabelled), has_no_labels);
  std::vector<std::string> errors = found.unreadable;
  if (!unlabelled.empty()) {
    const std::vector<std::string> failures = label_first(unlabelled);
    errors.insert(errors.end(), failures.begin(), failures.end());
    std::erase_if(runs, has_no_labels);
    std::erase_if(unlabelled, has_no_labels);
  }
  const std::vector<labels::LabelsToExport> labels = labels_to_export(common, arguments, format, runs, errors);
  if (runs.empty()) return end_with(errors);
  std::vector<FileToWrite> files = files_of(arguments.to, format, runs);
  for (FileToWrite& file : files) file.text = text_of(format, runs_of(file, labels));
  if (format == labels::ExchangeFormat::label_studio)
    files.push_back({.path = config_beside(arguments.to, files.front()), .text = labels::label_studio_config(labels)});
  for (const FileToWrite& file : files) check_free(file, replace);
  for (const FileToWrite& file : files) {
    if (!holds(file)) write_whole(file.path, file.text, replace ? IfThere::replace : IfThere::refuse);
  }
  print_export(common, files, labels, unlabelled, errors);
  end_with(errors);
}

void import_labels(const CommonArguments& common, const LabelExchangeArguments& arguments, const RunsBelow& found,
                   const ImportArguments& how) {
  const std::vector<RunFolder>& runs = found.runs;
  const std::vector<labels::ImportedRun> imported =
      labels::read_edits(files_in(arguments, runs), format_in(arguments), origin_in(arguments), runs);
  nlohmann::json json = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> unseen, errors = found.unreadable;
  std::vector<RunAndLabels> edited;
  std::string changes;
  for (const labels::ImportedRun& run : imported) {
    if (!run.looked_at) unseen.push_back(run.run.name());
    if (run.counts.edits() > 0 && !how.dry_run) {
      labels::SaveOutcome outcome = labels::save_edit(run.run, run.before_version, run.edit, how.note);
      if (std::holds_alternative<labels::EditConflict>(outcome)) {
        errors.push_back(run.run.name() + ": its labels were changed meanwhile, and were not edited; expected the import again");
        continue;
      }
      edited.push_back({run.run, std::move(std::get<labels::VersionedLabels>(outcome).labels)});
    }
    const labels::EditCounts& counts = run.counts;
    json.push_back({{"run", run.run.name()},
                    {"file", run.file},
                    {"looked_at", run.looked_at},
                    {"kept", counts.kept},
                    {"confirmed", counts.confirmed},
                    {"moved", counts.moved},
                    {"added", counts.added},
                    {"rejected", counts.rejected},
                    {"changes", run.changes}});
    rows.push_back({run.run.name(), std::to_string(counts.kept), std::to_string(counts.confirmed), std::to_string(counts.moved),
                    std::to_string(counts.added), std::to_string(counts.rejected), run.file});
    for (const std::string& change : run.changes) changes += fmt::format("{}: would be: {}\n", run.run.name(), change);
  }
  if (how.draw_pictures) draw_label_pictures(edited, common.threads);
  if (!unseen.empty()) spdlog::info("without an answer, unchanged: {}", fmt::join(unseen, ", "));
  print_result(
      common, {{"imported", json}, {"dry_run", how.dry_run}},
      text_table({"run", "as before", "newly confirmed", "moved", "added", "rejected", ""}, rows) + (how.dry_run ? changes : ""));
  end_with(errors);
}

}  // namespace tactile::cli
