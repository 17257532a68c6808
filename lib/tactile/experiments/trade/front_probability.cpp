#include "tactile/experiments/trade/front_probability.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "tactile/core/infinite.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/evaluation/run_figures.hpp"
#include "tactile/experiments/trade/pareto_front.hpp"

namespace tactile::trade {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

using Weights = std::vector<std::uint32_t>;

/// What is drawn once for all candidates: numbers in [0, 1), from which each one takes those of its trainings and runs.
struct Draw {
  std::vector<double> trainings;
  std::vector<std::size_t> objects;
  std::vector<std::vector<double>> runs;  ///< of each of `objects`
};

Draw drawn(std::uint64_t seed, std::size_t objects, std::size_t most_trainings, std::size_t most_runs) {
  Random random(seed);
  Draw draw;
  for (std::size_t i = 0; i < most_trainings; ++i) draw.trainings.push_back(random.uniform());
  for (std::size_t i = 0; i < objects; ++i) {
    draw.objects.push_back(random.below(objects));
    draw.runs.emplace_back();
    for (std::size_t run = 0; run < most_runs; ++run) draw.runs.back().push_back(random.uniform());
  }
  return draw;
}

/// How often each of `count` things is drawn by the first `count` numbers.
Weights taken(std::span<const double> numbers, std::size_t count) {
  Weights weights(count, 0);
  for (std::size_t i = 0; i < count; ++i) ++weights[static_cast<std::size_t>(numbers[i] * static_cast<double>(count))];
  return weights;
}

/// Results of a candidate by object, with the numbers of trainings and runs that occur.
struct Cells {
  std::vector<evaluation::CrossedObject> objects;  ///< in the order of all names
  std::vector<std::size_t> runs;                   ///< number of runs of each object
  std::size_t trainings = 1;
};

template <class Result>
Cells cells_of(std::span<const Result> results, const std::set<std::string>& names) {
  auto by_object = evaluation::results_by_object(results, [](const Result&) { return true; });
  Cells cells;
  for (const std::string& name : names) {
    cells.objects.push_back(by_object[name]);
    std::set<std::size_t> runs;
    for (const evaluation::CrossedCell& cell : cells.objects.back()) {
      runs.insert(cell.run);
      cells.trainings = std::max(cells.trainings, cell.training + 1);
    }
    cells.runs.push_back(runs.size());
  }
  return cells;
}

/// Calls `use` with the weights of all results for each drawn object.
template <class Use>
void for_drawn_objects(const Cells& cells, const Draw& draw, std::size_t results, Use use) {
  const Weights trainings = taken(draw.trainings, cells.trainings);
  for (std::size_t i = 0; i < draw.objects.size(); ++i) {
    const std::size_t object = draw.objects[i];
    const Weights runs = taken(draw.runs[i], cells.runs[object]);
    Weights weights(results, 0);
    for (const evaluation::CrossedCell& cell : cells.objects[object])
      weights[cell.index] += trainings[cell.training] * runs[cell.run];
    use(weights);
  }
}

/// A candidate, prepared for many draws.
class Drawable {
 public:
  Drawable(const FrontCandidate& candidate, const std::set<std::string>& names)
      : candidate_(candidate),
        cells_(cells_of<results::Cell>(candidate.runs, names)),
        timed_(cells_of<TimedRun>(candidate.timed, names)),
        times_(candidate.timed) {
    const Weights all(candidate.timed.size(), 1);
    computing_ms_ = times_.of(all, 0.5).value_or(unknown) / 1000;
    for (std::size_t run = 0; run < candidate.runs.size(); ++run) {
      const results::Cell& cell = candidate.runs[run];
      for (const results::TouchOutcome& touch : cell.touches) {
        if (touch.outcome == results::DetectionOutcome::detected) delays_.push_back({cell.delay_ms(touch), run});
      }
    }
    std::sort(delays_.begin(), delays_.end(), [](const Delay& a, const Delay& b) { return a.ms < b.ms; });
  }

