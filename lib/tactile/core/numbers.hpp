#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace tactile {

/// The whole of `text` as a number, whatever the locale; nothing if it is not one, or out of range.
std::optional<double> number_in(std::string_view text);
std::optional<std::int64_t> whole_number_in(std::string_view text);

}  // namespace tactile
