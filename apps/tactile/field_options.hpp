#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "option_checks.hpp"
#include "options.hpp"
#include "tactile/core/enum_names.hpp"
#include "tactile/core/fields.hpp"

namespace tactile::cli {

/// An option with an enumerator by its name. @param names  in the order of the enumerators, whose values count from 0
template <Enumeration T>
Option add_word(Command command, const std::string& option, T& value, std::span<const std::string_view> names,
                const std::string& meaning) {
  const auto text = [&value, names] { return std::string(names[static_cast<std::size_t>(value)]); };
  const auto set = [&value, names, option](const std::string& name) { value = enumerator_named<T>(name, names, option); };
  return command.add_text_option(option, text, set, meaning).check(one_of(names)).show_default();
}

/// An option with a duration of `low` to `high` microseconds, in units of `us` microseconds.
Option add_duration(Command command, const std::string& name, microseconds& value, double low, double high, double us,
                    const std::string& meaning);

/// What `add_field_options` hands to `list_fields`: declares each member that has an OptionText, bound to the member.
class FieldOptions {
 public:
  FieldOptions(Command command, std::vector<std::string_view> left_out) : command_(command), left_out_(std::move(left_out)) {}

  template <class T>
  void operator()(std::string_view, T& value, double low, double high, const OptionText& option = {}) {
    if (is_declared(option))
      complete(command_.add_option(name_of(option), value, meaning_of(option)).check(in_range(T(low), T(high))), option);
  }
  void operator()(std::string_view, microseconds& value, double low, double high, const OptionText& option = {});
  void operator()(std::string_view, std::uint64_t& value, const OptionText& option = {});

  template <Enumeration T>
  void operator()(std::string_view, T& value, std::span<const std::string_view> names, const OptionText& option = {}) {
    if (is_declared(option)) complete(add_word(command_, name_of(option), value, names, meaning_of(option)), option);
  }

  template <class T>
  void operator()(std::string_view, T& value, T (*read)(std::string_view), const OptionText& option = {}) {
    if (!is_declared(option)) return;
    const auto set = [&value, read](const std::string& text) { value = read(text); };
    complete(command_
                 .add_text_option(
                     name_of(option), [&value] { return text_of(value); }, set, meaning_of(option))
                 .check(readable_by(read)),
             option);
  }

 private:
  bool is_declared(const OptionText& option) const {
    return !option.name.empty() && std::find(left_out_.begin(), left_out_.end(), option.name) == left_out_.end();
  }
  static std::string name_of(const OptionText& option) { return "--" + std::string(option.name); }
  static std::string meaning_of(const OptionText& option) { return std::string(option.meaning); }
  static void complete(Option declared, const OptionText& option);

  Command command_;
  std::vector<std::string_view> left_out_;
};

/// Declares the options that a struct of settings lists (tactile/core/fields.hpp).
/// @param settings  must outlive the command
/// @param left_out  names of options that the command lacks, or declares itself: "th"
template <class Settings>
void add_field_options(Command command, Settings& settings, std::vector<std::string_view> left_out = {}) {
  FieldOptions fields(command, std::move(left_out));
  list_fields(fields, settings);
}

/// `--name` with a list of values, each of which `text_of` writes and `read` reads. A value that is given twice counts once.
template <class T, class Text, class Read>
Option add_list(Command command, const std::string& name, std::vector<T>& values, Text text_of, Read read,
                const std::string& meaning) {
  const auto texts = [&values, text_of] {
    std::vector<std::string> all;
    all.reserve(values.size());
    for (const T& value : values) all.push_back(text_of(value));
    return all;
  };
  const auto set = [&values, read](const std::vector<std::string>& given) {
    values.clear();
    for (const std::string& text : given) {
      if (T value = read(text); std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
    }
  };
  return command.add_list_option(name, texts, set, meaning + ", separated by commas").show_default();
}

/// The same with enumerators by their names.
template <Enumeration T>
Option add_word_list(Command command, const std::string& name, std::vector<T>& values, std::span<const std::string_view> names,
                     const std::string& meaning) {
  const auto text = [names](T value) { return std::string(names[static_cast<std::size_t>(value)]); };
  const auto read = [names, name](const std::string& word) { return enumerator_named<T>(word, names, name); };
  return add_list(command, name, values, text, read, meaning).check(one_of(names));
}

/// The same with durations of `low` to `high` microseconds, in units of `us` microseconds.
Option add_duration_list(Command command, const std::string& name, std::vector<microseconds>& values, double low, double high,
                         double us, const std::string& meaning);

/// The same with numbers from `low` to `high`.
Option add_number_list(Command command, const std::string& name, std::vector<double>& values, double low, double high,
                       const std::string& meaning);

/// `--th` with a list of histories [ms].
Option add_histories_option(Command command, std::vector<microseconds>& histories, const std::string& meaning);

}  // namespace tactile::cli
