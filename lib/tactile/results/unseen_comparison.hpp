#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"

namespace tactile::results {

/// Accuracy with an object in training, and without it; in [0, 1].
struct SeenAndHeldOut {
  Figure seen{}, held_out{};
  Figure difference{};  ///< held out - seen, paired over runs: below 0 where not having seen an object costs accuracy
};

/// Accuracies of two models on runs that neither was trained on.
struct UnseenComparison {
  struct Models {
    std::string seen, held_out;  ///< names: trained with the objects, and without them
  };
  std::optional<Models> models;  ///< nothing where a study names them apart
  std::vector<std::string> runs;
  SeenAndHeldOut mean;  ///< over objects
  std::map<std::string, SeenAndHeldOut> objects;
};

/// {"models", "runs", "mean", "objects"}, with "seen", "held_out" and "difference" in "mean" and in each of "objects"; "models"
/// where they are given.
void to_json(nlohmann::json& json, const SeenAndHeldOut& of);
void to_json(nlohmann::json& json, const UnseenComparison::Models& models);
void to_json(nlohmann::json& json, const UnseenComparison& comparison);
void from_json(const JsonView& json, SeenAndHeldOut& of);
void from_json(const JsonView& json, UnseenComparison::Models& models);
void from_json(const JsonView& json, UnseenComparison& comparison);

}  // namespace tactile::results
