#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace tactile {

/// Lays a command's help out: lines of at most as many columns as the terminal has, and 100; 80 where there is none. A command's
/// own options come ahead of those that all commands take.
class HelpText : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

/// What an option takes, for people: "N" and "1 to 1024".
struct ValueText {
  std::string name;   ///< stands for the value; empty where the option takes none
  std::string right;  ///< which values are right; empty where anything may be
};

ValueText value_text(const CLI::Option& option);

/// "tactile convert [OPTIONS] IN OUT"
std::string usage_text(const CLI::App& app);

/// An option as people type it: "--th", or the word that stands for a positional, "OUT".
std::string label_of(const CLI::Option& option);

}  // namespace tactile
