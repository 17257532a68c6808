#include "made_up_results.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::study {
namespace {

constexpr int samples_of_run = 90, touches_of_run = 5;
constexpr double added_logit = 0.3, tick_ms = 2, usual_ticks = 1.6, longest_ms = 100;
constexpr double best_levels[] = {0.93, 0.94, 0.945, 0.95, 0.95};

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

/// E f(deviation * z), z standard normal.
template <class Function>
double expected(double deviation, Function f) {
  constexpr int points = 4001;
  double sum = 0, weights = 0;
  for (int i = 0; i < points; ++i) {
    const double z = -8 + 16.0 * i / (points - 1), weight = std::exp(-z * z / 2);
    sum += weight * f(deviation * z);
    weights += weight;
  }
  return sum / weights;
}

double expected_accuracy(double centre, double deviation) {
  return expected(deviation, [&](double x) { return logistic(centre + x); });
}

double delay_of(double logarithm) { return tick_ms * (1 + std::floor(usual_ticks * std::exp(logarithm))); }

/// Where the effects are centred if the expected accuracy is `level`.
double centre_of(double level, double deviation) {
  thread_local std::map<std::pair<double, double>, double> known;
  if (const auto found = known.find({level, deviation}); found != known.end()) return found->second;
  double low = -20, high = 20;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (expected_accuracy(middle, deviation) < level ? low : high) = middle;
  }
  return known[{level, deviation}] = low;
}

/// The effects that settings share: those of objects and runs.
struct Things {
  std::vector<double> objects;
  std::vector<std::vector<double>> runs;
};

Things things_of(const Layout& layout, const Effects& effects, Random& random) {
  Things things;
  for (std::size_t object = 0; object < layout.objects; ++object) {
    things.objects.push_back(effects.object * random.normal());
    things.runs.emplace_back();
    for (std::size_t run = 0; run < layout.runs; ++run) things.runs.back().push_back(effects.run * random.normal());
  }
  return things;
}

/// The sum of all effects, of each cell.
std::vector<double> sums_of_effects(const evaluation::CrossedResults& objects, const Layout& layout, const Things& things,
                                    const Effects& effects, Random& random) {
  std::vector<double> sums;
  std::vector<double> of_training(layout.trainings);
  for (double& effect : of_training) effect = effects.training * random.normal();
  for (std::size_t object = 0; object < objects.size(); ++object) {
    std::vector<double> of_both(layout.trainings);
    for (double& effect : of_both) effect = effects.both * random.normal();
    for (const evaluation::CrossedCell& cell : objects[object])
      sums.push_back(of_training[cell.training] + things.objects[object] + of_both[cell.training] +
                     things.runs[object][cell.run] + effects.single * random.normal());
  }
  return sums;
}

evaluation::CrossedResults cells_of(const Layout& layout) {
  evaluation::CrossedResults objects(layout.objects);
  std::size_t index = 0;
  for (auto& object : objects) {
    for (std::size_t training = 0; training < layout.trainings; ++training) {
      for (std::size_t run = 0; run < layout.runs; ++run) {
        if (layout.judged(training, run)) object.push_back({training, run, index++});
      }
    }
  }
  return objects;
}

double measured_share(double logit, int of, Random& random) {
  const double p = logistic(logit);
  int count = 0;
  for (int i = 0; i < of; ++i) count += random.uniform() < p ? 1 : 0;
  return static_cast<double>(count) / of;
}

std::vector<double> of_each(std::vector<double> sums, const std::function<double(double)>& result) {
  for (double& sum : sums) sum = result(sum);
  return sums;
}

double mean_over_objects_of(const std::vector<double>& values, const evaluation::RunsByObject& lists) {
  double sum = 0;
  for (const auto& list : lists) {
    double of_object = 0;
    for (const std::size_t index : list) of_object += values[index];
    sum += of_object / static_cast<double>(list.size());
  }
  return sum / static_cast<double>(lists.size());
}

evaluation::Statistic mean_of(std::vector<double> values) {
  return [values = std::move(values)](const evaluation::RunsByObject& lists) -> std::optional<double> {
    return mean_over_objects_of(values, lists);
  };
}

evaluation::Statistic quantile_of(std::vector<double> values, double q) {
  return [values = std::move(values), q](const evaluation::RunsByObject& lists) -> std::optional<double> {
    std::vector<double> all;
    for (const auto& list : lists) {
      for (const std::size_t index : list) all.push_back(values[index]);
    }
    return nearest_rank_quantile(all, q);
  };
}

