#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tactile {

/// @throws Error  if the file cannot be read, is larger than 8 MiB, is no JSON (the line and what belongs there are named), or
/// nests values more than 100 deep: the bounds
///                keep what hostile bytes can cost below 256 MiB, and within the stack
nlohmann::json read_json(const std::filesystem::path& file);

/// Two-space indented, a newline at the end, whole or not at all. @throws Error if it cannot be written
void write_json(const std::filesystem::path& file, const nlohmann::json& json);

/// SHA-256 of the canonical JSON: keys sorted, no white space, numbers in their shortest form that reads back the same.
std::string hash_of(const nlohmann::json& json);

/// The member `key` of `json` as a T. @throws Error that names `where`, the key and what is wrong: for an integral T also a
/// number that is not whole or out of T's range
template <class T>
T member(const nlohmann::json& json, std::string_view key, std::string_view where);

/// What differs in `now` from before, member by member: "training.epochs: 10 before, 6 now; ..."; four at most, and how many
/// more there are. Empty where nothing is.
std::string differences(const nlohmann::json& before, const nlohmann::json& now);

/// The one of `names` that was probably meant by `name`: the one that needs the fewest edits (a letter more, less, other, or
/// two swapped). It differs in at most one letter in three, or one of the two contains the other. Dashes in front do not count.
/// Empty if none is near.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

[[noreturn]] void throw_bad_member(std::string_view key, std::string_view where, std::string_view why);

template <class T>
T member(const nlohmann::json& json, std::string_view key, std::string_view where) {
  const auto found = json.is_object() ? json.find(std::string(key)) : json.end();
  if (found == json.end()) throw_bad_member(key, where, "is missing");
  if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
    const bool fits = found->is_number_unsigned()  ? std::in_range<T>(found->template get<std::uint64_t>())
                      : found->is_number_integer() ? std::in_range<T>(found->template get<std::int64_t>())
                                                   : false;
    if (!fits) {
      throw_bad_member(key, where,
                       "is no whole number from " + std::to_string(std::numeric_limits<T>::min()) + " to " +
                           std::to_string(std::numeric_limits<T>::max()));
    }
  }
  try {
    return found->template get<T>();
  } catch (const std::exception& e) {
    throw_bad_member(key, where, e.what());
  }
}

}  // namespace tactile
