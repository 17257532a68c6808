#include "tactile/evaluation/other_runs.hpp"

#include <filesystem>
#include <set>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::evaluation {
namespace {

namespace fs = std::filesystem;

/// Why nothing can be judged by the run; empty if something can.
std::string why_not_judged(const RunFolder& run, bool simulated, bool include_flagged) {
  try {
    if (events::is_simulated(run) != simulated) return simulated ? "it is real, the others are simulated" : "it is simulated";
    const RunTruth truth = read_run_truth(run, include_flagged);
    if (!truth.is_known()) return "it has no labels; 'tactile label' makes them";
    if (!truth.has_truth && truth.run_is_flagged && !include_flagged)
      return "its labels are in doubt as a whole; 'tactile label --confirm' accepts them";
  } catch (const Error& error) {
    return sentence_of(error);
  }
  return {};
}

}  // namespace

bool includes_flagged(const windows::Dataset& dataset) {
  return member<bool>(dataset.settings(), "include_flagged", dataset.file().string());
}

OtherRuns other_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> judged,
                     const std::function<bool(const RunFolder&)>& is_known) {
  const bool include_flagged = includes_flagged(dataset);
  std::set<std::string> objects;
  std::set<fs::path> folders, known;
  for (const std::uint32_t run : judged) {
    objects.insert(dataset.runs()[run].object);
    const fs::path folder = fs::weakly_canonical(dataset.run_folder(run));
    folders.insert(folder.parent_path().parent_path());
    known.insert(folder);
  }
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    if (!model::samples_of_runs(dataset, {&run, 1}).empty()) known.insert(fs::weakly_canonical(dataset.run_folder(run)));
  }
  OtherRuns others;
  for (const fs::path& folder : folders) {
    const RunsBelow below = look_for_runs(folder);
    for (const std::vector<std::string>* sentences : {&below.misnamed, &below.unreadable}) {
      for (const std::string& sentence : *sentences) others.left_out.push_back({folder.filename().string(), sentence});
    }
    for (const RunFolder& run : below.runs) {
      if (!objects.contains(run.object) || known.contains(fs::weakly_canonical(run.folder))) continue;
      if (is_known && is_known(run)) continue;
      if (const std::string why = why_not_judged(run, dataset.simulated(), include_flagged); !why.empty()) {
        others.left_out.push_back({run.name(), why});
      } else {
        others.runs.push_back(run);
      }
    }
  }
  return others;
}

}  // namespace tactile::evaluation
