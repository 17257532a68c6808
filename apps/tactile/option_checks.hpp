#pragma once

#include <fmt/core.h>

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "options.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

// Checks of option values. The help shows a check's description ("1 to 1024"), and an error shows it after "expected".
namespace tactile::cli {

/// A number from `low` to `high`, both included; a whole one if T is.
template <class T>
Check in_range(T low, T high);

/// One of these words.
Check one_of(std::initializer_list<std::string_view> words);
Check one_of(std::span<const std::string_view> words);

/// A duration in units of `us` microseconds: from `low` to `high` microseconds, and a whole number of them.
Check is_duration(double low, double high, double us);

/// A whole number from 0 to 18446744073709551615.
Check is_seed();

/// A run's id: two digits from 01 on.
Check is_run();

/// A text that `read` reads without an Error.
template <class Read>
Check readable_by(const Read& read) {
  return Check{[read](std::string& text) {
                 try {
                   read(text);
                   return std::string();
                 } catch (const Error& error) {
                   return std::string(error.what());
                 }
               },
               ""};
}

/// The name of an existing file, not of a folder.
Check is_existing_file();

std::string range_text(double low, double high);  ///< "0.001 to 1000000", "1e-12 to 10"
std::string check_number(const std::string& text, bool whole, double low, double high);

template <class T>
Check in_range(T low, T high) {
  static_assert(std::is_arithmetic_v<T>);
  const auto from = static_cast<double>(low), to = static_cast<double>(high);
  return Check{[from, to](std::string& text) { return check_number(text, std::is_integral_v<T>, from, to); },
               range_text(from, to)};
}

/// `--strict` of every command that needs samples of each object.
void add_strict_option(Command command, bool& strict);

}  // namespace tactile::cli
