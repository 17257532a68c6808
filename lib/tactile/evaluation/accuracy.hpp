#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/results/accuracy.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::evaluation {

/// Counts pairs of true and predicted class. @throws Error  if the two are not of one length
results::Confusion confusion_of(std::span<const Touch> truth, std::span<const Touch> predicted);

/// Runs without samples are left out.
results::Accuracy accuracy_of(std::span<const results::RunConfusion> runs, const results::BootstrapOptions& options = {});

/// `b - a` of the same runs in the same order, in each draw too. @throws Error  if they are not runs of the same objects
results::Accuracy accuracy_difference(std::span<const results::RunConfusion> a, std::span<const results::RunConfusion> b,
                                      const results::BootstrapOptions& options = {});

/// Compares verdicts on the same runs with their objects in training and without; the names of models and runs stay empty.
/// @throws Error  as `accuracy_difference`
results::UnseenComparison unseen_comparison(std::span<const results::RunConfusion> seen,
                                            std::span<const results::RunConfusion> held_out,
                                            const results::BootstrapOptions& options = {});

/// The runs of each object, by their place in `runs`, objects by name; those for which `taken` is false are left out.
template <class Run, class Taken>
std::map<std::string, std::vector<std::size_t>> runs_by_object(std::span<const Run> runs, Taken taken) {
  std::map<std::string, std::vector<std::size_t>> objects;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (taken(runs[i])) objects[runs[i].object].push_back(i);
  }
  return objects;
}

/// The same without the names.
inline RunsByObject without_names(const std::map<std::string, std::vector<std::size_t>>& objects) {
  RunsByObject runs;
  for (const auto& object : objects) runs.push_back(object.second);
  return runs;
}

}  // namespace tactile::evaluation
