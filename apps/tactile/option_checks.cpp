#include "option_checks.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/run_numbers.hpp"

namespace tactile::cli {
namespace {

std::string number_text(double value) {
  return value == std::floor(value) && std::abs(value) < 1e15 ? fmt::format("{}", static_cast<std::int64_t>(value))
                                                              : fmt::format("{:g}", value);
}

/// "a, b or c"
std::string alternatives(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

}  // namespace

std::string range_text(double low, double high) { return number_text(low) + " to " + number_text(high); }

std::string check_number(const std::string& text, bool whole, double low, double high) {
  const std::optional<double> value = number_in(text);
  if (!value || std::isnan(*value)) return fmt::format("'{}' is not a number; expected {}", text, range_text(low, high));
  if (whole && !whole_number_in(text) && *value >= low && *value <= high)
    return fmt::format("{} is not a whole number; expected {}", text, range_text(low, high));
  if (*value < low || *value > high) return fmt::format("{} is out of range; expected {}", text, range_text(low, high));
  return "";
}

Check one_of(std::initializer_list<std::string_view> words) { return one_of(std::span(words.begin(), words.size())); }

Check one_of(std::span<const std::string_view> words) {
  const std::vector<std::string> known(words.begin(), words.end());
  return Check{[known](std::string& text) {
                 return std::find(known.begin(), known.end(), text) != known.end()
                            ? std::string()
                            : fmt::format("'{}' is unknown; expected {}", text, alternatives(known));
               },
               alternatives(known), known};
}

Check is_duration(double low, double high, double us) {
  return Check{[=](std::string& text) {
                 if (std::string wrong = check_number(text, us == 1, low / us, high / us); !wrong.empty()) return wrong;
                 const double duration = number_in(text).value_or(0) * us;
                 return std::abs(duration - std::round(duration)) > 1e-6
                            ? fmt::format("{} is not a whole number of us; expected at most three decimals", text)
                            : std::string();
               },
               range_text(low / us, high / us)};
}

Check is_run() {
  return Check{[](std::string& text) {
                 if (is_run_id(text)) return std::string();
                 const auto number = whole_number_in(text);
                 const bool is_number = number && *number >= 1 && *number <= most_runs;
                 return fmt::format("'{}' is not the id of a run; expected {}", text,
                                    is_number ? run_id_of(static_cast<int>(*number)) : "two digits from 01 on");
               },
               ""};
}

Check is_seed() {
  return Check{[](std::string& text) {
                 std::uint64_t seed = 0;
                 const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
                 return error == std::errc{} && end == text.data() + text.size()
                            ? std::string()
                            : fmt::format("'{}' is not a seed; expected a whole number from 0 to 18446744073709551615", text);
               },
               "0 to 18446744073709551615"};
}

Check is_existing_file() {
  return Check{[](std::string& text) {
                 std::error_code failed;
                 if (std::filesystem::is_directory(text, failed)) return fmt::format("{} is a folder; expected a file", text);
                 return std::filesystem::exists(text, failed)
                            ? std::string()
                            : fmt::format("there is no {}; expected a file that can be read", text);
               },
               ""};
}

void add_strict_option(Command command, bool& strict) {
  command.add_flag("--strict", strict, "Stop with an error if an object has no run with samples; default: leave the object out");
}

}  // namespace tactile::cli
