#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "tactile/core/error.hpp"

namespace tactile {

/// The enumerator with this name. `names` has the names in the order of the enumerators, whose values count from 0.
/// @param what     the setting, for the error
/// @throws Error   "schedule 'x' is unknown; expected constant, cosine or step"
template <class Enum, std::size_t count>
Enum enumerator_named(std::string_view name, const std::array<std::string_view, count>& names, std::string_view what) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<Enum>(found - names.begin());
  std::string expected(names.front());
  for (std::size_t i = 1; i < count; ++i) expected.append(i + 1 < count ? ", " : " or ").append(names[i]);
  throw Error(std::string(what) + " '" + std::string(name) + "' is unknown; expected " + expected);
}

}  // namespace tactile
