#include "tactile/experiments/study/sample_confusions.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::study {

void write_confusions(const std::filesystem::path& file, std::span<const NamedConfusion> confusions) {
  nlohmann::json runs = nlohmann::json::array();
  for (const NamedConfusion& run : confusions)
    runs.push_back({{"run", run.run}, {"object", run.object}, {"confusion", run.confusion}});
  write_json(file, {{"runs", runs}});
}

std::vector<NamedConfusion> read_confusions(const std::filesystem::path& file) {
  const nlohmann::json json = read_json(file);
  std::vector<NamedConfusion> confusions;
  for (const results::JsonView& run : results::JsonView(json, file.string(), results::MissingMember::is_error)["runs"].items())
    confusions.push_back({run["run"].text(), run["object"].text(), run["confusion"].get<results::Confusion>()});
  return confusions;
}

std::vector<results::RunConfusion> confusions_of_runs(std::span<const NamedConfusion> confusions,
                                                      std::span<const std::string> runs) {
  std::vector<results::RunConfusion> chosen;
  for (const std::string& run : runs) {
    const auto found =
        std::find_if(confusions.begin(), confusions.end(), [&](const NamedConfusion& one) { return one.run == run; });
    if (found == confusions.end()) throw Error(run + ": no confusion of its samples; expected the model to be judged on it");
    chosen.push_back({{found->object, run.substr(run.find('/') + 1), 0}, found->confusion});
  }
  return chosen;
}

std::vector<results::RunConfusion> sum_over_models(std::span<const std::vector<results::RunConfusion>> models) {
  if (models.empty()) return {};
  std::vector<results::RunConfusion> sum = models.front();
  for (const std::vector<results::RunConfusion>& model : models.subspan(1)) {
    const bool same_runs =
        std::equal(model.begin(), model.end(), sum.begin(), sum.end(),
                   [](const results::RunConfusion& a, const results::RunConfusion& b) { return a.object == b.object; });
    if (!same_runs) throw Error("confusions of models on different runs; expected the same runs for each");
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i].confusion += model[i].confusion;
  }
  return sum;
}

}  // namespace tactile::study
