#include "tactile/evaluation/flagged_runs.hpp"

#include <set>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::evaluation {
namespace {

namespace fs = std::filesystem;

bool is_flagged(const RunFolder& run) {
  try {
    return fs::exists(run.labels()) && labels::read_labels(run.labels()).run_is_flagged();
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::vector<RunFolder> flagged_runs_beside(const windows::Dataset& dataset, std::span<const std::uint32_t> judged,
                                           const model::ModelDescription& model) {
  std::set<std::string> objects;
  std::set<fs::path> folders, known;
  for (const std::uint32_t run : judged) {
    objects.insert(dataset.runs()[run].object);
    folders.insert(fs::weakly_canonical(dataset.run_folder(run)).parent_path().parent_path());
  }
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) known.insert(fs::weakly_canonical(dataset.run_folder(run)));
  std::vector<RunFolder> flagged;
  for (const fs::path& folder : folders) {
    for (const RunFolder& run : look_for_runs(folder).runs) {
      if (!objects.contains(run.object) || known.contains(fs::weakly_canonical(run.folder)) || !is_flagged(run)) continue;
      if (events::is_simulated(run) != dataset.simulated()) continue;
      if (!model::learned_from(model, run.events())) flagged.push_back(run);
    }
  }
  return flagged;
}

}  // namespace tactile::evaluation
