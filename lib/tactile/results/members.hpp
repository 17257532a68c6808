#pragma once

#include <concepts>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/time.hpp"
#include "tactile/results/figure.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::results {

// A result names its members once, by a function next to it:
//
//   template <class Members>
//   void list_members(Members& members, OperatingPoint& point) {
//     members("threshold", point.threshold);  // a number (NaN is null), a count, text, a bool, a time [ms], JSON, a result, or
//     members("missed", point.missed);        // an optional, a list or a map by name of these
//   }
//
// and `to_json` and `from_json` follow.

/// What `to_json` hands to `list_members`.
class MemberWriter {
 public:
  const nlohmann::json& json() const { return json_; }

  template <class T>
  void operator()(const char* name, const T& value) {
    json_[name] = json_of(value);
  }

 private:
  static nlohmann::json json_of(double value) { return number_or_null(value); }
  static nlohmann::json json_of(microseconds value) { return in_ms(value); }
  template <class T>
  static nlohmann::json json_of(const T& value) {
    return value;
  }
  template <class T>
  static nlohmann::json json_of(const std::optional<T>& value) {
    return value ? json_of(*value) : nlohmann::json();
  }

  nlohmann::json json_ = nlohmann::json::object();
};

/// What `from_json` hands to `list_members`. A member that is missing is as one that is null.
class MemberReader {
 public:
  explicit MemberReader(JsonView json) : json_(std::move(json)) {}

  template <class T>
  void operator()(const char* name, T& value) const {
    read(json_[name], value);
  }

 private:
  static void read(const JsonView& json, double& value) { value = json.number(); }
  static void read(const JsonView& json, bool& value) { value = json.truth(); }
  static void read(const JsonView& json, std::string& value) { value = json.text(); }
  static void read(const JsonView& json, microseconds& value) { value = json.milliseconds(); }
  static void read(const JsonView& json, nlohmann::json& value) { value = json.copy(); }
  template <std::unsigned_integral T>
  static void read(const JsonView& json, T& value) {
    value = static_cast<T>(json.count());
  }
  template <class T>
  static void read(const JsonView& json, T& value) {
    value = json.get<T>();
  }
  template <class T>
  static void read(const JsonView& json, std::optional<T>& value) {
    value.reset();
    if (json) read(json, value.emplace());
  }
  template <class T>
  static void read(const JsonView& json, std::vector<T>& values) {
    values.clear();
    for (const JsonView& item : json.items()) read(item, values.emplace_back());
  }
  template <class T>
  static void read(const JsonView& json, std::map<std::string, T>& values) {
    values.clear();
    for (const auto& [name, member] : json.members()) read(member, values[name]);
  }

  JsonView json_;
};

template <class T>
concept ListsMembers = requires(MemberWriter& members, T& result) {
  list_members(members, result);
};

template <ListsMembers T>
void to_json(nlohmann::json& json, const T& result) {
  T copy = result;  // one list serves reading and writing
  MemberWriter members;
  list_members(members, copy);
  json = members.json();
}

template <ListsMembers T>
void from_json(const JsonView& json, T& result) {
  MemberReader members(json);
  list_members(members, result);
}

}  // namespace tactile::results
