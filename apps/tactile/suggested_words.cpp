#include "suggested_words.hpp"

#include "tactile/recipes/recipe.hpp"
#include "tactile/simulation/physics.hpp"

namespace tactile::cli {

std::vector<std::string> simulated_objects() {
  std::vector<std::string> names;
  for (const simulation::ObjectModel& object : simulation::default_physics().objects) names.push_back(object.name);
  names.emplace_back("all");
  return names;
}

std::vector<std::string> recipe_names() {
  std::vector<std::string> names;
  for (const recipes::RecipeInfo& recipe : recipes::recipe_list()) names.emplace_back(recipe.name);
  return names;
}

}  // namespace tactile::cli
