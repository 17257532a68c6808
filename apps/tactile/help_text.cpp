#include "help_text.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <vector>

#include "text_table.hpp"

namespace tactile::cli {
namespace {

constexpr std::array common_names{"--help", "--config", "--print-config", "--json", "--quiet", "--threads"};
constexpr std::size_t text_column = 24;

std::size_t columns() {
  winsize window{};
  if (isatty(STDOUT_FILENO) == 0 || ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col == 0) return 80;
  return std::clamp<std::size_t>(window.ws_col, 60, 100);
}

/// One entry: the option, and its meaning in a separate column.
std::string entry(const std::string& typed, const std::string& meaning) {
  std::string text = "  " + typed;
  if (text.size() + 2 > text_column) {
    text += '\n' + std::string(text_column, ' ');
  } else {
    text.resize(text_column, ' ');
  }
  return text + wrapped(meaning, text_column, columns()) + '\n';
}

/// "; not with --a, --b or --c"; empty if the option goes with all others.
std::string excluded_by(const CLI::Option& option) {
  std::vector<std::string> others;
  for (const CLI::Option* other : option.get_excludes()) others.push_back(label_of(*other));
  std::string text;
  for (std::size_t i = 0; i < others.size(); ++i)
    text += (i == 0 ? "; not with " : i + 1 == others.size() ? " or " : ", ") + others[i];
  return text;
}

/// Whether a text already names every word of "a, b or c", as a description that explains each of them does.
bool names_all(const std::string& text, std::string alternatives) {
  constexpr std::string_view last = " or ", between = ", ";
  if (const std::size_t at = alternatives.rfind(last); at != std::string::npos) alternatives.replace(at, last.size(), between);
  const auto is_in_a_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.'; };
  const auto is_named = [&](const std::string& word) {
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
      const std::size_t end = at + word.size();
      const bool ends = end == text.size() || !is_in_a_word(text[end]) || (text[end] == '.' && end + 1 == text.size());
      if ((at == 0 || !is_in_a_word(text[at - 1])) && ends) return true;
    }
    return false;
  };
  for (std::size_t begin = 0; begin < alternatives.size();) {
    const std::size_t end = std::min(alternatives.find(between, begin), alternatives.size());
    if (!is_named(alternatives.substr(begin, end - begin))) return false;
    begin = end + between.size();
  }
  return true;
}

std::string group(const std::string& title, const std::vector<const CLI::Option*>& options) {
  std::string text;
  for (const CLI::Option* option : options) text += entry(typed_of(*option), meaning_of(*option));
  return text.empty() ? text : "\n" + title + ":\n" + text;
}

}  // namespace

ValueText value_text(const CLI::Option& option) {
  if (option.get_type_size() == 0) return {};
  // CLI11 joins the type's name and the checks' descriptions with colons; a colon in brackets belongs to the name.
  const std::string all = option.get_type_name();
  std::size_t end = 0;
  int depth = 0;
  for (; end < all.size() && (all[end] != ':' || depth > 0); ++end) depth += all[end] == '[' ? 1 : all[end] == ']' ? -1 : 0;
  ValueText text{.name = all.substr(0, end), .right = end < all.size() ? all.substr(end + 1) : ""};
  const bool is_plain = text.name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ") == std::string::npos;
  if (text.name == "INT" || text.name == "UINT") text.name = "N";
  if (text.name == "FLOAT") text.name = "X";
  if (is_plain && text.name == "TEXT") {
    text.name = option.get_positional() ? option.get_name(true) : option.get_single_name();
    std::transform(text.name.begin(), text.name.end(), text.name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    if (!option.get_positional()) text.name = "NAME";
  }
  return text;
}

bool has_optional_value(const CLI::Option& option) { return option.get_expected_min() == 0 && !value_text(option).name.empty(); }

std::string typed_of(const CLI::Option& option) {
  const std::string name = value_text(option).name, value = has_optional_value(option) ? "[" + name + "]" : name;
  std::string text = option.get_positional()         ? value
                     : option.get_name() == "--help" ? "-h, --help"
                     : value.empty()                 ? option.get_name()
                                                     : option.get_name() + " " + value;
  if (option.get_expected_max() == CLI::detail::expected_max_vector_size && !text.ends_with("...")) text += " ...";
  return text;
}

std::string meaning_of(const CLI::Option& option) {
  std::string text = option.get_description();
  if (const std::string right = value_text(option).right; !names_all(text, right)) text += "; " + right;
  text += excluded_by(option);
  std::string usual = option.get_default_str();
  if (usual.size() > 1 && usual.front() == '[' && usual.back() == ']') usual = usual.substr(1, usual.size() - 2);
  if (!usual.empty()) text += (has_optional_value(option) ? " (without a value: " : " (default ") + usual + ")";
  return text;
}

bool is_common(const CLI::Option& option) {
  return std::find(common_names.begin(), common_names.end(), option.get_name()) != common_names.end();
}

std::vector<CLI::App*> listed_commands(CLI::App& app) {
  return app.get_subcommands([](CLI::App* command) { return !command->get_group().empty(); });
}

std::vector<const CLI::App*> listed_commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

std::string label_of(const CLI::Option& option) { return option.get_positional() ? value_text(option).name : option.get_name(); }

std::string usage_text(const CLI::App& app) {
  const bool is_command = app.get_parent() != nullptr;
  std::string text =
      is_command ? app.get_parent()->get_name() + " " + app.get_name() + " [OPTIONS]" : app.get_name() + " COMMAND";
  if (!is_command) return text + " [OPTIONS]";
  for (const CLI::Option* option : app.get_options([](const CLI::Option* o) { return o->get_positional(); })) {
    std::string word = label_of(*option);
    if (option->get_expected_max() == CLI::detail::expected_max_vector_size) word += " ...";
    text += " " + (option->get_required() ? word : "[" + word + "]");
  }
  return text;
}

std::string HelpText::make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const {
  std::string text = wrapped(app->get_description(), 0, columns()) + "\n\nUsage: " + usage_text(*app) + "\n";
  const auto those = [app](const auto& wanted) { return app->get_options(wanted); };
  text += group("Arguments", those([](const CLI::Option* o) { return o->get_positional(); }));
  const std::vector<const CLI::App*> commands = listed_commands(*app);
  if (!commands.empty()) text += "\nCommands:\n";
  for (const CLI::App* command : commands) text += entry(command->get_name(), command->get_description());
  text += group("Options", those([](const CLI::Option* o) { return !o->get_positional() && !is_common(*o); }));
  text += group(commands.empty() ? "Options of every command" : "Help",
                those([](const CLI::Option* o) { return !o->get_positional() && is_common(*o); }));
  if (!commands.empty()) text += "\n'tactile COMMAND --help' shows the options of a command.\n";
  return text;
}

}  // namespace tactile::cli
