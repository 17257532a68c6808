#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): its authors named it
class App;
class Option;
}  // namespace CLI

// How commands declare their options. These handles hide CLI11, whose headers take three seconds to compile.
namespace tactile::cli {

/// A check of a value. `wrong` returns what is wrong with a text, or nothing. The help shows `right`: "1 to 1024".
struct Check {
  std::function<std::string(std::string&)> wrong;
  std::string right;
  std::vector<std::string> words{};  ///< every right value, if they are few words: the shells complete them
};

/// A declared option. Copies refer to the same option.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option& check(const Check& check);
  Option& suggest(const std::vector<std::string>& words);  ///< the shells complete these; other values are right, too
  Option& show_default();                                  ///< the help shows the variable's present value
  Option& default_text(const std::string& text);           ///< the help shows this text as the default
  Option& type_name(const std::string& name);              ///< stands for the value in the help: "FILE.json"
  Option& required();
  Option& delimiter(char separator);                      ///< between the values of a list
  Option& repeatable();                                   ///< one value each time; all are kept
  Option& one_value_each_time();                          ///< of a list: words after the first value do not belong to the option
  Option& value_is_optional(const std::string& without);  ///< the option alone has this value
  Option& needs(const Option& other);
  Option& excludes(const Option& other);

 private:
  CLI::Option* option_;
};

/// A declared command. Copies refer to the same command.
class Command {
 public:
  explicit Command(CLI::App& command) : command_(&command) {}

  /// @param names    "--out", or "out" for a positional argument
  /// @param value    what the option sets; must outlive the command
  /// @param meaning  for the help
  /// T is one of the types at the end of options.cpp.
  template <class T>
  Option add_option(const std::string& names, T& value, const std::string& meaning = "");

  /// An option that `set` reads; the help shows what `value` returns as its default.
  Option add_text_option(const std::string& names, const std::function<std::string()>& value,
                         const std::function<void(const std::string&)>& set, const std::string& meaning);

  Option add_path_option(const std::string& names, std::filesystem::path& value, const std::string& meaning);

  /// A list with commas: `set` gets its parts, and the help shows what `values` returns as its default.
  Option add_list_option(const std::string& names, const std::function<std::vector<std::string>()>& values,
                         const std::function<void(const std::vector<std::string>&)>& set, const std::string& meaning);

  Option add_flag(const std::string& names, bool& value, const std::string& meaning = "");

  /// An option that may be given many times. `keep` gets each value once it is read, so that the order among options of different
  /// names is known.
  Option add_ordered_option(const std::string& names, const std::function<void(const std::string&)>& keep,
                            const std::string& meaning);

  void hide();  ///< from help, man pages and completions: few people need it, or only another command

 private:
  CLI::App* command_;
};

}  // namespace tactile::cli
