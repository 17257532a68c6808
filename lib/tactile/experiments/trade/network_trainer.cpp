#include "tactile/experiments/trade/network_trainer.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/training_step.hpp"
#include "tactile/model/training/dataset_bundle.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::trade {

double longest_s(const experiments::StepRunner& runner, const std::string& begin) {
  double longest = 0;
  for (const results::StepRecord& record : runner.records()) {
    if (record.name.starts_with(begin)) longest = std::max(longest, record.seconds);
  }
  return longest;
}

experiments::Step NetworkTrainer::step_for(const TradeNetwork& network) const {
  const TradeOptions& options = plan_.options;
  return experiments::training_step(plan_.dataset, network.settings, network.bundle,
                                    {options.data, options.models, experiments::from_folder(options.models, options.out)});
}

bool NetworkTrainer::is_trained(const TradeNetwork& network) const {
  return model::state_of(network.bundle, plan_.dataset, network.settings) == model::BundleState::unchanged;
}

void NetworkTrainer::train(const std::vector<TradeNetwork>& networks, double reserve_s, double each_s) {
  std::vector<experiments::Step> kept;
  std::vector<const TradeNetwork*> due;
  std::set<std::string> seen = trained_;
  for (const TradeNetwork& network : networks) {
    if (!seen.insert(network.name()).second) continue;
    if (is_trained(network)) {
      kept.push_back(step_for(network));
      trained_.insert(network.name());
    } else {
      due.push_back(&network);
    }
  }
  runner_.run_side_by_side(kept);
  const bool few_at_once = plan_.options.budget_minutes && !plan_.options.slurm;
  const std::size_t at_once = few_at_once ? plan_.options.threads : std::max<std::size_t>(due.size(), 1);
  for (std::size_t begin = 0; begin < due.size(); begin += at_once) {
    const std::size_t end = std::min(begin + at_once, due.size());
    if (!budget_.allows(longest_s(runner_, "train-") + reserve_s + each_s * static_cast<double>(end))) return;
    std::vector<experiments::Step> batch;
    for (std::size_t i = begin; i < end; ++i) {
      batch.push_back(step_for(*due[i]));
      batch.back().description = fmt::format("training {} of {}: {}", i + 1, due.size(), text_of(plan_, *due[i]));
    }
    const bool finished = budget_.finishes([&] { runner_.run_side_by_side(batch); });
    for (std::size_t i = begin; i < end; ++i) {
      if (finished || is_trained(*due[i])) trained_.insert(due[i]->name());
    }
    if (!finished) return;
  }
}

std::vector<TradeNetwork> NetworkTrainer::trained_for(const TradeSetting& setting) const {
  std::vector<TradeNetwork> networks;
  for (unsigned training = 0; training < plan_.options.trainings; ++training) {
    networks.push_back(network_of(plan_, setting, training));
    if (trained_.contains(networks.back().name())) continue;
    networks.pop_back();
    break;
  }
  return networks;
}

std::string NetworkTrainer::unfinished() const {
  if (!budget_.ended()) return {};
  const double minutes = plan_.options.budget_minutes.value_or(0);
  if (runner_.done_now() > 0) {
    return fmt::format(
        "The budget of {:g} minutes ended the work. Run the same command again: it keeps all that is done, and resumes.",
        minutes);
  }
  const double training = longest_s(runner_, "train-") / 60;
  return fmt::format(
      "The budget of {:g} minutes ended the work, and is too short for its next step{}. Run the same command with a larger "
      "--budget-minutes: it keeps all that is done, and resumes.",
      minutes, training > 0 ? fmt::format(" (a training takes {:.2g} minutes)", training) : std::string());
}

}  // namespace tactile::trade
