#include "tactile/windows/run_samples.hpp"

#include "tactile/core/json.hpp"

namespace tactile::windows {

std::vector<RunSamples> samples_by_run(const Dataset& dataset) {
  std::vector<RunSamples> runs;
  for (std::uint32_t i = 0; i < dataset.samples().size(); ++i) {
    const std::uint32_t run_index = dataset.samples()[i].run_index;
    if (runs.empty() || runs.back().run_index != run_index) runs.push_back({.run_index = run_index, .first = i, .count = 0});
    ++runs.back().count;
  }
  return runs;
}

std::string source_sha256_of(const Dataset& dataset, const RunSamples& run) {
  nlohmann::json times = nlohmann::json::array();
  for (const Sample& sample : dataset.samples().subspan(run.first, run.count)) times.push_back(us_of(sample.t));
  return hash_of({{"events_sha256", dataset.runs()[run.run_index].events_sha256},
                  {"sensor", {{"width", dataset.sensor().width}, {"height", dataset.sensor().height}}},
                  {"t_us", times}});
}

}  // namespace tactile::windows
