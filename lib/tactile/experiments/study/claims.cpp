#include "tactile/experiments/study/claims.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "tactile/core/numbers.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/run_figures.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/study/plan_study.hpp"

namespace tactile::study {
namespace {

using evaluation::Range;
using evaluation::RunsByObject;
using Runs = std::vector<std::size_t>;

constexpr const char* exception_object = "plastic-container";
constexpr double near_points = 5;        // taken for "comparable"
constexpr double accurate_percent = 95;  // taken for "highly accurate"
constexpr double highest_delay_ms = 500;

/// What cells of one replicate, or drawn ones, say. Everything is by object.
class Measures {
 public:
  Measures(std::span<const results::Cell> cells, std::string main) : cells_(cells), main_(std::move(main)) {
    for (const results::Cell& cell : cells) {
      const auto ms = cell.setting.starts_with("th") ? number_in(std::string_view(cell.setting).substr(2)) : std::nullopt;
      if (ms) histories_[*ms] = cell.setting;
    }
  }

  const std::string& main() const { return main_; }
  std::string unseen() const { return main_ + "-unseen"; }
  bool has(double history_ms) const { return histories_.contains(history_ms); }

  /// In percent.
  std::optional<double> accuracy(const Runs& runs, const std::string& setting) const {
    results::Confusion sum;
    for (const std::size_t i : runs) {
      if (cells_[i].setting == setting) sum += cells_[i].samples;
    }
    const auto share = sum.accuracy();
    return share ? std::optional(100 * *share) : std::nullopt;
  }

  std::optional<double> accuracy(const Runs& runs, double history_ms) const { return accuracy(runs, histories_.at(history_ms)); }

  std::optional<double> mean_accuracy(const RunsByObject& objects, double history_ms) const {
    return mean(objects, [&](const Runs& runs) { return accuracy(runs, history_ms); });
  }

  /// The history with the best (worst) accuracy; of equals, the shortest.
  std::optional<double> best_history(const Runs& runs, bool worst = false) const {
    std::optional<double> found, of_found;
    for (const auto& [history_ms, setting] : histories_) {
      const auto value = accuracy(runs, setting);
      if (!value) continue;
      if (!of_found || (worst ? *value < *of_found : *value > *of_found)) found = history_ms, of_found = value;
    }
    return found;
  }

  /// The change of a held-out object's accuracy on the runs that both models were judged on [points].
  std::optional<double> change(const Runs& runs) const {
    std::set<std::string> judged;
    for (const std::size_t i : runs) {
      if (cells_[i].setting == unseen()) judged.insert(key_of(cells_[i]));
    }
    Runs same;
    std::copy_if(runs.begin(), runs.end(), std::back_inserter(same),
                 [&](std::size_t i) { return judged.contains(key_of(cells_[i])); });
    const auto without = accuracy(same, unseen()), with = accuracy(same, main_);
    return without && with ? std::optional(*without - *with) : std::nullopt;
  }

  bool is_exception(const Runs& runs) const { return cells_[runs.front()].object == exception_object; }

  /// Of detected touches; nothing without.
  std::optional<double> mean_delay_ms(const Runs& runs, Touch touch) const {
    double sum = 0, count = 0;
    for_each_touch(runs, touch, [&](const results::Cell& cell, const results::TouchOutcome& one) {
      if (one.outcome == results::DetectionOutcome::detected) sum += cell.delay_ms(one), ++count;
    });
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  }

  /// Whether every slip is detected at its first tick; nothing without slips.
  std::optional<bool> slip_at_once(const Runs& runs) const {
    std::optional<bool> all;
    for_each_touch(runs, Touch::slip, [&](const results::Cell& cell, const results::TouchOutcome& one) {
      const bool at_once = one.outcome == results::DetectionOutcome::detected && cell.delay_ms(one) <= cell.tick_ms * (1 + 1e-9);
      all = all.value_or(true) && at_once;
    });
    return all;
  }

  /// In percent; nothing without such ticks.
  std::optional<double> right(const Runs& runs, results::TickCount results::Cell::*part) const {
    double right = 0, ticks = 0;
    for (const std::size_t i : runs) {
      if (cells_[i].setting != main_) continue;
      right += static_cast<double>((cells_[i].*part).right);
      ticks += static_cast<double>((cells_[i].*part).ticks);
    }
    return ticks > 0 ? std::optional(100 * right / ticks) : std::nullopt;
  }

  /// Over the objects that have one.
  template <class OfRuns>
  static std::optional<double> mean(const RunsByObject& objects, OfRuns of_runs) {
    double sum = 0, count = 0;
    for (const Runs& runs : objects) {
      if (const auto value = of_runs(runs)) sum += *value, ++count;
    }
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  }

