#include "tactile/experiments/study/sample_confusions.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/model/training/open_classifier.hpp"

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
                                                      std::span<const std::string> runs, std::size_t training) {
  std::vector<results::RunConfusion> chosen;
  for (const std::string& run : runs) {
    const auto found =
        std::find_if(confusions.begin(), confusions.end(), [&](const NamedConfusion& one) { return one.run == run; });
    if (found == confusions.end()) throw Error(run + ": no confusion of its samples; expected the model to be judged on it");
    chosen.push_back({{found->object, run.substr(run.find('/') + 1), training}, found->confusion});
  }
  return chosen;
}

void judge_samples(const windows::Dataset& dataset, const SampleJudgement& judgement, const std::filesystem::path& file,
                   const ProgressCallback& progress) {
  const model::Classifier classifier = model::open_classifier(judgement.bundle, judgement.threads, judgement.engine);
  const auto confusions =
      evaluation::sample_confusions(dataset, classifier, judgement.runs, {.threads = judgement.threads}, progress);
  const std::vector<std::string> names = names_of(dataset, judgement.runs);
  std::vector<NamedConfusion> named;
  for (std::size_t i = 0; i < names.size(); ++i) named.push_back({names[i], confusions[i].object, confusions[i].confusion});
  write_confusions(file, named);
}

}  // namespace tactile::study
