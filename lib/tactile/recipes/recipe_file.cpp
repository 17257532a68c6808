#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/fields.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text.hpp"
#include "tactile/recipes/recipe.hpp"
#include "tactile/recipes/sensor_noise.hpp"

namespace tactile::recipes {
namespace {

/// @throws Error  for a member that is not one of `known`
void refuse_others(const nlohmann::json& json, const std::vector<std::string>& known, const std::string& where) {
  for (const auto& [key, value] : json.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string nearest = nearest_name(key, known);
    std::string listed;
    for (const std::string& name : known) listed += (listed.empty() ? "" : ", ") + name;
    throw Error(fmt::format("{}: no member is called {}; expected {}", where, shown_text(key),
                            nearest.empty() ? "some of " + listed : "'" + nearest + "'"));
  }
}

SensorNoise sensor_of(const nlohmann::json& json, const std::string& where, const std::filesystem::path& folder) {
  if (json.is_string()) {
    const std::filesystem::path file(json.get<std::string>());
    return read_sensor_noise(file.is_absolute() ? file : folder / file);
  }
  SensorNoise noise = measured_noise();
  read_fields(json, noise, where + ", sensor");
  return noise;
}

Recipe step_of(const nlohmann::json& json, const std::string& where, const std::filesystem::path& folder, std::uint64_t seed) {
  if (!json.is_object()) throw Error(where + ": is no object; expected one with \"recipe\" and \"severity\"");
  const RecipeInfo& info = recipe_named(member<std::string>(json, "recipe", where));
  std::vector<std::string> known{"recipe", "severity", "seed"};
  if (info.takes_sensor) known.emplace_back("sensor");
  for (const RecipeParameter& parameter : info.parameters) known.emplace_back(parameter.name);
  refuse_others(json, known, where);

  Recipe recipe{.name = std::string(info.name), .severity = info.middle(), .seed = seed};
  if (json.contains("severity")) recipe.severity = member<double>(json, "severity", where);
  if (json.contains("seed")) recipe.seed = member<std::uint64_t>(json, "seed", where);
  for (const RecipeParameter& parameter : info.parameters) {
    if (!json.contains(parameter.name)) continue;
    const auto value = member<double>(json, parameter.name, where);
    if (value != parameter.usual) recipe.parameters.emplace(parameter.name, value);
  }
  if (json.contains("sensor")) recipe.sensor = sensor_of(json.at("sensor"), where, folder);
  check(recipe);
  return recipe;
}

}  // namespace

std::vector<Recipe> recipes_from(const nlohmann::json& json, const std::string& where, const std::filesystem::path& folder,
                                 std::uint64_t seed) {
  const bool is_whole = json.is_object();
  if (is_whole) refuse_others(json, {"name", "why", "steps"}, where);
  const nlohmann::json steps = is_whole ? member<nlohmann::json>(json, "steps", where) : json;
  if (!steps.is_array() || steps.empty())
    throw Error(where + ": has no steps; expected {\"steps\": [{\"recipe\": \"noise\", \"severity\": 100}, ...]}");
  std::vector<Recipe> recipes;
  for (const nlohmann::json& step : steps) {
    const std::string place = fmt::format("{}, step {}", where, recipes.size() + 1);
    try {
      recipes.push_back(step_of(step, place, folder, seed));
    } catch (const Error& e) {
      if (std::string_view(e.what()).starts_with(place)) throw;
      throw Error(fmt::format("{}: {}", place, e.what()));
    }
  }
  return recipes;
}

std::vector<Recipe> read_recipes(const std::filesystem::path& file, std::uint64_t seed) {
  return recipes_from(read_json(file), file.string(), file.parent_path(), seed);
}

nlohmann::json json_of(const Recipe& recipe) {
  nlohmann::json json = {{"recipe", recipe.name}, {"severity", recipe.severity}, {"seed", recipe.seed}};
  for (const RecipeParameter& parameter : recipe_named(recipe.name).parameters)
    json[std::string(parameter.name)] = parameter_of(recipe, parameter.name);
  if (recipe.sensor) json["sensor"] = json_of_fields(*recipe.sensor);
  return json;
}

}  // namespace tactile::recipes
