#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/results/figure.hpp"

namespace tactile::results {

/// The share of balanced samples predicted correctly: of each object over all samples of its runs, and the mean over objects.
struct Accuracy {
  Figure mean;                            ///< objects drawn first, then runs; n = objects
  std::map<std::string, Figure> objects;  ///< runs drawn; n = runs
};

/// {"mean", "objects"}
void to_json(nlohmann::json& json, const Accuracy& accuracy);
void from_json(const JsonView& json, Accuracy& accuracy);

}  // namespace tactile::results
