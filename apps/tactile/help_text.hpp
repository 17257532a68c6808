#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace tactile::cli {

/// Formats a command's help: lines of at most the terminal's width and 100 columns, or 80 without a terminal. A command's own
/// options precede those of all commands.
class HelpText : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

/// An option's value as the help shows it: "N" and "1 to 1024".
struct ValueText {
  std::string name;   ///< stands for the value; empty if the option takes none
  std::string right;  ///< which values are right; empty if all are
};

ValueText value_text(const CLI::Option& option);

/// Whether the option may be given alone, without a value. A flag is not such an option.
bool has_optional_value(const CLI::Option& option);

/// "tactile convert [OPTIONS] IN OUT"
std::string usage_text(const CLI::App& app);

/// An option with its value: "--th X", "-h, --help", "FILE|RUN ...", "--page [PORT]".
std::string typed_of(const CLI::Option& option);

/// What an option means, its right values, what it excludes, and its default.
std::string meaning_of(const CLI::Option& option);

/// Whether every command has this option.
bool is_common(const CLI::Option& option);

/// The commands that the help lists, in their order.
std::vector<CLI::App*> listed_commands(CLI::App& app);
std::vector<const CLI::App*> listed_commands(const CLI::App& app);

/// An option as a user writes it: "--th", or the word for a positional argument, "OUT".
std::string label_of(const CLI::Option& option);

}  // namespace tactile::cli
