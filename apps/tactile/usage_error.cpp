#include "usage_error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "help_text.hpp"
#include "tactile/core/json.hpp"

namespace tactile::cli {
namespace {

std::vector<std::string> long_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options({})) {
    if (!option->get_positional()) names.push_back(option->get_name());
  }
  return names;
}

std::string full_name(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name() : app.get_parent()->get_name() + " " + app.get_name();
}

/// A sentence for superfluous words; empty if there are none.
std::string about_extra_words(const CLI::App& app, const CLI::App& command) {
  const std::vector<std::string> own = app.remaining(false), all = app.remaining(true);
  const auto is_option = [](const std::string& word) { return word.size() > 1 && word.front() == '-'; };
  const auto found = std::find_if(all.begin(), all.end(), is_option);
  if (found == all.end()) {
    return all.empty() ? "" : fmt::format("'{}': is one argument too many; expected '{}'", all.front(), usage_text(command));
  }
  const std::string name = found->substr(0, found->find('='));
  const std::vector<std::string> known = long_names(command);
  const bool is_ahead = &app != &command && std::find(own.begin(), own.end(), *found) != own.end();
  if (is_ahead && std::find(known.begin(), known.end(), name) != known.end())
    return fmt::format("{}: precedes the command; expected '{} {}'", name, full_name(command), *found);
  const std::string nearest = nearest_name(name, known);
  return fmt::format("{}: is not an option of '{}'; {}'{} --help' lists all", name, full_name(command),
                     nearest.empty() ? "" : fmt::format("the nearest is '{}', and ", nearest), full_name(command));
}

/// The option that a message of CLI11 names; null if it names none.
const CLI::Option* option_named_in(const std::string& message, const CLI::App& command) {
  std::istringstream words(message);
  for (std::string word; words >> word;) {
    while (!word.empty() && (word.back() == ':' || word.back() == ',')) word.pop_back();
    for (const CLI::Option* option : command.get_options({})) {
      if (option->get_name() == word) return option;
    }
  }
  return nullptr;
}

std::string expected_value(const CLI::Option& option) {
  const ValueText value = value_text(option);
  const std::string name = option.get_positional() ? "" : option.get_name();
  const std::string whole = name + (name.empty() || value.name.empty() ? "" : " ") + value.name;
  return value.right.empty() ? whole : whole + ", " + value.right;
}

std::string about_option(const CLI::Option& option, const CLI::ParseError& error, const CLI::App& command) {
  const std::string label = label_of(option);
  const std::string message = error.what();
  if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) {
    const std::string begin = option.get_name() + ": ";
    return message.starts_with(begin) ? label + ": " + message.substr(begin.size()) : message;
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    return fmt::format("{}: is missing; expected {}", label,
                       option.get_positional() ? "'" + usage_text(command) + "'" : expected_value(option));
  }
  if (dynamic_cast<const CLI::RequiresError*>(&error) != nullptr) {
    for (const CLI::Option* other : option.get_needs()) {
      if (other->count() == 0)
        return fmt::format("{}: {} is missing; expected {}, too", label, label_of(*other), expected_value(*other));
    }
  }
  if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) {
    for (const CLI::Option* other : option.get_excludes()) {
      if (other->count() > 0) return fmt::format("{}: cannot be used with {}; expected one of the two", label, label_of(*other));
    }
  }
  if (value_text(option).name.empty()) return fmt::format("{}: takes no value; expected none", label);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    return option.count() > 1 ? fmt::format("{}: is given {} times; expected it once", label, option.count())
                              : fmt::format("{}: has no value; expected {}", label, expected_value(option));
  }
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr && !option.results().empty())
    return fmt::format("{}: '{}' cannot be read; expected {}", label, option.results().back(), expected_value(option));
  return message;
}

}  // namespace

UsageError usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  const CLI::App& command = given.empty() ? app : *given.front();
  // The missing argument may be misspelt.
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) ||
      error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError)) {
    if (const std::string about = about_extra_words(app, command); !about.empty())
      return {about, static_cast<int>(CLI::ExitCodes::ExtrasError)};
  }
  if (given.empty()) return {"there is no command; expected one that 'tactile --help' lists", error.get_exit_code()};
  const CLI::Option* option = option_named_in(error.what(), command);
  return {option == nullptr ? error.what() : about_option(*option, error, command), error.get_exit_code()};
}

}  // namespace tactile::cli
