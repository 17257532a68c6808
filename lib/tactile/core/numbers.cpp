#include "tactile/core/numbers.hpp"

#include <charconv>

namespace tactile {
namespace {

template <class T>
std::optional<T> parse(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> number_in(std::string_view text) { return parse<double>(text); }

std::optional<std::int64_t> whole_number_in(std::string_view text) { return parse<std::int64_t>(text); }

}  // namespace tactile
