#include "field_options.hpp"

#include <cmath>

namespace tactile::cli {
namespace {

std::string text_in_units(microseconds duration, double us) {
  return fmt::format("{}", static_cast<double>(duration.count()) / us);
}

microseconds duration_of(const std::string& text, double us) {
  return microseconds{std::llround(number_in(text).value_or(0) * us)};
}

}  // namespace

Option add_duration(Command command, const std::string& name, microseconds& value, double low, double high, double us,
                    const std::string& meaning) {
  const auto text = [&value, us] { return text_in_units(value, us); };
  const auto set = [&value, us](const std::string& number) { value = duration_of(number, us); };
  return command.add_text_option(name, text, set, meaning)
      .check(is_duration(low, high, us))
      .type_name(us == 1 ? "INT" : "FLOAT")
      .show_default();
}

void FieldOptions::operator()(std::string_view, microseconds& value, double low, double high, const OptionText& option) {
  if (is_declared(option))
    complete(add_duration(command_, name_of(option), value, low, high, option.us, meaning_of(option)), option);
}

void FieldOptions::operator()(std::string_view, std::uint64_t& value, const OptionText& option) {
  if (is_declared(option)) complete(command_.add_option(name_of(option), value, meaning_of(option)).check(is_seed()), option);
}

void FieldOptions::complete(Option declared, const OptionText& option) {
  if (!option.values.empty()) declared.type_name(std::string(option.values));
  declared.show_default();
}

Option add_duration_list(Command command, const std::string& name, std::vector<microseconds>& values, double low, double high,
                         double us, const std::string& meaning) {
  const auto text = [us](microseconds value) { return text_in_units(value, us); };
  const auto read = [us](const std::string& number) { return duration_of(number, us); };
  return add_list(command, name, values, text, read, meaning)
      .check(is_duration(low, high, us))
      .type_name(us == 1 ? "INT" : "FLOAT");
}

Option add_number_list(Command command, const std::string& name, std::vector<double>& values, double low, double high,
                       const std::string& meaning) {
  const auto text = [](double value) { return fmt::format("{}", value); };
  const auto read = [](const std::string& number) { return number_in(number).value_or(0); };
  return add_list(command, name, values, text, read, meaning).check(in_range(low, high)).type_name("FLOAT");
}

Option add_histories_option(Command command, std::vector<microseconds>& histories, const std::string& meaning) {
  return add_duration_list(command, "--th", histories, 1, 100'000'000, 1000, meaning);
}

}  // namespace tactile::cli
