#include "manual_page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "help_text.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/version.hpp"

namespace tactile::cli {
namespace {

/// The code point of a UTF-8 character of 2 to 4 bytes.
unsigned code_point(std::string_view character) {
  const auto first = static_cast<unsigned char>(character.front());
  unsigned code = first & (0xFFU >> (character.size() + 1));
  for (const char next : character.substr(1)) code = code << 6U | (static_cast<unsigned char>(next) & 0x3FU);
  return code;
}

/// `text` as a line of roff, in which no character has another meaning. Hyphens stay as they are typed.
std::string in_roff(std::string_view text) {
  std::string line = !text.empty() && (text.front() == '.' || text.front() == '\'') ? "\\&" : "";
  while (!text.empty()) {
    const std::size_t length = std::clamp<std::size_t>(character_at(text), 1, text.size());
    const std::string_view character = text.substr(0, length);
    if (length > 1) {
      line += fmt::format("\\[u{:04X}]", code_point(character));
    } else if (character == "\\") {
      line += "\\(rs";
    } else if (character == "-") {
      line += "\\-";
    } else if (character == "'") {
      line += "\\(aq";
    } else {
      line += character;
    }
    text.remove_prefix(length);
  }
  return line;
}

/// The option in bold, its value in italics.
std::string tag_of(const CLI::Option& option) {
  const std::string typed = typed_of(option);
  if (option.get_positional()) return fmt::format("\\fI{}\\fR", in_roff(typed));
  const std::size_t name_end = value_text(option).name.empty() ? typed.size() : std::min(typed.find(' '), typed.size());
  const std::string value = typed.substr(name_end);
  return fmt::format("\\fB{}\\fR{}", in_roff(typed.substr(0, name_end)),
                     value.empty() ? "" : fmt::format("\\fI{}\\fR", in_roff(value)));
}

std::string entry(const std::string& tag, const std::string& meaning) {
  return fmt::format(".TP\n{}\n{}\n", tag, in_roff(meaning));
}

std::string section(const std::string& title, const std::vector<const CLI::Option*>& options) {
  std::string text;
  for (const CLI::Option* option : options) text += entry(tag_of(*option), meaning_of(*option));
  return text.empty() ? text : fmt::format(".SH {}\n{}", title, text);
}

/// "tactile-eval(1), tactile-train(1)"
std::string references(const std::vector<std::string>& pages) {
  std::string text = ".SH SEE ALSO\n";
  for (std::size_t i = 0; i < pages.size(); ++i)
    text += fmt::format(".BR {} (1){}\n", in_roff(pages[i]), i + 1 < pages.size() ? "," : "");
  return text;
}

}  // namespace

std::string page_name(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name() : app.get_parent()->get_name() + "-" + app.get_name();
}

std::string manual_page(const CLI::App& app) {
  const std::string name = page_name(app), usage = usage_text(app);
  const bool is_program = app.get_parent() == nullptr;
  std::string title = name;
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  // Lines are not filled up to the right margin: option names cannot be divided.
  std::string page = fmt::format(".TH {} 1 \"\" \"tactile {}\" \"tactile\"\n.nh\n.ad l\n", in_roff(title), version());
  page += fmt::format(".SH NAME\n{} \\- {}\n", in_roff(name), in_roff(app.get_description()));
  const std::string call = is_program ? app.get_name() : app.get_parent()->get_name() + " " + app.get_name();
  page += fmt::format(".SH SYNOPSIS\n\\fB{}\\fR{}\n", in_roff(call), in_roff(usage.substr(call.size())));
  const auto those = [&app](const auto& wanted) { return app.get_options(wanted); };
  page += section("ARGUMENTS", those([](const CLI::Option* o) { return o->get_positional(); }));
  const std::vector<const CLI::App*> commands = listed_commands(app);
  if (is_program) page += ".SH COMMANDS\n";
  for (const CLI::App* command : commands)
    page += entry("\\fB" + in_roff(command->get_name()) + "\\fR", command->get_description());
  page += section("OPTIONS", those([](const CLI::Option* o) { return !o->get_positional() && !is_common(*o); }));
  page += section(is_program ? "HELP" : "OPTIONS OF EVERY COMMAND",
                  those([](const CLI::Option* o) { return !o->get_positional() && is_common(*o); }));
  std::vector<std::string> others;
  others.reserve(commands.size() + 1);
  for (const CLI::App* command : commands) others.push_back(page_name(*command));
  if (!is_program) others.push_back(page_name(*app.get_parent()));
  return page + references(others);
}

}  // namespace tactile::cli
