#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "tactile/core/enum_names.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/time.hpp"

namespace tactile {

// A struct of settings names its members once, by a function next to it:
//
//   template <class Fields>
//   void list_fields(Fields& fields, RobotPhysics& robot) {
//     fields("rate_hz", robot.rate_hz, 1, 1000);             // a number and the range it must lie in
//     fields("speed_noise_mm_s", robot.speed_noise_mm_s, 0, 100);  // a Range: [low, high], both in it, low <= high
//     fields("refractory_us", camera.refractory, 1, 1'000'000);  // a duration, as a whole number of microseconds
//     fields("hot_hz", camera.hot_hz, 0, 1e6);               // 1 to 1000 ascending numbers, each in the range
//     fields("size", camera.size, 16, 4096);                 // a SensorSize: [width, height], both in it
//     fields("name", robot.name);                            // text, bool, a struct that lists its fields too, or a map of such
//     fields("seed", robot.seed);                            // any std::uint64_t
//     fields("schedule", options.schedule, schedule_names);  // an enumerator by its name
//     fields("augment", options.augmentation, augmentation_named);  // a value by its text, which `text_of` gives
//   }
//
// and `read_fields`, `json_of_fields` and `check_fields` do the rest. An OptionText at the end also makes the member an option of
// commands (apps/tactile/field_options.hpp).

/// A member of settings on the command line.
struct OptionText {
  std::string_view name;         ///< "lr", without the dashes in front
  std::string_view meaning;      ///< for the help
  std::string_view values = {};  ///< stands for the value in the help, such as "NAME,..."; empty: by the member's type
  double us = 1;                 ///< of a duration: microseconds in the option's unit
};

/// Puts the members of `json` into `settings`; those that it lacks keep their values. A map takes no names but those it has.
/// @throws Error  naming `where` and the member ("camera.threshold"): no such member (and the nearest name), of another type, or
///                out of its range
template <class Settings>
void read_fields(const nlohmann::json& json, Settings& settings, const std::string& where);

/// The same for JSON that must have every member, as a file has that a program wrote. @throws Error  also if one is missing
template <class Settings>
void read_all_fields(const nlohmann::json& json, Settings& settings, const std::string& where);

/// @throws Error  naming `where` and the first member that is out of its range
template <class Settings>
void check_fields(const Settings& settings, const std::string& where);

/// All members. `read_fields` of it gives the same settings.
template <class Settings>
nlohmann::json json_of_fields(const Settings& settings);

/// An option of a command, and its value as a person types it.
struct OptionValue {
  std::string name;  ///< "--lr"
  std::string text;
};

/// The options of the members that differ from `usual`.
template <class Settings>
std::vector<OptionValue> options_off(const Settings& settings, const Settings& usual = {});

/// Two numbers that bound a range.
template <class T>
concept LowAndHigh = std::is_same_v<decltype(T::low), double> && std::is_same_v<decltype(T::high), double>;

/// Two whole numbers that say how large something is.
template <class T>
concept WidthAndHeight = std::is_same_v<decltype(T::width), int> && std::is_same_v<decltype(T::height), int>;

template <class T>
concept WholeNumber = std::is_integral_v<T> && !std::is_same_v<T, bool>;

template <class T>
concept Enumeration = std::is_enum_v<T>;

/// What `read_fields` hands to `list_fields`.
class FieldReader {
 public:
  enum class Missing : std::uint8_t { keeps_its_value, is_an_error };

  /// @param where   the file, or what stands for it
  /// @param prefix  of this struct's members, such as "camera."; empty at the top
  /// @param missing  how a member is taken that `json` lacks
  /// @throws Error  if `json` is no object
  FieldReader(const nlohmann::json& json, std::string where, std::string prefix, Missing missing = Missing::keeps_its_value);

