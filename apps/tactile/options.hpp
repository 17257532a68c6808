#pragma once

#include <functional>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

// How commands declare their options. CLI11 does the work, behind these handles: its headers take seven seconds to compile.
namespace tactile {

/// What a value must be. `wrong` returns what is wrong with a text, or nothing; `right` stands in the help: "1 to 1024".
struct Check {
  std::function<std::string(std::string&)> wrong;
  std::string right;
};

/// An option that was declared. Copies are the same option.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option& check(const Check& check);
  Option& show_default();                         ///< the variable's value, as it is now, stands in the help
  Option& default_text(const std::string& text);  ///< this text stands in the help as the default
  Option& type_name(const std::string& name);     ///< stands for the value in the help: "FILE.json"
  Option& required();
  Option& delimiter(char separator);  ///< between the values of a list
  Option& repeatable();               ///< one value each time, all of them kept
  Option& one_value_each_time();      ///< of a list: words after the first value are not the option's
  Option& needs(const Option& other);
  Option& excludes(const Option& other);

 private:
  CLI::Option* option_;
};

/// A command that was declared. Copies are the same command.
class Command {
 public:
  explicit Command(CLI::App& command) : command_(&command) {}

  /// @param names    "--out", or "out" for a positional argument
  /// @param value    what the option sets; must outlive the command
  /// @param meaning  for the help
  /// T is one of those at the end of options.cpp.
  template <class T>
  Option add_option(const std::string& names, T& value, const std::string& meaning = "");

  Option add_flag(const std::string& names, bool& value, const std::string& meaning = "");

 private:
  CLI::App* command_;
};

}  // namespace tactile
