#include "effective_settings.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactile::cli {
namespace {

constexpr std::array<std::string_view, 8> left_out{"help",  "config",  "print-config", "json",
                                                   "quiet", "verbose", "force",        "resume"};

/// The text as a number if it is written as JSON writes that number, else the text: "01" stays a text.
nlohmann::json value_in(const std::string& text) {
  const nlohmann::json number = nlohmann::json::parse(text, nullptr, false);
  return number.is_number() && number.dump() == text ? number : nlohmann::json(text);
}

/// The present value of the option's variable as CLI11 writes it; nothing if the help does not show it as the default.
std::optional<std::string> default_of(CLI::Option& option) {
  const std::string shown = option.get_default_str();
  option.capture_default_str();
  const std::string value = option.get_default_str();
  option.default_str(shown);
  if (shown.empty() || value != shown) return std::nullopt;
  return value;
}

/// "[a,b]" as {"a", "b"}
std::vector<std::string> elements_of(const std::string& list) {
  std::vector<std::string> elements;
  if (list.size() < 3 || list.front() != '[' || list.back() != ']') return elements;
  std::string_view rest(list);
  rest = rest.substr(1, rest.size() - 2);
  while (true) {
    const std::size_t comma = rest.find(',');
    elements.emplace_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) return elements;
    rest.remove_prefix(comma + 1);
  }
}

nlohmann::json list_of(const std::vector<std::string>& texts) {
  nlohmann::json list = nlohmann::json::array();
  for (const std::string& text : texts) list.push_back(value_in(text));
  return list;
}

/// The option's value; null if it has none.
nlohmann::json value_of(CLI::Option& option) {
  const bool is_flag = option.get_items_expected_max() == 0, is_list = option.get_items_expected_max() > 1;
  const std::vector<std::string>& given = option.results();
  if (is_flag) return !given.empty() && given.back() != "false";
  if (!given.empty()) return is_list || given.size() > 1 ? list_of(given) : value_in(given.front());
  const std::optional<std::string> value = default_of(option);
  if (!value) return nullptr;
  if (!is_list) return value_in(*value);
  const std::vector<std::string> elements = elements_of(*value);
  return elements.empty() ? nlohmann::json() : list_of(elements);
}

}  // namespace

nlohmann::json effective_settings(CLI::App& command) {
  nlohmann::json settings = nlohmann::json::object();
  for (CLI::Option* option : command.get_options([](CLI::Option*) { return true; })) {
    const std::string name = option->get_single_name();
    if (std::find(left_out.begin(), left_out.end(), name) != left_out.end()) continue;
    if (nlohmann::json value = value_of(*option); !value.is_null()) settings[name] = std::move(value);
  }
  return settings;
}

}  // namespace tactile::cli