  void operator()(std::string_view name, double& value, double low, double high, const OptionText& = {});
  void operator()(std::string_view name, microseconds& value, double low, double high, const OptionText& = {});
  void operator()(std::string_view name, bool& value, const OptionText& = {});
  void operator()(std::string_view name, std::string& value, const OptionText& = {});
  void operator()(std::string_view name, std::uint64_t& value, const OptionText& = {});
  void operator()(std::string_view name, std::vector<double>& values, double low, double high);

  template <Enumeration T>
  void operator()(std::string_view name, T& value, std::span<const std::string_view> names, const OptionText& = {}) {
    if (const nlohmann::json* json = find(name)) value = static_cast<T>(place_in(names, name, *json));
  }

  template <class T>
  void operator()(std::string_view name, T& value, T (*read)(std::string_view), const OptionText& = {}) {
    if (const nlohmann::json* json = find(name)) value = read(text(name, *json));
  }

  template <WholeNumber T>
  void operator()(std::string_view name, T& value, double low, double high, const OptionText& = {}) {
    if (const nlohmann::json* json = find(name)) {
      constexpr auto lowest = static_cast<double>(std::numeric_limits<T>::min());
      constexpr auto highest = static_cast<double>(std::numeric_limits<T>::max());
      value = static_cast<T>(whole_number(name, *json, std::max(low, lowest), std::min(high, highest)));
    }
  }

  template <LowAndHigh T>
  void operator()(std::string_view name, T& value, double low, double high) {
    if (const nlohmann::json* json = find(name)) std::tie(value.low, value.high) = range(name, *json, low, high);
  }

  template <WidthAndHeight T>
  void operator()(std::string_view name, T& value, double low, double high) {
    if (const nlohmann::json* json = find(name)) std::tie(value.width, value.height) = size(name, *json, low, high);
  }

  template <class T>
  void operator()(std::string_view name, std::map<std::string, T>& values) {
    const nlohmann::json* json = find(name);
    if (json == nullptr) return;
    FieldReader members(*json, where_, prefix_ + std::string(name) + ".");
    for (auto& [key, value] : values) members(key, value);
    members.refuse_others();
  }

  template <class T>
  void operator()(std::string_view name, T& value) {
    const nlohmann::json* json = find(name);
    if (json == nullptr) return;
    FieldReader members(*json, where_, prefix_ + std::string(name) + ".", missing_);
    list_fields(members, value);
    members.refuse_others();
  }

  /// A member that is read elsewhere; nothing if there is none.
  const nlohmann::json* find(std::string_view name);

  /// To be called once all members are listed. @throws Error  if there is one that was not
  void refuse_others() const;

 private:
  double number(std::string_view name, const nlohmann::json& json, double low, double high) const;
  std::int64_t whole_number(std::string_view name, const nlohmann::json& json, double low, double high) const;
  std::pair<double, double> range(std::string_view name, const nlohmann::json& json, double low, double high) const;
  std::pair<int, int> size(std::string_view name, const nlohmann::json& json, double low, double high) const;
  std::size_t place_in(std::span<const std::string_view> names, std::string_view name, const nlohmann::json& json) const;
  std::string text(std::string_view name, const nlohmann::json& json) const;
  [[noreturn]] void refuse(std::string_view name, const nlohmann::json& json, const std::string& expected) const;

  const nlohmann::json& json_;
  std::string where_, prefix_;
  Missing missing_;
  std::vector<std::string> names_;
};

/// What `json_of_fields` hands to `list_fields`.
class FieldWriter {
 public:
  const nlohmann::json& json() const { return json_; }

  void operator()(const std::string& name, double& value, double, double, const OptionText& = {}) { json_[name] = value; }
  void operator()(const std::string& name, microseconds& value, double, double, const OptionText& = {}) {
    json_[name] = value.count();
  }
  void operator()(const std::string& name, bool& value, const OptionText& = {}) { json_[name] = value; }
  void operator()(const std::string& name, std::string& value, const OptionText& = {}) { json_[name] = value; }
  void operator()(const std::string& name, std::uint64_t& value, const OptionText& = {}) { json_[name] = value; }
  void operator()(const std::string& name, std::vector<double>& values, double, double) { json_[name] = values; }

