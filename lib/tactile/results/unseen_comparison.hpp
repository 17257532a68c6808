#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"

namespace tactile::results {

/// Accuracy with an object in training, and without it; in [0, 1].
struct SeenAndHeldOut {
  Figure seen{}, held_out{};
  Figure difference{};  ///< held out - seen, paired over runs: below 0 where not having seen an object costs accuracy
};

template <class Members>
void list_members(Members& members, SeenAndHeldOut& of) {
  members("seen", of.seen);
  members("held_out", of.held_out);
  members("difference", of.difference);
}

/// Names of two models: trained with the objects, and without them.
struct ComparedModels {
  std::string seen{}, held_out{};
};

template <class Members>
void list_members(Members& members, ComparedModels& models) {
  members("seen", models.seen);
  members("held_out", models.held_out);
}

/// Accuracies of two models on runs that neither was trained on.
struct UnseenComparison {
  std::optional<ComparedModels> models{};  ///< nothing where there are several trainings
  std::vector<std::string> runs{};         ///< "fan/03"
  SeenAndHeldOut mean{};                   ///< over objects
  std::map<std::string, SeenAndHeldOut> objects{};
};

template <class Members>
void list_members(Members& members, UnseenComparison& comparison) {
  members("models", comparison.models);
  members("runs", comparison.runs);
  members("mean", comparison.mean);
  members("objects", comparison.objects);
}

}  // namespace tactile::results
