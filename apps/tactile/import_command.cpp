#include <fmt/core.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "converted_source.hpp"
#include "loose_recordings.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "recording_report.hpp"
#include "splitting_arguments.hpp"
#include "tactile/bags/bag.hpp"
#include "tactile/conversion/convert.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/run_numbers.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/splitting/split_proposal.hpp"
#include "tactile/splitting/split_recording.hpp"
#include "tactile/windows/shortest_run.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct ImportCommandArguments {
  std::vector<std::string> recordings;
  std::string object, run;
  SplittingArguments splitting;
};

/// A name that the user gave, and the one that a run folder needs.
struct Renamed {
  std::string given, used;
};

/// The names of the runs: of their object and of the first one.
struct RunNames {
  std::string object;
  std::optional<int> first_run;
  std::vector<Renamed> renamed;
};

RunNames names_of(const ImportCommandArguments& args) {
  RunNames names;
  names.object = is_object_name(args.object) ? args.object : needed_object_name(args.object);
  if (names.object.empty()) {
    throw Error(fmt::format(
        "--object '{}': has neither a letter nor a digit; expected the name of an object, such as water-bottle", args.object));
  }
  if (names.object != args.object) names.renamed.push_back({args.object, names.object});
  if (args.run.empty()) return names;
  names.first_run = static_cast<int>(*whole_number_in(args.run));
  if (const std::string id = run_id_of(*names.first_run); id != args.run) names.renamed.push_back({args.run, id});
  return names;
}

std::string check_run_number(const std::string& text) {
  const auto number = whole_number_in(text);
  return number && *number >= 1 && *number <= most_runs ? std::string()
                                                        : fmt::format("'{}' is not a number of a run; expected 1 to 99", text);
}

/// What a user named, or the recordings in it. A bag or a run is one recording.
std::vector<std::string> recordings_at(const std::string& place) {
  for (const char* extension : {".mp4", ".avi", ".mkv", ".mov"}) {
    if (conversion::lower_extension(place) == extension)
      throw Error(place + ": is a film; expected a recording, with its film as --video");
  }
  if (!fs::is_directory(place) || bags::is_bag(place) || is_there(run_folder_at(place).events())) return {place};
  std::vector<std::string> found = loose_recordings_in(place);
  if (found.empty()) throw Error(place + ": has no recording; expected .aedat4, .raw or bags in it, a run folder, or a file");
  return found;
}

/// @throws Error  if the folder has another run than one of this recording
void check_free(const RunFolder& run, const splitting::SplitSource& source) {
  if (!is_there(run.folder)) return;
  try {
    const nlohmann::json origin = read_run_info(run).extra.value("split", nlohmann::json::object());
    if (origin.value("sha256", "") == sha256_of_file(source.recording)) return;
  } catch (const std::exception&) {
    // It is no run that was imported.
  }
  throw Error(run.folder.string() + ": the run exists already, and is never overwritten; expected a free number, or no --run");
}

/// A recording that has become a run.
struct ImportedRun {
  std::string recording;
  splitting::SplitRun made;
  std::string robot, film;  ///< the files that were taken, or the bag that has them; empty if there is none
  RecordingReport report;
  std::vector<std::string> lacks;  ///< "robot log", "IMU", "film"
};

bool is_sound(const ImportedRun& run) { return run.report.health.healthy(); }

bool is_long_enough(const ImportedRun& run) { return run.report.health.duration() >= windows::shortest_run({}); }

/// Whether the recording is a sound file, but cannot be a run.
bool is_too_short(const ImportedRun& run) { return is_sound(run) && !is_long_enough(run); }

std::size_t healthy_in(const std::vector<ImportedRun>& runs) {
  return static_cast<std::size_t>(
      std::count_if(runs.begin(), runs.end(), [](const ImportedRun& run) { return is_sound(run) && is_long_enough(run); }));
}

std::size_t too_short_in(const std::vector<ImportedRun>& runs) {
  return static_cast<std::size_t>(std::count_if(runs.begin(), runs.end(), is_too_short));
}

ReportOptions as_info_check() {
  ReportOptions options;
  options.check = true;
  return options;
}

std::vector<std::string> lacks_of(const RecordingReport& report) {
  std::vector<std::string> lacks;
  if (!report.robot) lacks.emplace_back("robot log");
  const auto is_imu = [](const events::StreamHealth& stream) {
    return stream.stream.type == events::StreamType::imu && stream.stamps.elements > 0;
  };
  if (std::none_of(report.health.streams.begin(), report.health.streams.end(), is_imu)) lacks.emplace_back("IMU");
  if (!report.has_film) lacks.emplace_back("film");
  return lacks;
}

