#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "bag_report.hpp"
#include "camera_time.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "loose_recordings.hpp"
#include "option_checks.hpp"
#include "recording_report.hpp"
#include "run_places.hpp"
#include "tactile/bags/bag.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/runs_below.hpp"

namespace tactile::cli {
namespace fs = std::filesystem;
namespace {

struct InfoArguments {
  std::vector<std::string> places;
  ReportOptions report;
};

/// The recordings in the places that the user named, and what is left out.
struct Places {
  std::vector<RecordingPlace> found;
  std::vector<std::string> bags, misnamed, unreadable;
  std::vector<fs::path> without_recording;
  std::set<fs::path> not_examined;  ///< folders with recordings, in places where neither runs nor loose recordings are looked for
};

/// Whether one of the sentences is about the folder.
bool is_named_in(const std::vector<std::string>& sentences, const std::string& folder) {
  return std::any_of(sentences.begin(), sentences.end(),
                     [&](const std::string& sentence) { return sentence.starts_with(folder + ":"); });
}

/// Looks at all folders below `place` for recordings that are not in `places`. Hidden folders and discarded runs do not count.
void note_not_examined(const std::string& place, Places& places) {
  std::set<fs::path> examined(places.bags.begin(), places.bags.end()), runs;
  for (const RecordingPlace& found : places.found) {
    examined.insert(found.file);
    if (found.run) runs.insert(found.run->folder);
  }
  std::error_code failed;
  constexpr auto how = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator entry(place, how, failed), end; !failed && entry != end; entry.increment(failed)) {
    const fs::path& path = entry->path();
    const std::string name = path.filename().string();
    std::error_code unknown;
    if (entry->is_directory(unknown)) {
      const bool is_done = runs.contains(path) || examined.contains(path) || is_named_in(places.misnamed, path.string());
      if (is_done || name.starts_with('.') || name.find(".discarded-") != std::string::npos) entry.disable_recursion_pending();
    } else if (has_recording_name(path) && !examined.contains(path)) {
      places.not_examined.insert(path.parent_path());
    }
  }
}

void add_recordings_below(const std::string& place, Places& places);

void add_place(const std::string& place, Places& places) {
  std::error_code unknown;
  if (bags::is_bag(place)) return places.bags.push_back(place);
  if (!fs::is_directory(place, unknown)) return places.found.push_back({place, place, std::nullopt});
  const RunFolder run = run_folder_at(place);
  if (is_there(run.events())) {
    places.found.push_back({place, run.events(), run});
    if (const std::string why = what_is_misnamed(place); is_there(run.info()) && !why.empty()) places.misnamed.push_back(why);
    return;
  }
  add_recordings_below(place, places);
  note_not_examined(place, places);
}

/// The runs in a folder, else the loose recordings in it.
void add_recordings_below(const std::string& place, Places& places) {
  RunsBelow below = look_for_runs(place);
  if (below.runs.empty()) below.runs = runs_of_object(place);
  for (const RunFolder& found : below.runs) places.found.push_back({found.folder.string(), found.events(), found});
  places.misnamed.insert(places.misnamed.end(), below.misnamed.begin(), below.misnamed.end());
  places.unreadable.insert(places.unreadable.end(), below.unreadable.begin(), below.unreadable.end());
  places.without_recording.insert(places.without_recording.end(), below.without_recording.begin(), below.without_recording.end());
  if (!below.runs.empty() || !below.misnamed.empty() || !below.without_recording.empty() || !below.unreadable.empty()) return;
  const std::vector<std::string> loose = loose_recordings_in(place);
  if (loose.empty())
    throw Error(place + ": no recording in it, nor runs below it; expected a recording, a run, or a folder of one of them");
  for (const std::string& recording : loose) add_place(recording, places);
}

/// What the recordings and bags show, and what cannot be read.
struct Findings {
  std::vector<RecordingReport> reports;
  nlohmann::json recordings = nlohmann::json::array(), bags = nlohmann::json::array(), failed = nlohmann::json::array();
  std::string text;
  std::vector<std::string> errors;
  bool sick = false;
};

/// Notes an error of `step` under `name`, so that the others are shown nevertheless.
template <class Step>
void attempt(Findings& findings, const std::string& name, const Step& step) {
  try {
    step();
  } catch (const std::exception& e) {
    findings.errors.push_back(sentence_of(e, name));
    findings.failed.push_back({{"file", name}, {"error", findings.errors.back()}});
  }
}

void note_health(Findings& findings, const std::string& name, const std::vector<std::string>& reasons, bool check) {
  if (reasons.empty() || !check) return;
  findings.sick = true;
  for (const std::string& reason : reasons) spdlog::error("{}: {}", name, reason);
}

Places find_places(const std::vector<std::string>& named, Findings& findings) {
  Places places;
  for (const std::string& place : named) attempt(findings, place, [&] { add_place(place, places); });
  for (const std::string& unreadable : places.unreadable)
    attempt(findings, unreadable.substr(0, unreadable.find(": ")), [&] { throw Error(unreadable); });
  return places;
}

void report_on_recordings(const std::vector<RecordingPlace>& places, const ReportOptions& options, unsigned threads,
                          const ProgressCallback& progress, Findings& findings) {
  for (const RecordingPlace& place : places) {
    attempt(findings, place.name, [&] {
      const RecordingReport& report = findings.reports.emplace_back(examine(place, options, threads, progress));
      findings.recordings.push_back(json_of(report, options));
      note_health(findings, place.name, report.health.reasons, options.check);
    });
  }
  if (findings.reports.size() > 1 && !options.verbose) {
    findings.text = summary_of(findings.reports, options);
  } else {
    for (const RecordingReport& report : findings.reports)
      findings.text += (findings.text.empty() ? "" : "\n") + text_of(report, options);
  }
}

void report_on_bags(const std::vector<std::string>& bags, bool check, const ProgressCallback& progress, Findings& findings) {
  for (const std::string& bag : bags) {
    attempt(findings, bag, [&] {
      const bags::BagContents contents = bags::read_bag_contents(bag, progress);
      findings.bags.push_back(json_of_bag(bag, contents));
      findings.text += (findings.text.empty() ? "" : "\n") + text_of_bag(bag, contents);
      note_health(findings, bag, reasons_of(contents), check);
    });
  }
}

void report_on(const InfoArguments& args, const CommonArguments& common) {
  const ProgressCallback progress = progress_line(common);
  Findings findings;
  const Places places = find_places(args.places, findings);
  for (const std::string& misnamed : places.misnamed) spdlog::warn("{}", misnamed);
  const std::string missing = sentence_on_missing_recordings(places.without_recording);
  if (!missing.empty()) spdlog::warn("{}", missing);
  std::vector<std::string> not_examined;
  for (const fs::path& folder : places.not_examined) not_examined.push_back(folder.string());
  if (!not_examined.empty()) {
    spdlog::warn(
        "not examined, because 'tactile info' looks for DATA/<object>/<run>, or for recordings in the named folder "
        "itself: the recordings in {}",
        fmt::join(not_examined, ", "));
  }
  report_on_recordings(places.found, args.report, common.threads, progress, findings);
  report_on_bags(places.bags, args.report.check, progress, findings);
  if (!findings.recordings.empty() || !findings.bags.empty() || common.json) {
    nlohmann::json without_recording = nlohmann::json::array();
    for (const fs::path& run : places.without_recording) without_recording.push_back(run.string());
    print_result(common,
                 {{"recordings", findings.recordings},
                  {"bags", findings.bags},
                  {"failed", findings.failed},
                  {"misnamed", places.misnamed},
                  {"without_recording", without_recording},
                  {"not_examined", not_examined}},
                 findings.text);
  }
  end_with(findings.errors);
  if (findings.sick || (args.report.check && !(places.misnamed.empty() && missing.empty()))) throw CheckFailed{};
}

}  // namespace

void add_info_command(CLI::App& app) {
  auto args = std::make_shared<InfoArguments>();
  Command command = add_command(app, "info", "Show the contents of recordings: streams, rates, gaps, hot pixels, health",
                                [args](const CommonArguments& common) { report_on(*args, common); });
  command.add_option("files", args->places, "Recordings, ROS bags, runs, folders of runs, or one model")
      .type_name("FILE|RUN")
      .required();
  command.add_option("--stream", args->report.stream, "Show only this event stream, given by id or source")
      .type_name("ID|SOURCE");
  command.add_option("--gap-ms", args->report.gap_ms, "Report gaps without data longer than this [ms]")
      .check(in_range(std::int64_t{1}, std::int64_t{3'600'000}))
      .show_default();
  command.add_flag("--verbose", args->report.verbose, "Show all that is measured of the events, and each of several recordings");
  add_camera_time_option(command, args->report.camera_time);
  command.add_flag("--check", args->report.check,
                   "Check files against their SHA-256, or packets against their checksums; exit with 2 and log why if a run is "
                   "damaged, misnamed or without recording");
}

}  // namespace tactile::cli
