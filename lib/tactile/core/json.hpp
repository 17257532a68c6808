#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace tactile {

/// @throws Error  if the file cannot be read or is no JSON
nlohmann::json read_json(const std::filesystem::path& file);

/// Two-space indented, a newline at the end, whole or not at all. @throws Error if it cannot be written
void write_json(const std::filesystem::path& file, const nlohmann::json& json);

/// SHA-256 of the canonical JSON: keys sorted, no white space, numbers in their shortest form that reads back the same.
std::string hash_of(const nlohmann::json& json);

/// The member `key` of `json` as a T. @throws Error that names `where`, the key and what is wrong
template <class T>
T member(const nlohmann::json& json, std::string_view key, std::string_view where);

/// The one of `names` that takes the fewest single-letter edits to reach from `name`; empty if there is none.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

[[noreturn]] void throw_bad_member(std::string_view key, std::string_view where, std::string_view why);

template <class T>
T member(const nlohmann::json& json, std::string_view key, std::string_view where) {
  const auto found = json.is_object() ? json.find(std::string(key)) : json.end();
  if (found == json.end()) throw_bad_member(key, where, "is missing");
  try {
    return found->template get<T>();
  } catch (const nlohmann::json::exception& e) {
    throw_bad_member(key, where, e.what());
  }
}

}  // namespace tactile