  results::TradeResult of(const Draw& draw) const {
    results::TradeResult figures;
    Weights all(candidate_.runs.size(), 0), timed(candidate_.timed.size(), 0);
    double accuracies = 0, objects = 0;
    for_drawn_objects(cells_, draw, all.size(), [&](const Weights& weights) {
      double right = 0, samples = 0;
      for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] == 0) continue;
        all[i] += weights[i];
        const results::Confusion& confusion = candidate_.runs[i].samples;
        samples += weights[i] * static_cast<double>(confusion.samples());
        right += weights[i] * static_cast<double>(confusion.correct());
      }
      if (samples > 0) accuracies += right / samples, ++objects;
    });
    if (objects > 0) figures.accuracy.value = accuracies / objects;
    for_drawn_objects(timed_, draw, timed.size(), [&](const Weights& weights) {
      for (std::size_t i = 0; i < weights.size(); ++i) timed[i] += weights[i];
    });
    figures.us_p99.value = times_.of(timed, 0.99).value_or(unknown);
    add_delays(all, figures);
    double alarms = 0, outside_s = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      alarms += all[i] * static_cast<double>(candidate_.runs[i].alarm_count());
      outside_s += all[i] * candidate_.runs[i].outside_s;
    }
    figures.whole_runs.alarms_per_min.value = outside_s > 0 ? 60 * alarms / outside_s : unknown;
    return figures;
  }

  std::size_t trainings() const { return cells_.trainings; }
  std::size_t most_runs() const {
    return std::max(*std::max_element(cells_.runs.begin(), cells_.runs.end()),
                    *std::max_element(timed_.runs.begin(), timed_.runs.end()));
  }

 private:
  struct Delay {
    double ms;
    std::size_t run;
  };

  void add_delays(const Weights& weights, results::TradeResult& figures) const {
    std::uint64_t total = 0, missed = 0, passed = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const std::vector<results::TouchOutcome>& touches = candidate_.runs[i].touches;
      total += weights[i] * touches.size();
      missed += weights[i] * static_cast<std::uint64_t>(std::count_if(touches.begin(), touches.end(), [](const auto& touch) {
                  return touch.outcome != results::DetectionOutcome::detected;
                }));
    }
    if (total == 0) return;
    figures.whole_runs.missed.value = static_cast<double>(missed) / static_cast<double>(total);
    const auto half = std::find_if(delays_.begin(), delays_.end(), [&](const Delay& delay) {
      passed += weights[delay.run];
      return 2 * passed >= total;
    });
    if (half != delays_.end()) {
      figures.whole_runs.median_ms.ms.value = half->ms + computing_ms_;
    } else {
      figures.whole_runs.median_ms.is_lower_bound = true;
    }
  }

  const FrontCandidate& candidate_;
  Cells cells_, timed_;
  TickQuantiles times_;
  std::vector<Delay> delays_;  ///< of detected touches, ascending
  double computing_ms_ = unknown;
};

}  // namespace

std::string text_of(const results::FrontProbability& probability) {
  if (!probability.accuracy || !probability.delay) return {};
  return fmt::format(
      "on the front of accuracy and time in {:.0f} % of the draws of trainings, objects and runs, and on that of delay, misses "
      "and false alarms in {:.0f} %",
      100 * *probability.accuracy, 100 * *probability.delay);
}

OnFronts fronts_of(std::span<const results::TradeResult> figures) {
  std::vector<TradePlace> by_accuracy, by_delay;
  for (const results::TradeResult& one : figures) {
    by_accuracy.push_back({one.us_p99.value, -one.accuracy.value, 0});
    const results::CensoredQuantile& median = one.whole_runs.median_ms;
    by_delay.push_back({one.whole_runs.alarms_per_min.value, median.ms.value, one.whole_runs.missed.value});
    if (median.is_lower_bound) by_delay.back().y = infinite;
  }
  OnFronts on{std::vector<bool>(figures.size()), std::vector<bool>(figures.size())};
  for (const std::size_t i : pareto_front(by_accuracy)) on.accuracy[i] = true;
  for (const std::size_t i : pareto_front(by_delay)) on.delay[i] = true;
  return on;
}

std::vector<results::FrontProbability> front_probabilities(std::span<const FrontCandidate> candidates, unsigned threads,
                                                           const results::BootstrapOptions& options) {
  std::vector<results::FrontProbability> probabilities(candidates.size());
  std::set<std::string> names;
  for (const FrontCandidate& candidate : candidates) {
    for (const results::Cell& run : candidate.runs) names.insert(run.object);
    for (const TimedRun& run : candidate.timed) names.insert(run.object);
  }
  if (names.size() < evaluation::fewest_objects) return probabilities;
  std::vector<Drawable> drawables;
  std::size_t most_trainings = 1, most_runs = 1;
  for (const FrontCandidate& candidate : candidates) {
    drawables.emplace_back(candidate, names);
    most_trainings = std::max(most_trainings, drawables.back().trainings());
    most_runs = std::max(most_runs, drawables.back().most_runs());
  }
  std::vector<OnFronts> draws(options.draws);
  parallel_for(options.draws, threads, [&](std::size_t i) {
    const Draw draw = drawn(seed_for(options.seed, {"front", std::to_string(i)}), names.size(), most_trainings, most_runs);
    std::vector<results::TradeResult> figures;
    figures.reserve(drawables.size());
    for (const Drawable& one : drawables) figures.push_back(one.of(draw));
    draws[i] = fronts_of(figures);
  });
  const auto share_of = [&](std::vector<bool> OnFronts::*front, std::size_t candidate) {
    const auto on = std::count_if(draws.begin(), draws.end(), [&](const OnFronts& one) { return (one.*front)[candidate]; });
    return static_cast<double>(on) / static_cast<double>(draws.size());
  };
  for (std::size_t i = 0; i < candidates.size(); ++i)
    probabilities[i] = {share_of(&OnFronts::accuracy, i), share_of(&OnFronts::delay, i)};
  return probabilities;
}

}  // namespace tactile::trade
