#include "tactile/study/sample_verdicts.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile {

void write_verdicts(const std::filesystem::path& file, std::span<const RunVerdicts> verdicts) {
  nlohmann::json runs = nlohmann::json::array();
  for (const RunVerdicts& run : verdicts)
    runs.push_back({{"run", run.run}, {"object", run.object}, {"confusion", run.confusion}});
  write_json(file, {{"runs", runs}});
}

std::vector<RunVerdicts> read_verdicts(const std::filesystem::path& file) {
  const nlohmann::json json = read_json(file);
  std::vector<RunVerdicts> verdicts;
  for (const JsonView& run : JsonView(json, file.string(), MissingMember::is_error)["runs"].items())
    verdicts.push_back({run["run"].text(), run["object"].text(), run["confusion"].get<Confusion>()});
  return verdicts;
}

std::vector<RunConfusion> verdicts_on(std::span<const RunVerdicts> verdicts, std::span<const std::string> runs) {
  std::vector<RunConfusion> confusions;
  for (const std::string& run : runs) {
    const auto found = std::find_if(verdicts.begin(), verdicts.end(), [&](const RunVerdicts& one) { return one.run == run; });
    if (found == verdicts.end()) throw Error(run + ": no verdicts on its samples; expected the model to have been judged on it");
    confusions.push_back({found->object, found->confusion});
  }
  return confusions;
}

std::vector<RunConfusion> together(std::span<const std::vector<RunConfusion>> models) {
  if (models.empty()) return {};
  std::vector<RunConfusion> sum = models.front();
  for (const std::vector<RunConfusion>& model : models.subspan(1)) {
    if (model.size() != sum.size()) throw Error("verdicts of models on different runs; expected the same runs of each");
    for (std::size_t i = 0; i < sum.size(); ++i) {
      if (model[i].object != sum[i].object) throw Error("verdicts of models on different runs; expected the same runs of each");
      sum[i].confusion += model[i].confusion;
    }
  }
  return sum;
}

}  // namespace tactile
