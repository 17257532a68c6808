#pragma once

#include <fmt/core.h>

#include <string>
#include <string_view>
#include <type_traits>

namespace tactile {

/// A reason for a person to look at something. The key names kind and values: it stays where only the wording changes.
struct Doubt {
  std::string key;
  std::string words;

  bool empty() const { return words.empty(); }
};

/// @param words  a format of the values; those that are numbers are part of the key, in three digits
template <class... Values>
Doubt doubt(std::string_view kind, fmt::format_string<const Values&...> words, const Values&... values) {
  Doubt made{.key = std::string(kind), .words = fmt::format(words, values...)};
  [[maybe_unused]] const auto add = [&made](const auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_floating_point_v<Value>)
      made.key += fmt::format(" {:.3g}", value);
    else if constexpr (std::is_arithmetic_v<Value>)
      made.key += fmt::format(" {}", value);
  };
  (add(values), ...);
  return made;
}

}  // namespace tactile