  /// The least (greatest) of the objects' values.
  template <class OfRuns>
  static std::optional<double> least(const RunsByObject& objects, OfRuns of_runs, bool greatest = false) {
    std::optional<double> found;
    for (const Runs& runs : objects) {
      const auto value = of_runs(runs);
      if (value && (!found || (greatest ? *value > *found : *value < *found))) found = value;
    }
    return found;
  }

 private:
  static std::string key_of(const results::Cell& cell) {
    return fmt::format("{}/{}/{}#{}", cell.world, cell.object, cell.run, cell.training);
  }

  template <class Use>
  void for_each_touch(const Runs& runs, Touch touch, Use use) const {
    for (const std::size_t i : runs) {
      if (cells_[i].setting != main_) continue;
      for (const results::TouchOutcome& one : cells_[i].touches) {
        if (one.touch == touch) use(cells_[i], one);
      }
    }
  }

  std::span<const results::Cell> cells_;
  std::string main_;
  std::map<double, std::string> histories_;  // their settings, by t_h [ms]
};

/// How a sentence is read: what decides it, and the number that does.
struct Reading {
  results::Claim claim;
  evaluation::Statistic number;  ///< of one replicate's objects
  Range range;
};

Reading history_2_worst(const Measures& m, double objects) {
  return {{.id = "history-2-worst",
           .figure = "8",
           .paper = "Instantaneous heatmaps (2 ms) are worst for all ten objects.",
           .measure = "the number of objects for which another history is worse than 2 ms",
           .unit = "objects",
           .is_below = true,
           .limit = 1},
          [&m](const RunsByObject& lists) -> std::optional<double> {
            double others = 0;
            for (const Runs& runs : lists) others += m.best_history(runs, true).value_or(2) != 2 ? 1 : 0;
            return m.has(2) ? std::optional(others) : std::nullopt;
          },
          {0, objects}};
}

Reading longer_is_better(const Measures& m) {
  return {{.id = "longer-is-better",
           .figure = "8",
           .paper = "Increasing the history of events improves the performance.",
           .measure = "the smallest step of the mean accuracy to the next longer history, up to 20 ms,",
           .unit = "points",
           .limit = 0},
          [&m](const RunsByObject& lists) -> std::optional<double> {
            if (!m.has(2) || !m.has(10) || !m.has(20)) return std::nullopt;
            const auto a = m.mean_accuracy(lists, 2), b = m.mean_accuracy(lists, 10), c = m.mean_accuracy(lists, 20);
            return a && b && c ? std::optional(std::min(*b - *a, *c - *b)) : std::nullopt;
          },
          {-100, 100}};
}

Reading best_history_40(const Measures& m, double objects) {
  return {{.id = "best-history-40",
           .figure = "8",
           .paper = "40 ms is the best for five objects, 50 ms for three, 20 ms for two.",
           .measure = "the number of objects for which 40 ms is the best, less that of the next history,",
           .unit = "objects",
           .limit = 0},
          [&m](const RunsByObject& lists) -> std::optional<double> {
            std::map<double, double> best;
            for (const Runs& runs : lists) {
              if (const auto history_ms = m.best_history(runs)) ++best[*history_ms];
            }
            double next = 0;
            for (const auto& [history_ms, count] : best) next = history_ms == 40 ? next : std::max(next, count);
            return m.has(40) ? std::optional(best[40] - next) : std::nullopt;
          },
          {-objects, objects}};
}

Reading marginal_past_20(const Measures& m) {
  return {{.id = "marginal-past-20",
           .figure = "8",
           .paper = "Improvements become marginal after 20 ms.",
           .measure = "the highest mean accuracy past 20 ms, less that at 20 ms,",
           .unit = "points",
           .is_below = true,
           .limit = 1,
           .is_by_margin = true},
          [&m](const RunsByObject& lists) -> std::optional<double> {
            std::optional<double> highest;
            for (const double history_ms : {30, 40, 50}) {
              const auto mean = m.has(history_ms) ? m.mean_accuracy(lists, history_ms) : std::nullopt;
              if (mean) highest = std::max(highest.value_or(0), *mean);
            }
            const auto at_20 = m.has(20) ? m.mean_accuracy(lists, 20) : std::nullopt;
            return highest && at_20 ? std::optional(*highest - *at_20) : std::nullopt;
          },
          {-100, 100}};
}

Reading accuracy_at_40(const Measures& m) {
  return {{.id = "accuracy-at-40",
           .figure = "8",
           .paper = "The average accuracy of the nine test runs exceeds 95 % for all ten objects.",
           .measure = "the lowest accuracy of an object at 40 ms",
           .unit = "%",
           .limit = 95},
          [&m](const RunsByObject& lists) -> std::optional<double> {
            if (!m.has(40)) return std::nullopt;
            return Measures::least(lists, [&m](const Runs& runs) { return m.accuracy(runs, 40); });
          },
          {0, 100}};
}

std::vector<Reading> detection_readings(const Measures& m) {
  std::vector<Reading> readings;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    readings.push_back({{.id = fmt::format("{}-delay", name_of(touch)),
                         .figure = "9",
                         .paper = "The average delay is below 5 ms for press and slip and for all ten objects.",
                         .measure = fmt::format("the mean delay of detected {} of the slowest object",
                                                touch == Touch::press ? "presses" : "slips"),
                         .unit = "ms",
                         .is_below = true,
                         .limit = 5},
                        [&m, touch](const RunsByObject& lists) {
                          return Measures::least(
                              lists, [&](const Runs& runs) { return m.mean_delay_ms(runs, touch); }, true);
                        },
                        {0, highest_delay_ms}});
  }
  readings.push_back({{.id = "slip-at-once",
                       .figure = "9",
                       .paper = "In six of ten objects slip is detected with minimal delay in all trials.",
                       .measure = "the share of objects whose slips are all detected at their first tick",
                       .unit = "%",
                       .limit = 50},
                      [&m](const RunsByObject& lists) {
                        return Measures::mean(lists, [&m](const Runs& runs) -> std::optional<double> {
                          const auto at_once = m.slip_at_once(runs);
                          return at_once ? std::optional(*at_once ? 100.0 : 0.0) : std::nullopt;
                        });
                      },
                      {0, 100}});
  readings.push_back({{.id = "right-at-first",
                       .figure = "10",
                       .paper = "During the beginning of pressing and slippage the classification is highly accurate.",
                       .measure = "the share of right ticks in the first 500 ms of touches, the mean over objects,",
                       .unit = "%",
                       .limit = accurate_percent},
                      [&m](const RunsByObject& lists) {
                        return Measures::mean(lists, [&m](const Runs& runs) { return m.right(runs, &results::Cell::first); });
                      },
                      {0, 100}});
  readings.push_back({{.id = "worse-near-the-end",
                       .figure = "10",
                       .paper = "Near the end of each incident the model deviates from the ground truth.",
                       .measure = "the share of right ticks in the last 200 ms of touches, less that before,",
                       .unit = "points",
                       .is_below = true,
                       .limit = 0},
                      [&m](const RunsByObject& lists) {
                        return Measures::mean(lists, [&m](const Runs& runs) -> std::optional<double> {
                          const auto last = m.right(runs, &results::Cell::last),
                                     before = m.right(runs, &results::Cell::before_last);
                          return last && before ? std::optional(*last - *before) : std::nullopt;
                        });
                      },
                      {-100, 100}});
  return readings;
}

/// Without the paper's exception.
RunsByObject others_of(const Measures& m, const RunsByObject& lists) {
  RunsByObject others;
  std::copy_if(lists.begin(), lists.end(), std::back_inserter(others), [&](const Runs& runs) { return !m.is_exception(runs); });
  return others;
}

std::vector<Reading> unseen_readings(const Measures& m) {
  std::vector<Reading> readings;
  readings.push_back(
      {{.id = "seen-better",
        .figure = "11",
        .paper = "The model generally provides a better performance when the data from an object is included in the "
                 "training set.",
        .measure = "the mean accuracy of held-out objects with them in training, less that without,",
        .unit = "points",
        .limit = 0},
       [&m](const RunsByObject& lists) -> std::optional<double> {
         const auto mean = Measures::mean(lists, [&m](const Runs& runs) { return m.change(runs); });
         return mean ? std::optional(-*mean) : std::nullopt;
       },
       {-100, 100}});
  readings.push_back({{.id = "unseen-near-seen",
                       .figure = "11",
                       .paper = "For most unseen objects the accuracy is comparable to that with the objects in training.",
                       .measure = fmt::format("the mean loss of held-out objects but {}", exception_object),
                       .unit = "points",
                       .is_below = true,
                       .limit = near_points,
                       .is_by_margin = true},
                      [&m](const RunsByObject& lists) -> std::optional<double> {
                        const auto mean = Measures::mean(others_of(m, lists), [&m](const Runs& runs) { return m.change(runs); });
                        return mean ? std::optional(-*mean) : std::nullopt;
                      },
                      {-100, 100}});
  readings.push_back({{.id = "unseen-accurate",
                       .figure = "11",
                       .paper = "For most unseen objects the model delivers highly accurate classifications.",
                       .measure = fmt::format("the share of held-out objects but {} with more than 95 %", exception_object),
                       .unit = "%",
                       .limit = 50},
                      [&m](const RunsByObject& lists) {
                        return Measures::mean(others_of(m, lists), [&m](const Runs& runs) -> std::optional<double> {
                          const auto accuracy = m.accuracy(runs, m.unseen());
                          return accuracy ? std::optional(*accuracy > accurate_percent ? 100.0 : 0.0) : std::nullopt;
                        });
                      },
                      {0, 100}});
  readings.push_back({{.id = fmt::format("unseen-{}", exception_object),
                       .figure = "11",
                       .paper = "The only exception is the plastic container, where the accuracy was significantly lower.",
                       .measure = fmt::format("the loss of {} above that of any other held-out object", exception_object),
                       .unit = "points",
                       .limit = near_points},
                      [&m](const RunsByObject& lists) -> std::optional<double> {
                        const auto change = [&m](const Runs& runs) { return m.change(runs); };
                        std::optional<double> own;
                        for (const Runs& runs : lists) {
                          if (m.is_exception(runs)) own = change(runs);
                        }
                        const auto next = Measures::least(others_of(m, lists), change);
                        return own && next ? std::optional(*next - *own) : std::nullopt;
                      },
                      {-100, 100}});
  return readings;
}

results::Outcome outcome_of(const results::Claim& claim) {
  const auto decided = [](bool holds, bool does_not) {
    return holds ? results::Outcome::holds : does_not ? results::Outcome::does_not : results::Outcome::cannot_tell;
  };
  if (claim.replicates == 0) return results::Outcome::cannot_tell;
  if (claim.is_by_margin) {
    const auto &low = claim.measured.low, &high = claim.measured.high;
    const bool is_under = high && *high < claim.limit, is_over = low && *low > claim.limit;
    return claim.is_below ? decided(is_under, is_over) : decided(is_over, is_under);
  }
  constexpr double two_sided = 0.9;  // one bound at 95 %
  const auto [low, high] =
      evaluation::binomial_bounds(static_cast<double>(claim.written), static_cast<double>(claim.replicates), two_sided);
  return decided(low > 0.5, high < 0.5);
}

/// Tests the sentence in each replicate, and takes its number over all.
results::Claim tested(const Reading& reading, std::span<const results::Cell> cells, const results::BootstrapOptions& options) {
  results::Claim claim = reading.claim;
  std::set<std::pair<std::string, std::size_t>> replicates;
  for (const results::Cell& cell : cells) replicates.emplace(cell.world, cell.training);
  for (const auto& [world, training] : replicates) {
    const evaluation::RunFigures figures(cells, nullptr, [&, &world = world, training = training](const results::Cell& cell) {
      return cell.world == world && cell.training == training;
    });
    const double number = figures.of_objects(reading.number).value;
    if (!(number == number)) continue;
    ++claim.replicates;
    claim.written += (claim.is_below ? number < claim.limit : number > claim.limit) ? 1 : 0;
  }
  claim.measured = evaluation::RunFigures(cells, &options, [](const results::Cell&) {
                     return true;
                   }).of_objects(reading.number, reading.range);
  claim.outcome = outcome_of(claim);
  return claim;
}

}  // namespace