  template <Enumeration T>
  void operator()(const std::string& name, T& value, std::span<const std::string_view> names, const OptionText& = {}) {
    json_[name] = names[static_cast<std::size_t>(value)];
  }

  template <class T>
  void operator()(const std::string& name, T& value, T (*)(std::string_view), const OptionText& = {}) {
    json_[name] = text_of(value);
  }

  template <WholeNumber T>
  void operator()(const std::string& name, T& value, double, double, const OptionText& = {}) {
    json_[name] = value;
  }

  template <LowAndHigh T>
  void operator()(const std::string& name, T& value, double, double) {
    json_[name] = nlohmann::json::array({value.low, value.high});
  }

  template <WidthAndHeight T>
  void operator()(const std::string& name, T& value, double, double) {
    json_[name] = nlohmann::json::array({value.width, value.height});
  }

  template <class T>
  void operator()(const std::string& name, std::map<std::string, T>& values) {
    FieldWriter members;
    for (auto& [key, value] : values) members(key, value);
    json_[name] = members.json_;
  }

  template <class T>
  void operator()(const std::string& name, T& value) {
    FieldWriter members;
    list_fields(members, value);
    json_[name] = members.json_;
  }

 private:
  nlohmann::json json_ = nlohmann::json::object();
};

/// What `options_off` hands to `list_fields`.
class OptionLister {
 public:
  std::vector<OptionValue> options{};

  void operator()(std::string_view, double& value, double, double, const OptionText& option = {}) {
    add(option, shortest(value));
  }
  void operator()(std::string_view, microseconds& value, double, double, const OptionText& option = {}) {
    add(option, shortest(static_cast<double>(value.count()) / option.us));
  }
  void operator()(std::string_view, std::uint64_t& value, const OptionText& option = {}) { add(option, std::to_string(value)); }

  template <Enumeration T>
  void operator()(std::string_view, T& value, std::span<const std::string_view> names, const OptionText& option = {}) {
    add(option, std::string(names[static_cast<std::size_t>(value)]));
  }

  template <class T>
  void operator()(std::string_view, T& value, T (*)(std::string_view), const OptionText& option = {}) {
    add(option, text_of(value));
  }

  template <WholeNumber T>
  void operator()(std::string_view, T& value, double, double, const OptionText& option = {}) {
    add(option, std::to_string(value));
  }

 private:
  static std::string shortest(double value);
  void add(const OptionText& option, std::string text) {
    if (!option.name.empty()) options.push_back({"--" + std::string(option.name), std::move(text)});
  }
};

template <class Settings>
std::vector<OptionValue> options_off(const Settings& settings, const Settings& usual) {
  Settings copy = settings, usual_copy = usual;
  OptionLister these, usually;
  list_fields(these, copy);
  list_fields(usually, usual_copy);
  std::vector<OptionValue> off;
  for (std::size_t i = 0; i < these.options.size(); ++i) {
    if (these.options[i].text != usually.options[i].text) off.push_back(these.options[i]);
  }
  return off;
}

template <class Settings>
void read_fields(const nlohmann::json& json, Settings& settings, const std::string& where) {
  FieldReader members(json, where, {});
  list_fields(members, settings);
  members.refuse_others();
}

template <class Settings>
void read_all_fields(const nlohmann::json& json, Settings& settings, const std::string& where) {
  FieldReader members(json, where, {}, FieldReader::Missing::is_an_error);
  list_fields(members, settings);
  members.refuse_others();
}

template <class Settings>
void check_fields(const Settings& settings, const std::string& where) {
  Settings copy;
  read_all_fields(json_of_fields(settings), copy, where);
}

template <class Settings>
nlohmann::json json_of_fields(const Settings& settings) {
  Settings copy = settings;  // one list of fields serves reading and writing
  FieldWriter members;
  list_fields(members, copy);
  return members.json();
}

}  // namespace tactile
