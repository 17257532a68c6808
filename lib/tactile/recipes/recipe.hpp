#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/recipes/sensor_noise.hpp"

namespace tactile::recipes {

/// The severity at which every recipe leaves the events as they are.
constexpr double harmless = 0;

/// One way to worsen a recording. The same recipe gives the same events from the same events.
struct Recipe {
  std::string name;            ///< as in `recipe_list`
  double severity = harmless;  ///< in the recipe's own unit
  std::uint64_t seed = 1;
  std::map<std::string, double, std::less<>> parameters{};  ///< those that differ from the usual values
  std::optional<SensorNoise> sensor{};                      ///< only of `noise` and `hot-pixels`

  friend bool operator==(const Recipe&, const Recipe&) = default;
};

/// A number that a recipe takes in addition to its severity.
struct RecipeParameter {
  std::string_view name;
  std::string_view unit;
  double usual = 0;
  double least = 0, most = 0;  ///< allowed, both included
  std::string_view text;       ///< one sentence
};

struct RecipeInfo {
  std::string_view name;          ///< "burst-loss"
  std::string_view title;         ///< "events lost in bursts", for the head of a figure
  std::string_view unit;          ///< of the severity: "% of the time"; empty if it has none
  double least = 0, most = 0;     ///< allowed severities, both included; 0 is always allowed
  bool whole = false;             ///< only whole severities
  std::span<const double> usual;  ///< 1 to 5 severities, ascending from mild to severe, all above 0
  std::string_view text;          ///< one sentence on what it does
  std::string_view model;         ///< how, and the limits of that
  std::span<const RecipeParameter> parameters{};
  bool takes_sensor = false;  ///< `Recipe::sensor` may be set

  double middle() const { return usual[usual.size() / 2]; }  ///< the middle usual severity
};

/// All recipes, in the order of the documentation.
std::span<const RecipeInfo> recipe_list();

/// @throws Error  that names the nearest recipe
const RecipeInfo& recipe_named(std::string_view name);

/// The value of a parameter: the recipe's own, else the usual one. @throws Error  if the recipe has no such parameter
double parameter_of(const Recipe& recipe, std::string_view parameter);

/// @throws Error  for an unknown name, severity or parameter, or one that is not finite or out of range: one sentence
void check(const Recipe& recipe);

/// "noise:100"; "noise" for the middle usual severity; "vibration:2:hz=120" with parameters.
/// @throws Error  as `check`
Recipe parse_recipe(std::string_view text, std::uint64_t seed = 1);

/// As `parse_recipe` reads it: "vibration:2:hz=120". The seed and the sensor are not in it.
std::string text_of(const Recipe& recipe);

/// What `--stress` takes: a list "noise:100,loss:20", or the name of a JSON file, which ends in ".json".
/// @param seed  of steps that have none of their own
/// @throws Error  as `read_recipes` and `check`, or if no recipe is named
std::vector<Recipe> parse_recipes(std::string_view text, std::uint64_t seed = 1);

/// A file of steps, which are applied in this order: {"steps": [{"recipe": "vibration", "severity": 2, "hz": 120}, ...]}.
/// Members of a step: "recipe"; "severity", by default the middle usual one; "seed"; the recipe's parameters; "sensor", of
/// `noise` and `hot-pixels`: a `sensor.json` of `tactile characterise`, relative to the file. A file may have "name" and "why".
/// @param seed  of steps that have none of their own
/// @throws Error  that names the file and the step
std::vector<Recipe> read_recipes(const std::filesystem::path& file, std::uint64_t seed = 1);

/// The steps of JSON in the form of such a file. @param where  names it in errors @param folder  of relative names
std::vector<Recipe> recipes_from(const nlohmann::json& json, const std::string& where, const std::filesystem::path& folder,
                                 std::uint64_t seed = 1);

/// A step in the form of such a file, complete; a sensor as an object with the members of SensorNoise.
nlohmann::json json_of(const Recipe& recipe);

}  // namespace tactile::recipes
