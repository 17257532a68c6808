#pragma once

#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/evaluation/crossed_figure.hpp"

namespace tactile::study {

/// Standard deviations of normal effects, on the scale of the logit for shares and of the logarithm for delays and rates.
struct Effects {
  double training = 0;  ///< of a training, on all objects and runs
  double object = 0;
  double both = 0;    ///< of a training on one object
  double run = 0;     ///< of a run
  double single = 0;  ///< of a training on one run

  double together() const;
};

/// Which training is judged on which run.
struct Layout {
  std::size_t objects = 1, runs = 1, trainings = 1;
  /// Training k learns from run k; the following so many runs are those of the choice. Without: every training is judged on all
  /// runs.
  std::optional<std::size_t> runs_of_choice{};

  bool judged(std::size_t training, std::size_t run) const;
  std::string in_words() const;
};

/// One made-up set of results, of which the expected figure is known.
struct Trial {
  evaluation::CrossedResults objects;
  evaluation::Statistic statistic;
  evaluation::Range range;
  double truth = 0;
};

enum class Quantity { accuracy, missed, difference, best_of_five, mean_delay, quantile_of_delays, rate };

struct Scenario {
  Quantity quantity = Quantity::accuracy;
  /// The expected share; of a difference, that of the first of the two settings; of `quantile_of_delays`, the share that it is
  /// of; of `rate`, alarms per minute; unused for others.
  double level = 0;
  Layout layout;  ///< one object: the figure of an object, which stays the same; the effects of objects are not drawn
  Effects effects;
};

/// The true figure is the expected one over new trainings, runs and, if there are several, objects. With one training the
/// training stays as it is: neither its effect on all objects nor, of one object, that on the object is drawn.
Trial draw(const Scenario& scenario, Random& random);

}  // namespace tactile::study
