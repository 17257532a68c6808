#include "tactile/trade/measured_again.hpp"

#include <vector>

#include "tactile/evaluation/evaluation.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/study/study_json.hpp"
#include "tactile/study/study_runs.hpp"
#include "tactile/trade/full_runs.hpp"

namespace tactile {

nlohmann::json measure_again(const TradePoint& point, const TradePoint& usual, const Dataset& dataset, const TestedRuns& runs,
                             const TickTimesOptions& timing, unsigned threads, const ProgressCallback& progress) {
  const TradeSetting& setting = point.setting;
  const TradeNetwork& network = point.networks.front();
  const auto gate = gate_of(setting, network);
  const std::vector<TimedWay> ways{way_of(usual), way_of(point)};
  const auto times = time_ticks(ways, runs.recordings, timing, progress);
  std::vector<FullRun> said;
  {
    const Classifier classifier = open_classifier(network.bundle.folder, 1, setting.engine, {.precision = setting.precision});
    said = classify_full_runs(dataset, runs.indexes, classifier, setting.rendering.tick, threads, progress);
  }
  std::vector<TradedRun> outcomes;
  for (std::size_t i = 0; i < runs.indexes.size(); ++i) {
    outcomes.push_back(outcome_of(runs.judged[i], said[i], verdicts_of(said[i], gate, setting.confirmation)));
    add_times(outcomes.back(), times[1].at(i), gate);
  }
  const TradeResult counted = result_of(outcomes);
  nlohmann::json result = counted;
  result["by"] = "trade";
  // `eval` judges at the network's own ticks alone, where samples lie.
  if (setting.rendering.tick == network.settings.rendering.tick) {
    const Classifier classifier =
        open_classifier(network.bundle.folder, threads, setting.engine, {.precision = setting.precision});
    const Evaluation evaluation =
        evaluate(dataset, classifier, runs.indexes,
                 {.confirmation = setting.confirmation, .gate = setting.gate, .threads = threads}, progress);
    result["by"] = "eval";
    result["accuracy"] = evaluation.accuracy.mean;
    result["false_alarms_per_min"] = evaluation.network.false_alarms.per_min;
  }
  result["model"] = network.name();
  result["runs"] = names_of(dataset, runs.indexes);
  return result;
}

}  // namespace tactile
