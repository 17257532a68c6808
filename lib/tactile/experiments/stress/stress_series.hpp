#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/recipes/recipe.hpp"
#include "tactile/recipes/sensor_noise.hpp"

namespace tactile::stress {

/// Runs that are worsened in one way, more and more.
struct StressSeries {
  std::string name;                      ///< "noise", "vibration-hz-120"; lower-case letters, digits, '.' and '-'
  std::string unit;                      ///< of the severity; may be empty
  std::string meaning;                   ///< one sentence
  std::vector<double> severities;        ///< ascending, > 0; the harmless one, 0, comes before them
  std::string world;                     ///< the simulated world; empty: the events are changed
  std::vector<recipes::Recipe> recipes;  ///< of a file: as the file has them; else one, whose severity is that of the series
  bool is_file = false;                  ///< the severity is a share of those in the file, in percent
};

/// "vibration:1,2:hz=120" as its parts.
struct SeverityList {
  std::string name;
  std::vector<double> severities;  ///< ascending; empty if none is given
  std::string parameters;          ///< ":hz=120"
};

/// @throws Error  if a severity is no number above 0, or is given twice
SeverityList severities_in(const std::string& text);

/// What `--recipe` takes: "noise", "noise:50,200", "vibration:1,2:hz=120", or a JSON file of recipes, which ends in ".json".
/// Without severities, the usual ones of the recipe. A file gives one series: its severity is the share of the severities in the
/// file, in percent.
/// @param seed    of recipes that have none of their own
/// @param sensor  the noise of recipes that take one; nothing: as `recipes::Recipe`
/// @throws Error  as `severities_in`, `recipes::parse_recipe` and `recipes::read_recipes`
StressSeries series_in(const std::string& text, std::uint64_t seed, const std::optional<recipes::SensorNoise>& sensor = {});

/// One series for each recipe of the list.
std::vector<StressSeries> all_series(std::uint64_t seed, const std::optional<recipes::SensorNoise>& sensor = {});

/// At most three severities: the first, the middle and the last.
StressSeries with_few_severities(StressSeries series);

/// The recipes of a series at one severity. @param severity  > 0
std::vector<recipes::Recipe> recipes_at(const StressSeries& series, double severity);

/// Changes the events of one run. Each run draws its own random numbers, the same at every severity.
/// @param run  its name
heatmaps::ChangeEvents change_by(const StressSeries& series, double severity, const std::string& run, events::SensorSize size);

/// Everything that the changed events depend on except the run, for the key of a step.
nlohmann::json json_of(const StressSeries& series, double severity);

}  // namespace tactile::stress
