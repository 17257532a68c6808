#include "tactile/results/json_view.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::results {

void JsonView::refuse(std::string_view expected) const {
  throw Error(fmt::format("{} is {}; expected {}", where_, json_->type_name(), expected));
}

JsonView JsonView::operator[](std::string_view key) const {
  if (json_ != nullptr && !json_->is_object()) refuse("an object");
  const nlohmann::json* found = nullptr;
  if (json_ != nullptr) {
    if (const auto at = json_->find(std::string(key)); at != json_->end()) found = &*at;
  }
  if (found == nullptr && missing_ == MissingMember::is_error) throw_bad_member(key, where_, "is missing");
  return {found == nullptr || found->is_null() ? nullptr : found, fmt::format("{}: '{}'", where_, key), missing_};
}

JsonView JsonView::renamed(std::string_view key, std::string_view earlier_key) const {
  const bool has_earlier = json_ != nullptr && json_->contains(std::string(earlier_key)) && !json_->contains(std::string(key));
  return (*this)[has_earlier ? earlier_key : key];
}

std::vector<JsonView> JsonView::items() const {
  std::vector<JsonView> items;
  if (json_ == nullptr) return items;
  if (!json_->is_array()) refuse("a list");
  for (const nlohmann::json& item : *json_) items.push_back({item.is_null() ? nullptr : &item, where_, missing_});
  return items;
}

std::vector<std::pair<std::string, JsonView>> JsonView::members() const {
  std::vector<std::pair<std::string, JsonView>> members;
  if (json_ == nullptr) return members;
  if (!json_->is_object()) refuse("an object");
  for (auto it = json_->begin(); it != json_->end(); ++it) members.emplace_back(it.key(), (*this)[it.key()]);
  return members;
}

double JsonView::number() const { return number_if_there().value_or(std::numeric_limits<double>::quiet_NaN()); }

std::optional<double> JsonView::number_if_there() const {
  if (json_ == nullptr) return std::nullopt;
  if (!json_->is_number()) refuse("a number");
  return json_->get<double>();
}

std::int64_t JsonView::whole_number() const {
  if (json_ == nullptr) return 0;
  const bool fits =
      json_->is_number_integer() && (!json_->is_number_unsigned() || std::in_range<std::int64_t>(json_->get<std::uint64_t>()));
  if (!fits) refuse("a whole number");
  return json_->get<std::int64_t>();
}

std::uint64_t JsonView::count() const { return count_if_there().value_or(0); }

std::optional<std::uint64_t> JsonView::count_if_there() const {
  if (json_ == nullptr) return std::nullopt;
  if (!json_->is_number_unsigned()) refuse("a whole number from 0");
  return json_->get<std::uint64_t>();
}

microseconds JsonView::milliseconds() const { return microseconds{std::llround(1000 * number_if_there().value_or(0))}; }

bool JsonView::truth() const {
  if (json_ == nullptr) return false;
  if (!json_->is_boolean()) refuse("true or false");
  return json_->get<bool>();
}

std::string JsonView::text() const {
  if (json_ == nullptr) return {};
  if (!json_->is_string()) refuse("text");
  return json_->get<std::string>();
}

std::vector<std::string> JsonView::texts() const {
  std::vector<std::string> texts;
  for (const JsonView& item : items()) texts.push_back(item.text());
  return texts;
}

std::vector<std::uint64_t> JsonView::counts() const {
  std::vector<std::uint64_t> counts;
  if (json_ == nullptr) return counts;
  if (!json_->is_array()) refuse("a list");
  for (const nlohmann::json& item : *json_) {  // there may be very many: no view of each
    if (!item.is_number_unsigned()) throw Error(where_ + " has a value that is not a whole number from 0 on");
    counts.push_back(item.get<std::uint64_t>());
  }
  return counts;
}

nlohmann::json JsonView::copy() const { return json_ == nullptr ? nlohmann::json() : *json_; }

std::string JsonView::words() const {
  if (json_ == nullptr) return "-";
  if (json_->is_string()) return json_->get<std::string>();
  if (json_->is_number_float()) return fmt::format("{:.6g}", json_->get<double>());
  if (json_->is_boolean()) return json_->get<bool>() ? "yes" : "no";
  if (json_->is_array()) {
    std::string words;
    for (const JsonView& item : items()) words += (words.empty() ? "" : ", ") + item.words();
    return words.empty() ? "none" : words;
  }
  return json_->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::json text_or_null(const std::string& text) { return text.empty() ? nlohmann::json() : nlohmann::json(text); }

}  // namespace tactile::results
