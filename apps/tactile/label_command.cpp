#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <functional>
#include <mutex>
#include <opencv2/core/types.hpp>

#include "command.hpp"
#include "commands.hpp"
#include "label_tables.hpp"
#include "labelled_run.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/labels/label_run.hpp"
#include "tactile/report/run_picture.hpp"
#include "truth_tables.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

struct LabelArguments {
  std::vector<std::string> places{"data"};
  bool compare_truth = false;
  bool force = false;
  bool summary = false;
  bool strict = false;
  bool no_pictures = false;
  std::string roi;
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

CLI::Validator is_region() {
  return CLI::Validator(
      [](std::string& text) {
        return region_in(text) ? std::string()
                               : fmt::format(
                                     "'{}' is no part of a picture; expected x,y,width,height in whole pixels, such as "
                                     "100,50,640,480",
                                     text);
      },
      "x,y,width,height [px]");
}

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

bool somebody_confirmed(const RunFolder& run) {
  if (!fs::exists(run.labels())) return false;
  const Labels labels = read_labels(run.labels());
  return std::any_of(labels.intervals.begin(), labels.intervals.end(),
                     [](const LabelledInterval& interval) { return interval.confirmed; }) ||
         std::any_of(labels.flags.begin(), labels.flags.end(), [](const LabelFlag& flag) { return flag.confirmed; });
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

/// What came of the runs, told and checked.
struct Outcome {
  std::vector<LabelledRun> labelled;
  std::vector<std::string> kept;      ///< names of runs whose labels were left as they were
  std::vector<std::string> failures;  ///< errors, one a run
};

/// Draws what was labelled beside the labels. Without gnuplot all runs go without, for the labels are what counts.
class Pictures {
 public:
  explicit Pictures(bool wanted) : wanted_(wanted) {}

  void draw(const LabelledRun& labelled) {
    if (!wanted_) return;
    try {
      draw_label_picture(picture_of(labelled.run, labelled.labels), labelled.run.folder / "labels.png");
    } catch (const Error& e) {
      const std::scoped_lock lock(guard_);
      if (failures_.empty()) first_ = labelled.run.name();
      failures_.emplace_back(e.what());
    }
  }

  void tell() const {
    if (failures_.empty()) return;
    spdlog::warn("{} not drawn (--no-pictures leaves them out): {}",
                 failures_.size() == 1 ? first_ + "/labels.png was" : fmt::format("{} pictures were", failures_.size()),
                 failures_.front());
  }

 private:
  bool wanted_;
  std::mutex guard_;
  std::vector<std::string> failures_;
  std::string first_;
};

/// Tells one run after the other to `use`, on several threads; one run that cannot be read does not keep it from the others.
Outcome for_runs(const CommonArguments& common, const std::vector<RunFolder>& runs,
                 const std::function<LabelledRun(const RunFolder&, bool& kept)>& use) {
  const ProgressCallback progress = progress_line(common);
  std::vector<std::optional<LabelledRun>> labelled(runs.size());
  std::vector<std::string> failures(runs.size());
  std::vector<char> kept(runs.size());
  std::mutex guard;
  std::size_t done = 0;
  parallel_for(runs.size(), common.threads, [&](std::size_t i) {
    try {
      bool is_kept = false;
      labelled[i] = use(runs[i], is_kept);
      kept[i] = is_kept ? 1 : 0;
    } catch (const std::exception& e) {
      failures[i] = e.what();
    }
    const std::scoped_lock lock(guard);
    tell(progress, ++done, runs.size(), runs[i].name());
  });
  Outcome outcome;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (kept[i] != 0) outcome.kept.push_back(runs[i].name());
    if (labelled[i]) outcome.labelled.push_back(std::move(*labelled[i]));
    if (!failures[i].empty()) outcome.failures.push_back(std::move(failures[i]));
  }
  return outcome;
}

Outcome label_runs(const CommonArguments& common, const LabelArguments& arguments) {
  Pictures pictures(!arguments.no_pictures);
  Outcome outcome = for_runs(common, runs_in(arguments.places), [&](const RunFolder& run, bool& kept) {
    kept = !arguments.force && somebody_confirmed(run);
    LabelledRun labelled{run, kept ? read_labels(run.labels()) : label_run(run), first_event_of(run)};
    if (!kept) write_labels(run.labels(), labelled.labels);
    pictures.draw(labelled);
    return labelled;
  });
  pictures.tell();
  if (!outcome.kept.empty())
    spdlog::warn("kept as a person confirmed them, --force replaces them: {}", fmt::join(outcome.kept, ", "));
  const std::size_t count = outcome.labelled.size();
  spdlog::info("{} labelled, {} of them flagged", count == 1 ? "1 run" : fmt::format("{} runs", count),
               std::count_if(outcome.labelled.begin(), outcome.labelled.end(), is_flagged));
  return outcome;
}

/// Of the labels that are there.
Outcome read_runs(const CommonArguments& common, const LabelArguments& arguments) {
  std::vector<RunFolder> runs = runs_in(arguments.places);
  std::vector<std::string> without;
  std::erase_if(runs, [&](const RunFolder& run) {
    if (fs::exists(run.labels())) return false;
    without.push_back(run.name());
    return true;
  });
  if (runs.empty()) throw Error("--summary: none of the runs has labels; expected 'tactile label' to have made them");
  if (!without.empty()) spdlog::warn("without labels, and left out: {}", fmt::join(without, ", "));
  return for_runs(common, runs, [](const RunFolder& run, bool&) {
    return LabelledRun{run, read_labels(run.labels()), first_event_of(run)};
  });
}

void run_label(const CommonArguments& common, const LabelArguments& arguments) {
  const Outcome outcome = arguments.summary ? read_runs(common, arguments) : label_runs(common, arguments);
  const std::vector<LabelledRun>& labelled = outcome.labelled;
  nlohmann::json json = {{"runs", runs_json(labelled)}, {"kept", outcome.kept}, {"failed", outcome.failures}};
  std::string text = labelled.empty() ? "" : runs_table(labelled);
  if (arguments.summary && !labelled.empty()) {
    json["objects"] = objects_json(labelled);
    json["differences"] = differences_json(labelled);
    text += "\n" + objects_table(labelled) + "\n" + differences_table(labelled);
  }
  if (arguments.compare_truth && !labelled.empty()) {
    const TruthTables truth = compare_all(labelled);
    json["truth"] = truth.json;
    text += truth.text;
  }
  print_result(common, json, text);
  for (std::size_t i = 0; i + 1 < outcome.failures.size(); ++i) spdlog::error("{}", outcome.failures[i]);
  if (!outcome.failures.empty()) throw Error(outcome.failures.back());
  if (arguments.strict && std::any_of(labelled.begin(), labelled.end(), is_flagged)) throw CheckFailed{};
}

}  // namespace

void add_label_command(CLI::App& app) {
  auto arguments = std::make_shared<LabelArguments>();
  auto* command = add_command(app, "label", "Align the clocks of runs, and find when press and slip begin and end",
                              [arguments](const CommonArguments& common) { run_label(common, *arguments); });
  command->add_option("data", arguments->places, "Folders of runs, or single runs")->capture_default_str();
  command->add_flag("--compare-truth", arguments->compare_truth,
                    "Print errors against truth.json, where simulated runs have one");
  auto* summary = command->add_flag("--summary", arguments->summary,
                                    "Tables of the labels that are there, and of how far their sources differ; labels nothing");
  command->add_flag("--strict", arguments->strict, "End with 2 if a run is flagged");
  command->add_flag("--no-pictures", arguments->no_pictures, "Draw no labels.png")->excludes(summary);
  command->add_option("--roi", arguments->roi, "Part of the film in which press and slip are seen")
      ->type_name("X,Y,W,H")
      ->check(is_region())
      ->excludes(summary);
  command->add_flag("--force", arguments->force, "Replace labels that a person confirmed, too")->excludes(summary);
}

}  // namespace tactile
