#include "tactile/core/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactile {
namespace {

/// A value for a message: a number or a short text itself, anything else by its type.
std::string shown(const nlohmann::json& json) {
  constexpr std::size_t longest = 40;
  if (json.is_object()) return "an object";
  if (json.is_array() && json.size() > 4) return "a list";
  const std::string text = json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return text.size() <= longest ? text : text.substr(0, longest) + "...";
}

bool lies_in(double value, double low, double high) { return std::isfinite(value) && low <= value && value <= high; }

std::string from_to(double low, double high) { return fmt::format("{} to {}", low, high); }

}  // namespace

FieldReader::FieldReader(const nlohmann::json& json, std::string where, std::string prefix, Missing missing)
    : json_(json), where_(std::move(where)), prefix_(std::move(prefix)), missing_(missing) {
  if (json.is_object()) return;
  const std::string name = prefix_.empty() ? "the whole" : prefix_.substr(0, prefix_.size() - 1);
  throw Error(fmt::format("{}: {} is {}; expected an object of settings", where_, name, shown(json)));
}

void FieldReader::operator()(std::string_view name, double& value, double low, double high, const OptionText&) {
  if (const nlohmann::json* json = find(name)) value = number(name, *json, low, high);
}

void FieldReader::operator()(std::string_view name, microseconds& value, double low, double high, const OptionText&) {
  if (const nlohmann::json* json = find(name)) value = microseconds{whole_number(name, *json, low, high)};
}

void FieldReader::operator()(std::string_view name, bool& value, const OptionText&) {
  const nlohmann::json* json = find(name);
  if (json == nullptr) return;
  if (!json->is_boolean()) refuse(name, *json, "true or false");
  value = json->get<bool>();
}

void FieldReader::operator()(std::string_view name, std::string& value, const OptionText&) {
  if (const nlohmann::json* json = find(name)) value = text(name, *json);
}

void FieldReader::operator()(std::string_view name, std::uint64_t& value, const OptionText&) {
  const nlohmann::json* json = find(name);
  if (json == nullptr) return;
  const bool is_sound = json->is_number_unsigned() || (json->is_number_integer() && json->get<std::int64_t>() >= 0);
  if (!is_sound) refuse(name, *json, "a whole number from 0 to 18446744073709551615");
  value = json->get<std::uint64_t>();
}

void FieldReader::operator()(std::string_view name, std::vector<double>& values, double low, double high) {
  constexpr std::size_t most = 1000;
  const nlohmann::json* json = find(name);
  if (json == nullptr) return;
  const auto is_sound = [&](const nlohmann::json& number) {
    return number.is_number() && lies_in(number.get<double>(), low, high);
  };
  const bool sound =
      json->is_array() && !json->empty() && json->size() <= most && std::all_of(json->begin(), json->end(), is_sound);
  if (!sound || !std::is_sorted(json->begin(), json->end()))
    refuse(name, *json, fmt::format("1 to {} ascending numbers from {}", most, from_to(low, high)));
  values = json->get<std::vector<double>>();
}

void FieldReader::refuse_others() const {
  for (const auto& [key, value] : json_.items()) {
    if (std::find(names_.begin(), names_.end(), key) != names_.end()) continue;
    const std::string nearest = nearest_name(key, names_);
    if (!nearest.empty())
      throw Error(fmt::format("{}: there is no '{}{}'; the nearest is '{}{}'", where_, prefix_, key, prefix_, nearest));
    throw Error(names_.empty()
                    ? fmt::format("{}: there is no '{}{}'; expected nothing there", where_, prefix_, key)
                    : fmt::format("{}: there is no '{}{}'; expected one of {}", where_, prefix_, key, fmt::join(names_, ", ")));
  }
}

const nlohmann::json* FieldReader::find(std::string_view name) {
  names_.emplace_back(name);
  const auto found = json_.find(names_.back());
  if (found != json_.end()) return &*found;
  if (missing_ == Missing::is_an_error) throw Error(fmt::format("{}: '{}{}' is missing", where_, prefix_, name));
  return nullptr;
}

double FieldReader::number(std::string_view name, const nlohmann::json& json, double low, double high) const {
  if (!json.is_number() || !lies_in(json.get<double>(), low, high)) refuse(name, json, from_to(low, high));
  return json.get<double>();
}

std::int64_t FieldReader::whole_number(std::string_view name, const nlohmann::json& json, double low, double high) const {
  const std::string expected = "a whole number from " + from_to(low, high);
  if (!json.is_number_integer() || !lies_in(json.get<double>(), low, high)) refuse(name, json, expected);
  // As a double, a limit of 2^63 would be accepted.
  if (json.is_number_unsigned() && !std::in_range<std::int64_t>(json.get<std::uint64_t>())) refuse(name, json, expected);
  return json.get<std::int64_t>();
}

std::pair<double, double> FieldReader::range(std::string_view name, const nlohmann::json& json, double low, double high) const {
  const bool sound = json.is_array() && json.size() == 2 && json[0].is_number() && json[1].is_number() &&
                     lies_in(json[0].get<double>(), low, high) && lies_in(json[1].get<double>(), low, high) &&
                     json[0].get<double>() <= json[1].get<double>();
  if (!sound) refuse(name, json, "[low, high], ascending, from " + from_to(low, high));
  return {json[0].get<double>(), json[1].get<double>()};
}

std::pair<int, int> FieldReader::size(std::string_view name, const nlohmann::json& json, double low, double high) const {
  const bool sound = json.is_array() && json.size() == 2 && json[0].is_number_integer() && json[1].is_number_integer() &&
                     lies_in(json[0].get<double>(), low, high) && lies_in(json[1].get<double>(), low, high);
  if (!sound) refuse(name, json, "[width, height], whole numbers from " + from_to(low, high));
  return {json[0].get<int>(), json[1].get<int>()};
}

std::size_t FieldReader::place_in(std::span<const std::string_view> names, std::string_view name,
                                  const nlohmann::json& json) const {
  const auto found = std::find(names.begin(), names.end(), text(name, json));
  if (found == names.end()) refuse(name, json, fmt::format("one of {}", fmt::join(names, ", ")));
  return static_cast<std::size_t>(found - names.begin());
}

std::string FieldReader::text(std::string_view name, const nlohmann::json& json) const {
  if (!json.is_string()) refuse(name, json, "a text");
  return json.get<std::string>();
}

std::string OptionLister::shortest(double value) { return fmt::format("{}", value); }

void FieldReader::refuse(std::string_view name, const nlohmann::json& json, const std::string& expected) const {
  throw Error(fmt::format("{}: {}{} is {}; expected {}", where_, prefix_, name, shown(json), expected));
}

}  // namespace tactile
