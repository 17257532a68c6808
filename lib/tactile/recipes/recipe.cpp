#include "tactile/recipes/recipe.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"

namespace tactile::recipes {
namespace {

template <class Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.emplace_back(item.name);
  return names;
}

/// "; the nearest is 'loss', of noise, loss"
[[noreturn]] void refuse_name(std::string_view name, const std::string& what, const std::vector<std::string>& names) {
  std::string listed;
  for (const std::string& known : names) listed += (listed.empty() ? "" : ", ") + known;
  const std::string nearest = nearest_name(name, names);
  throw Error(nearest.empty() ? fmt::format("{} is no {}; expected one of {}", shown_text(name), what, listed)
                              : fmt::format("{} is no {}; the nearest is '{}', of {}", shown_text(name), what, nearest, listed));
}

const RecipeParameter& parameter_named(const RecipeInfo& info, std::string_view name) {
  for (const RecipeParameter& parameter : info.parameters) {
    if (parameter.name == name) return parameter;
  }
  if (info.parameters.empty())
    throw Error(fmt::format("recipe {}: {} is no parameter of it; expected none", info.name, shown_text(name)));
  refuse_name(name, fmt::format("parameter of the recipe {}", info.name), names_of(info.parameters));
}

std::string with_unit(double value, std::string_view unit) { return fmt::format("{}{}{}", value, unit.empty() ? "" : " ", unit); }

std::vector<std::string_view> parts_of(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(trimmed(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

double number_of(std::string_view text, const std::string& what) {
  const std::optional<double> number = number_in(text);
  if (!number) throw Error(fmt::format("{}: {} is no number; expected one", what, shown_text(text)));
  return *number;
}

}  // namespace

const RecipeInfo& recipe_named(std::string_view name) {
  for (const RecipeInfo& info : recipe_list()) {
    if (info.name == name) return info;
  }
  refuse_name(name, "recipe", names_of(recipe_list()));
}

double parameter_of(const Recipe& recipe, std::string_view parameter) {
  const RecipeParameter& known = parameter_named(recipe_named(recipe.name), parameter);
  const auto own = recipe.parameters.find(parameter);
  return own == recipe.parameters.end() ? known.usual : own->second;
}

void check(const Recipe& recipe) {
  const RecipeInfo& info = recipe_named(recipe.name);
  const double severity = recipe.severity;
  const bool is_in_range = severity == harmless || (severity >= info.least && severity <= info.most);  // NaN is not
  if (!is_in_range || (info.whole && severity != std::floor(severity))) {
    throw Error(fmt::format("recipe {}: a severity of {}; expected {} from {} to {}, or 0 for no change", info.name,
                            with_unit(severity, info.unit), info.whole ? "a whole number" : "a number", info.least,
                            with_unit(info.most, info.unit)));
  }
  for (const auto& [name, value] : recipe.parameters) {
    const RecipeParameter& parameter = parameter_named(info, name);
    if (!(value >= parameter.least && value <= parameter.most)) {
      throw Error(fmt::format("recipe {}: {} of {}; expected {} to {}", info.name, name, with_unit(value, parameter.unit),
                              parameter.least, with_unit(parameter.most, parameter.unit)));
    }
  }
  if (recipe.sensor && !info.takes_sensor)
    throw Error(fmt::format("recipe {}: has a sensor; expected one only for noise and hot-pixels", info.name));
}

Recipe parse_recipe(std::string_view text, std::uint64_t seed) {
  const std::vector<std::string_view> parts = parts_of(text, ':');
  const RecipeInfo& info = recipe_named(parts.front());
  Recipe recipe{.name = std::string(info.name), .severity = info.middle(), .seed = seed};
  const std::string where = fmt::format("recipe {}", info.name);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const std::size_t equals = parts[i].find('=');
    if (equals == std::string_view::npos) {
      if (i > 1) throw Error(fmt::format("{}: {}; expected PARAMETER=NUMBER after the severity", where, shown_text(parts[i])));
      recipe.severity = number_of(parts[i], where);
      continue;
    }
    const RecipeParameter& parameter = parameter_named(info, trimmed(parts[i].substr(0, equals)));
    const double value = number_of(trimmed(parts[i].substr(equals + 1)), fmt::format("{}, {}", where, parameter.name));
    if (recipe.parameters.contains(parameter.name))
      throw Error(fmt::format("{}: {} is given twice; expected it once", where, parameter.name));
    recipe.parameters.emplace(parameter.name, value);
  }
  check(recipe);
  std::erase_if(recipe.parameters, [&](const auto& own) { return own.second == parameter_named(info, own.first).usual; });
  return recipe;
}

std::string text_of(const Recipe& recipe) {
  std::string text = fmt::format("{}:{}", recipe.name, recipe.severity);
  for (const auto& [name, value] : recipe.parameters) text += fmt::format(":{}={}", name, value);
  return text;
}

std::vector<Recipe> parse_recipes(std::string_view text, std::uint64_t seed) {
  if (text.ends_with(".json")) return read_recipes(std::filesystem::path(text), seed);
  std::vector<Recipe> recipes;
  for (const std::string_view part : parts_of(text, ',')) recipes.push_back(parse_recipe(part, seed));
  return recipes;
}

}  // namespace tactile::recipes
