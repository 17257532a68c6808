#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "tactile/core/error.hpp"

namespace tactile {

/// The enumerator with this name. `names` has the names in the order of the enumerators, whose values count from 0.
/// @param what     the setting, for the error
/// @throws Error   "schedule 'x' is unknown; expected constant, cosine or step"
template <class Enum>
Enum enumerator_named(std::string_view name, std::span<const std::string_view> names, std::string_view what) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<Enum>(found - names.begin());
  std::string expected(names.front());
  for (std::size_t i = 1; i < names.size(); ++i) expected.append(i + 1 < names.size() ? ", " : " or ").append(names[i]);
  throw Error(std::string(what) + " '" + std::string(name) + "' is unknown; expected " + expected);
}

}  // namespace tactile