std::vector<results::Claim> claims_of(std::span<const results::Cell> all, microseconds main,
                                      const results::BootstrapOptions& options) {
  std::vector<results::Cell> cells;
  std::set<std::string> objects;
  for (const results::Cell& cell : all) {
    if (cell.threshold || cell.confirmed || !cell.setting.starts_with("th")) continue;
    cells.push_back(cell);
    objects.insert(cell.object);
  }
  model::ModelSettings of_main;
  of_main.rendering.history = main;
  const Measures measures(cells, setting_name(of_main));
  std::vector<results::Claim> claims;
  const auto count = static_cast<double>(objects.size());
  const std::vector<Reading> of_histories{history_2_worst(measures, count), longer_is_better(measures),
                                          best_history_40(measures, count), marginal_past_20(measures), accuracy_at_40(measures)};
  for (const auto& readings : {of_histories, detection_readings(measures), unseen_readings(measures)}) {
    for (const Reading& reading : readings) claims.push_back(tested(reading, cells, options));
  }
  return claims;
}

std::string summary_of(std::span<const results::Claim> claims, bool simulated) {
  const auto count = [&](results::Outcome outcome) {
    return std::count_if(claims.begin(), claims.end(), [&](const results::Claim& claim) { return claim.outcome == outcome; });
  };
  return fmt::format(
      "Of the paper's {} sentences {} would usually be written on {} runs, {} seldom; of {} this study cannot tell.",
      claims.size(), count(results::Outcome::holds), simulated ? "simulated" : "real", count(results::Outcome::does_not),
      count(results::Outcome::cannot_tell));
}

}  // namespace tactile::study
