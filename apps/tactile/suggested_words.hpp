#pragma once

#include <string>
#include <vector>

// Words that shells offer for values that may also be other words.
namespace tactile::cli {

/// For `--objects`: the objects that are simulated, in the paper's order, and "all".
std::vector<std::string> simulated_objects();

/// For `--stress` and `--recipe`: the names of all recipes, in the order of the documentation.
std::vector<std::string> recipe_names();

}  // namespace tactile::cli