/// What `label` does without what is lacking: "mug/01 has no robot log and no film. 'tactile label' finds the lift by the IMU."
std::string label_text(const std::string& runs, bool several, const std::vector<std::string>& lacks) {
  const auto has = [&](const char* what) { return std::find(lacks.begin(), lacks.end(), what) == lacks.end(); };
  std::string text = runs + (several ? " have no " : " has no ");
  for (std::size_t i = 0; i < lacks.size(); ++i) text += (i == 0 ? "" : i + 1 == lacks.size() ? " and no " : ", no ") + lacks[i];
  if (!has("robot log") && !has("IMU") && !has("film"))
    return text + ". The events alone then decide which touch is the slip: look at each with 'tactile review'.";
  return text + fmt::format(". 'tactile label' finds the lift by the {}.", has("robot log") ? "robot log"
                                                                           : has("IMU")     ? "IMU"
                                                                                            : "film");
}

ImportedRun import_one(const std::string& recording, const ImportCommandArguments& args, const RunNames& names,
                       const CommonArguments& common) {
  std::optional<ConvertedSource> converted;
  if (needs_conversion(recording)) converted.emplace(recording, args.splitting.data, common);
  splitting::SplitSource source = converted ? converted->source() : splitting::split_source_at(recording);
  splitting::take_devices_of_same_name(source, recording);
  set_devices(source, args.splitting);
  if (names.first_run) {
    const std::string id = run_id_of(*names.first_run);
    check_free({fs::path(args.splitting.data) / names.object / id, names.object, id}, source);
  }
  events::RecordingReader reader(source.recording, common.threads);
  // A recording without cuts is one run, with all of its robot log and film.
  const splitting::SplitProposal whole = splitting::proposal_with(source, reader, {}, {.stream = args.splitting.stream});
  splitting::SplitResult result = splitting::split_recording(
      source, reader, whole,
      {.data = args.splitting.data, .objects = {names.object}, .first_run = names.first_run, .session = args.splitting.session},
      progress_line(common));
  warn_of_losses(recording, result.problems);
  const auto name_of = [&](const std::optional<fs::path>& file) {
    const bool is_in_bag = file && converted && file->parent_path() == source.recording.parent_path();
    return is_in_bag ? recording : file ? file->string() : std::string();
  };
  ImportedRun imported{.recording = recording,
                       .made = std::move(result.runs.front()),
                       .robot = name_of(source.robot),
                       .film = name_of(source.video),
                       .report = {},
                       .lacks = {}};
  const RunFolder& run = imported.made.run;
  imported.report = examine({run.name(), run.events(), run}, as_info_check(), common.threads, progress_line(common));
  imported.lacks = lacks_of(imported.report);
  return imported;
}

nlohmann::json json_of(const ImportCommandArguments& args, const RunNames& names, const std::vector<ImportedRun>& runs) {
  nlohmann::json renamed = nlohmann::json::array(), all = nlohmann::json::array();
  for (const Renamed& name : names.renamed) renamed.push_back({{"given", name.given}, {"used", name.used}});
  for (const ImportedRun& run : runs) {
    all.push_back({{"recording", run.recording},
                   {"run", run.made.run.name()},
                   {"folder", run.made.run.folder.string()},
                   {"robot", run.robot.empty() ? nlohmann::json() : nlohmann::json(run.robot)},
                   {"film", run.film.empty() ? nlohmann::json() : nlohmann::json(run.film)},
                   {"kept", run.made.is_kept},
                   {"events", run.made.events},
                   {"bytes", run.made.bytes},
                   {"healthy", run.report.health.healthy()},
                   {"reasons", run.report.health.reasons},
                   {"too_short", is_too_short(run)},
                   {"lacks", run.lacks}});
  }
  return {{"data", args.splitting.data}, {"renamed", renamed}, {"runs", all}};
}

