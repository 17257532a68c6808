#include "options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactile::cli {
namespace {

/// The words as the name of a check, from which `words_of` reads them.
std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, "|")); }

/// A key of a file for --config would mean both of two options with one name, with dashes and without. CLI11 from 2.4 on (Debian
/// 13) refuses them.
CLI::Option& with_a_name_of_its_own(const CLI::App& command, CLI::Option* added) {
  for (const CLI::Option* other : command.get_options()) {
    if (other != added && other->get_single_name() == added->get_single_name())
      throw std::logic_error(command.get_name() + ": two options are named " + added->get_single_name());
  }
  return *added;
}

}  // namespace

Option& Option::check(const Check& check) {
  option_->check(CLI::Validator(check.wrong, check.right, joined(check.words)));
  return *this;
}

Option& Option::suggest(const std::vector<std::string>& words) {
  option_->check(CLI::Validator([](std::string&) { return std::string(); }, "", joined(words)));
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::default_text(const std::string& text) {
  option_->default_str(text);
  return *this;
}

Option& Option::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::delimiter(char separator) {
  option_->delimiter(separator);
  return *this;
}

Option& Option::repeatable() {
  option_->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  return *this;
}

Option& Option::one_value_each_time() {
  option_->allow_extra_args(false);
  return *this;
}

Option& Option::value_is_optional(const std::string& without) {
  option_->expected(0, 1)->default_str(without);
  return *this;
}

Option& Option::needs(const Option& other) {
  option_->needs(other.option_);
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

template <class T>
Option Command::add_option(const std::string& names, T& value, const std::string& meaning) {
  return Option(with_a_name_of_its_own(*command_, command_->add_option(names, value, meaning)));
}

Option Command::add_text_option(const std::string& names, const std::function<std::string()>& value,
                                const std::function<void(const std::string&)>& set, const std::string& meaning) {
  CLI::Option* option = command_->add_option_function<std::string>(names, set, meaning);
  return Option(with_a_name_of_its_own(*command_, option->default_function(value)));
}

Option Command::add_path_option(const std::string& names, std::filesystem::path& value, const std::string& meaning) {
  return add_text_option(
      names, [&value] { return value.string(); }, [&value](const std::string& path) { value = path; }, meaning);
}

Option Command::add_list_option(const std::string& names, const std::function<std::vector<std::string>()>& values,
                                const std::function<void(const std::vector<std::string>&)>& set, const std::string& meaning) {
  CLI::Option* option = command_->add_option_function<std::vector<std::string>>(names, set, meaning)->delimiter(',');
  return Option(with_a_name_of_its_own(
      *command_, option->default_function([values] { return fmt::format("[{}]", fmt::join(values(), ",")); })));
}

Option Command::add_flag(const std::string& names, bool& value, const std::string& meaning) {
  return Option(with_a_name_of_its_own(*command_, command_->add_flag(names, value, meaning)));
}

Option Command::add_ordered_option(const std::string& names, const std::function<void(const std::string&)>& keep,
                                   const std::string& meaning) {
  const std::function<void(const std::vector<std::string>&)> keep_all = [keep](const std::vector<std::string>& values) {
    for (const std::string& value : values) keep(value);
  };
  return Option(*command_->add_option_function(names, keep_all, meaning)->trigger_on_parse()->allow_extra_args(false));
}

void Command::hide() { command_->group(""); }

template Option Command::add_option(const std::string&, std::string&, const std::string&);
template Option Command::add_option(const std::string&, double&, const std::string&);
template Option Command::add_option(const std::string&, int&, const std::string&);
template Option Command::add_option(const std::string&, unsigned&, const std::string&);
template Option Command::add_option(const std::string&, std::int64_t&, const std::string&);
template Option Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option Command::add_option(const std::string&, std::uint16_t&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<unsigned>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<std::int64_t>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<std::uint16_t>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<int>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::int64_t>&, const std::string&);

}  // namespace tactile::cli
