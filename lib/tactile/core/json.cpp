#include "tactile/core/json.hpp"

#include <algorithm>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : a) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (letter == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// How many lists and objects lie within each other at the deepest; brackets inside texts do not count.
std::size_t depth_of(std::string_view text) {
  std::size_t depth = 0, deepest = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

nlohmann::json read_json(const std::filesystem::path& file) {
  constexpr std::size_t deepest = 100;  // copying and printing go down level by level, and the stack ends
  const std::string text = read_text(file, std::size_t{8} << 20);
  if (depth_of(text) > deepest)
    throw Error(file.string() + ": nests values " + std::to_string(depth_of(text)) + " deep; expected at most " +
                std::to_string(deepest));
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& e) {
    throw Error(file.string() + ": no valid JSON (" + e.what() + "); expected one JSON value");
  }
}

void write_json(const std::filesystem::path& file, const nlohmann::json& json) {
  // Paths, and the names that devices and other programs give, are any bytes; what is no UTF-8 becomes U+FFFD.
  write_whole(file, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

std::string hash_of(const nlohmann::json& json) { return sha256_of(json.dump()); }

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  const auto nearest = std::min_element(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return edits_between(name, a) < edits_between(name, b);
  });
  return nearest == names.end() ? std::string() : *nearest;
}

void throw_bad_member(std::string_view key, std::string_view where, std::string_view why) {
  throw Error(std::string(where) + ": '" + std::string(key) + "' " + std::string(why));
}

}  // namespace tactile
