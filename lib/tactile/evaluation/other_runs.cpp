#include "tactile/evaluation/other_runs.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <set>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::evaluation {
namespace {

namespace fs = std::filesystem;

/// Why nothing can be judged by the run; empty if something can.
std::string why_not_judged(const RunFolder& run, const windows::Dataset& dataset, bool include_flagged) {
  try {
    const bool simulated = dataset.simulated();
    if (events::is_simulated(run) != simulated) return simulated ? "it is real, the others are simulated" : "it is simulated";
    const RunTruth truth = read_run_truth(run, include_flagged);
    if (!truth.is_known()) return "it has no labels; 'tactile label' makes them";
    if (!truth.has_truth && truth.run_is_flagged && !include_flagged)
      return "its labels are in doubt as a whole; 'tactile label --confirm' accepts them";
    const events::RecordingReader reader(run.events());
    const events::SensorSize size = dataset.sensor();
    if (events::event_stream(reader).size != size)
      return fmt::format("its sensor is not of {} x {} pixels, as that of the others", size.width, size.height);
  } catch (const Error& error) {
    return sentence_of(error);
  }
  return {};
}

}  // namespace

bool includes_flagged(const windows::Dataset& dataset) {
  return member<bool>(dataset.settings(), "include_flagged", dataset.file().string());
}

OtherRuns other_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> judged, const windows::SplitOptions& split,
                     const std::function<bool(const RunFolder&)>& is_known) {
  const bool include_flagged = includes_flagged(dataset);
  std::set<std::string> objects(split.held_out.begin(), split.held_out.end());
  std::set<fs::path> folders, known;
  for (const std::uint32_t run : judged) {
    objects.insert(dataset.runs()[run].object);
    known.insert(fs::weakly_canonical(dataset.run_folder(run)));
  }
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    const fs::path folder = fs::weakly_canonical(dataset.run_folder(run));
    folders.insert(folder.parent_path().parent_path());
    if (!model::samples_of_runs(dataset, {&run, 1}).empty()) known.insert(folder);
  }
  OtherRuns others;
  for (const fs::path& folder : folders) {
    const RunsBelow below = look_for_runs(folder);
    for (const std::vector<std::string>* sentences : {&below.misnamed, &below.unreadable}) {
      for (const std::string& sentence : *sentences) others.left_out.push_back({"", sentence});
    }
    for (const RunFolder& run : below.runs) {
      const bool is_tested = split.kind == windows::SplitKind::single_run || objects.contains(run.object);
      if (!is_tested || known.contains(fs::weakly_canonical(run.folder))) continue;
      if (const std::string why = why_not_judged(run, dataset, include_flagged); !why.empty()) {
        others.left_out.push_back({run.name(), why});
      } else if (!is_known || !is_known(run)) {
        others.runs.push_back(run);
      }
    }
  }
  return others;
}

OtherRuns other_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> judged,
                     const model::ModelDescription& model) {
  return other_runs(dataset, judged, model.settings.split,
                    [&](const RunFolder& run) { return model::learned_from(model, run.events()); });
}

}  // namespace tactile::evaluation