/// Alarms per minute, of sums of effects on their logarithm.
evaluation::Statistic rate_of_alarms(double per_min, std::vector<double> counts, Random& random) {
  std::vector<double> minutes;
  for (double& count : counts) {
    minutes.push_back(random.uniform(0.05, 0.1));
    count = static_cast<double>(random.poisson(per_min * minutes.back() * std::exp(count)));
  }
  return
      [counts = std::move(counts), minutes = std::move(minutes)](const evaluation::RunsByObject& lists) -> std::optional<double> {
        double count = 0, time = 0;
        for (const auto& list : lists) {
          for (const std::size_t index : list) {
            count += counts[index];
            time += minutes[index];
          }
        }
        return count / time;
      };
}

double true_quantile_of_delays(double q, double deviation) {
  for (double ticks = 1;; ++ticks) {
    if (expected(deviation, [&](double x) { return delay_of(x) <= tick_ms * ticks ? 1.0 : 0.0; }) >= q) return tick_ms * ticks;
  }
}

/// How much better the best of four settings is than the first.
evaluation::Statistic gain_of_best(std::vector<std::vector<double>> settings) {
  return [settings = std::move(settings)](const evaluation::RunsByObject& lists) -> std::optional<double> {
    double best = 0;
    for (std::size_t i = 1; i < settings.size(); ++i) best = std::max(best, mean_over_objects_of(settings[i], lists));
    return best - mean_over_objects_of(settings[0], lists);
  };
}

}  // namespace

double Effects::together() const {
  return std::sqrt(training * training + object * object + both * both + run * run + single * single);
}

bool Layout::judged(std::size_t training, std::size_t run) const {
  return !runs_of_choice || (run + runs - training % runs) % runs > *runs_of_choice;
}

std::string Layout::in_words() const {
  const auto counted = [](std::size_t count, const char* what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
  };
  return fmt::format("{}{}, {}{}", objects > 1 ? counted(objects, "object") + " x " : "", counted(runs, "run"),
                     counted(trainings, "training"),
                     !runs_of_choice ? "" : fmt::format(", each judged on {}", runs - 1 - *runs_of_choice));
}

Trial draw(const Scenario& scenario, Random& random) {
  const Layout& layout = scenario.layout;
  Effects effects = scenario.effects;
  if (layout.objects == 1) effects.object = 0;
  if (layout.trainings == 1) effects.training = 0;
  if (layout.trainings == 1 && layout.objects == 1) effects.both = 0;
  const double deviation = effects.together();
  Trial trial{cells_of(layout), {}, {}, 0};
  const Things things = things_of(layout, effects, random);
  const auto sums = [&] { return sums_of_effects(trial.objects, layout, things, effects, random); };
  const auto accuracies = [&](double centre, int of = samples_of_run) {
    return of_each(sums(), [&](double sum) { return measured_share(centre + sum, of, random); });
  };
  const double inf = std::numeric_limits<double>::infinity();
  switch (scenario.quantity) {
    case Quantity::accuracy:
      trial = {
          trial.objects, mean_of(accuracies(centre_of(scenario.level, deviation))), {0, 1, 1.0 / samples_of_run}, scenario.level};
      break;
    case Quantity::missed:
      trial = {trial.objects,
               mean_of(accuracies(centre_of(scenario.level, deviation), touches_of_run)),
               {0, 1, 1.0 / touches_of_run},
               scenario.level};
      break;
    case Quantity::difference: {
      const double centre = centre_of(scenario.level, deviation);
      std::vector<double> values = accuracies(centre + added_logit);
      const std::vector<double> others = accuracies(centre);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] -= others[i];
      trial.statistic = mean_of(std::move(values));
      trial.range = {-1, 1, 1.0 / samples_of_run};
      trial.truth = expected_accuracy(centre + added_logit, deviation) - scenario.level;
      break;
    }
    case Quantity::best_of_five: {
      std::vector<std::vector<double>> settings;
      for (const double level : best_levels) settings.push_back(accuracies(centre_of(level, deviation)));
      trial.statistic = gain_of_best(std::move(settings));
      trial.range = {-1, 1, 1.0 / samples_of_run};
      trial.truth = best_levels[4] - best_levels[0];
      break;
    }
    case Quantity::mean_delay:
      trial = {trial.objects, mean_of(of_each(sums(), delay_of)), {0, inf, tick_ms}, expected(deviation, delay_of)};
      break;
    case Quantity::quantile_of_delays:
      trial = {trial.objects,
               quantile_of(of_each(sums(), [](double x) { return std::min(delay_of(x), longest_ms); }), scenario.level),
               {0, longest_ms, tick_ms},
               true_quantile_of_delays(scenario.level, deviation)};
      break;
    case Quantity::rate:
      trial.statistic = rate_of_alarms(scenario.level, sums(), random);
      trial.range = {0, inf, 1 / 0.075};
      trial.truth = scenario.level * std::exp(deviation * deviation / 2);
      break;
  }
  return trial;
}

}  // namespace tactile::study