/// @param failed  number of recordings that could not be imported
std::string text_of(const ImportCommandArguments& args, const RunNames& names, const std::vector<ImportedRun>& runs,
                    std::size_t failed) {
  std::string text;
  for (const Renamed& name : names.renamed) text += fmt::format("'{}' is named {}.\n", name.given, name.used);
  std::vector<std::vector<std::string>> rows;
  std::map<std::vector<std::string>, std::vector<std::string>> runs_lacking;
  for (const ImportedRun& run : runs) {
    const std::string name = run.made.run.name();
    const auto named = [](const std::string& file) { return file.empty() ? "-" : fs::path(file).filename().string(); };
    const events::RecordingHealth& health = run.report.health;
    const bool lacks_times = run.report.has_film && !run.report.video;
    rows.push_back({name, named(run.recording), named(run.robot), named(run.film) + (lacks_times ? ", no times" : ""),
                    duration_text(health.duration()), std::to_string(run.made.events),
                    !health.healthy()   ? "SICK: " + health.reasons.front()
                    : is_too_short(run) ? "too short for a run"
                    : run.made.is_kept  ? "imported before"
                                        : ""});
    if (!run.lacks.empty()) runs_lacking[run.lacks].push_back(name);
  }
  text += text_table({"run", "from", "robot log", "film", "length", "events", ""}, rows) +
          (failed > 0 ? fmt::format("{} of {} imported, ", runs.size(), runs.size() + failed) : "") +
          fmt::format("{} of {} healthy{}\n", healthy_in(runs), runs.size(),
                      too_short_in(runs) > 0 ? fmt::format(", {} too short for a run", too_short_in(runs)) : "");
  for (const auto& [lacks, which] : runs_lacking)
    text += wrapped(label_text(fmt::format("{}", fmt::join(which, ", ")), which.size() > 1, lacks)) + "\n";
  if (std::none_of(runs.begin(), runs.end(), is_long_enough)) return text;
  const fs::path object = fs::path(args.splitting.data) / names.object;
  return text + fmt::format("Next: tactile label {}\n", shell_word(object.string()));
}

void import_recordings(const ImportCommandArguments& args, const CommonArguments& common) {
  RunNames names = names_of(args);
  std::vector<std::string> recordings;
  for (const std::string& place : args.recordings) {
    for (const std::string& recording : recordings_at(place)) recordings.push_back(recording);
  }
  const auto warn_of_sharing = [&](const char* what, const std::string& file) {
    if (!file.empty() && recordings.size() > 1)
      spdlog::warn("{} recordings get the same {} ({}); if each has its own, import them one at a time", recordings.size(), what,
                   file);
  };
  warn_of_sharing("robot log", args.splitting.robot);
  warn_of_sharing("film", args.splitting.video);
  RunNames next = names;
  std::vector<ImportedRun> runs;
  std::vector<std::string> errors;
  for (const std::string& recording : recordings) {
    try {
      const ImportedRun& run = runs.emplace_back(import_one(recording, args, next, common));
      for (const std::string& reason : run.report.health.reasons) spdlog::error("{}: {}", run.made.run.name(), reason);
      if (is_too_short(run)) {
        spdlog::warn("{}: lasts {}, too short for a run; expected {} or more: 'tactile windows' finds no sample in less",
                     run.made.run.name(), duration_text(run.report.health.duration()), duration_text(windows::shortest_run({})));
      }
    } catch (const Error& e) {  // the others are imported nevertheless
      errors.emplace_back(e.what());
    }
    if (next.first_run) ++*next.first_run;  // a recording that cannot be imported keeps its number
  }
  nlohmann::json result = json_of(args, names, runs);
  result["errors"] = errors;
  if (!runs.empty() || common.json) print_result(common, result, runs.empty() ? "" : text_of(args, names, runs, errors.size()));
  end_with(errors);
  if (!std::all_of(runs.begin(), runs.end(), is_sound)) throw CheckFailed{};
}

}  // namespace

void add_import_command(CLI::App& app) {
  auto args = std::make_shared<ImportCommandArguments>();
  Command command = add_command(app, "import", "Make run folders of loose recordings, and check them",
                                [args](const CommonArguments& common) { import_recordings(*args, common); });
  command
      .add_option(
          "recordings", args->recordings,
          "Recordings, one for each run: .aedat4, or what 'tactile convert' reads; or folders of them. They are not changed")
      .type_name("RECORDING")
      .required();
  command.add_option("--object", args->object, "Object of the runs").type_name("NAME").required();
  command.add_option("--run", args->run, "Number of the run, or of the first of several; default: after the highest existing run")
      .type_name("NN")
      .check(Check{check_run_number, "1 to 99"});
  add_splitting_options(command, args->splitting);
}

}  // namespace tactile::cli
