#include "tactile/experiments/stress/stress_series.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/random.hpp"
#include "tactile/recipes/recipe_stream.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;

/// A name that can be part of a file's name.
std::string plain_name(std::string_view text) {
  std::string name;
  for (const char c : text) {
    const bool fits = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.';
    if (fits) name += c;
    if (!fits && !name.empty() && name.back() != '-') name += '-';
  }
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name;
}

StressSeries series_of_file(const fs::path& file, std::uint64_t seed) {
  StressSeries series{.name = plain_name(file.stem().string()),
                      .unit = "% of the file's severities",
                      .meaning = fmt::format("The recipes of {}, in their order.", file.filename().string()),
                      .severities = {100},
                      .world = {},
                      .recipes = recipes::read_recipes(file, seed),
                      .is_file = true};
  const bool scales = std::none_of(series.recipes.begin(), series.recipes.end(),
                                   [](const recipes::Recipe& recipe) { return recipes::recipe_named(recipe.name).whole; });
  if (scales) series.severities = {25, 50, 100};
  if (series.name.empty()) series.name = "own";
  return series;
}

}  // namespace

SeverityList severities_in(const std::string& text) {
  SeverityList list;
  const std::vector<std::string_view> parts = split_cells(text, ':');
  list.name = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].find('=') != std::string_view::npos) {
      list.parameters += fmt::format(":{}", parts[i]);
      continue;
    }
    for (const std::string_view word : split_cells(parts[i])) {
      const std::optional<double> severity = number_in(word);
      if (!severity || !(*severity > 0) || std::isinf(*severity))
        throw Error(
            fmt::format("'{}': its severity '{}' is no number above 0; expected a list such as {}:10,20", text, word, list.name));
      list.severities.push_back(*severity);
    }
  }
  std::sort(list.severities.begin(), list.severities.end());
  if (const auto twice = std::adjacent_find(list.severities.begin(), list.severities.end()); twice != list.severities.end())
    throw Error(fmt::format("'{}': the severity {:g} is given twice; expected each once", text, *twice));
  return list;
}

StressSeries series_in(const std::string& text, std::uint64_t seed, const std::optional<recipes::SensorNoise>& sensor) {
  if (text.ends_with(".json")) return series_of_file(text, seed);
  SeverityList given = severities_in(text);
  const recipes::RecipeInfo& info = recipes::recipe_named(given.name);
  if (given.severities.empty()) given.severities.assign(info.usual.begin(), info.usual.end());
  StressSeries series{.name = plain_name(given.name + given.parameters),
                      .unit = std::string(info.unit),
                      .meaning = std::string(info.text),
                      .severities = given.severities,
                      .world = {},
                      .recipes = {}};
  for (const double severity : given.severities)  // each is checked
    series.recipes = {recipes::parse_recipe(fmt::format("{}:{}{}", given.name, severity, given.parameters), seed)};
  if (info.takes_sensor) series.recipes.front().sensor = sensor;
  return series;
}

std::vector<StressSeries> all_series(std::uint64_t seed, const std::optional<recipes::SensorNoise>& sensor) {
  std::vector<StressSeries> all;
  for (const recipes::RecipeInfo& info : recipes::recipe_list()) all.push_back(series_in(std::string(info.name), seed, sensor));
  return all;
}

StressSeries with_few_severities(StressSeries series) {
  const std::vector<double>& all = series.severities;
  if (all.size() > 3) series.severities = {all.front(), all[all.size() / 2], all.back()};
  return series;
}

std::vector<recipes::Recipe> recipes_at(const StressSeries& series, double severity) {
  std::vector<recipes::Recipe> at = series.recipes;
  for (recipes::Recipe& recipe : at) recipe.severity = series.is_file ? recipe.severity * (severity / 100) : severity;
  return at;
}

heatmaps::ChangeEvents change_by(const StressSeries& series, double severity, const std::string& run, events::SensorSize size) {
  std::vector<recipes::Recipe> of_run = recipes_at(series, severity);
  for (recipes::Recipe& recipe : of_run) recipe.seed = seed_for(recipe.seed, {"stress", run});
  struct State {
    recipes::RecipeStream stream;
    std::vector<events::Event> changed{};
  };
  const auto state = std::make_shared<State>(State{recipes::RecipeStream(of_run, size)});
  return [state](std::span<const events::Event> recorded, bool is_last) -> std::span<const events::Event> {
    state->changed.clear();
    if (is_last)
      state->stream.finish(state->changed);
    else
      state->stream.push(recorded, state->changed);
    return state->changed;
  };
}

nlohmann::json json_of(const StressSeries& series, double severity) {
  nlohmann::json json = {{"world", series.world}, {"severity", severity}, {"recipes", nlohmann::json::array()}};
  for (const recipes::Recipe& recipe : recipes_at(series, severity)) json["recipes"].push_back(recipes::json_of(recipe));
  return json;
}

}  // namespace tactile::stress
