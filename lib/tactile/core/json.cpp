#include "tactile/core/json.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "tactile/core/changed_values.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1), row_before, row_before_that;
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    row_before_that = std::exchange(row_before, row);
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({row_before[j] + (a[i] == b[j] ? 0 : 1), row[j] + 1, row_before[j + 1] + 1});
      const bool is_swapped = i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j];
      if (is_swapped) row[j + 1] = std::min(row[j + 1], row_before_that[j - 1] + 1);
    }
  }
  return row.back();
}

std::string_view without_dashes(std::string_view name) { return name.substr(std::min(name.find_first_not_of('-'), name.size())); }

/// At most one letter in three differs, or one name is part of the other.
bool are_near(std::string_view a, std::string_view b, std::size_t edits) {
  const std::size_t longer = std::max(a.size(), b.size()), shorter = std::min(a.size(), b.size());
  if (edits < longer && edits <= std::max<std::size_t>(1, longer / 3)) return true;
  return shorter >= 3 && (a.find(b) != std::string_view::npos || b.find(a) != std::string_view::npos);
}

/// The depth of nested lists and objects; brackets inside texts do not count.
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

/// What the parser expected where it stopped, from its message that ends in "expected …"; a value if it names nothing.
std::string right_there(const std::string& message) {
  const std::string before = "expected ";
  const std::size_t begin = message.rfind(before);
  const std::string expected = begin == std::string::npos ? "" : message.substr(begin + before.size());
  if (expected == "string literal") return "a name in double quotes";
  if (expected == "end of input") return "nothing after the value";
  if (expected == "'}'") return "',' or '}'";
  if (expected == "']'") return "',' or ']'";
  if (expected == "':'") return "':' after the name";
  return message.find("object key") != std::string::npos
             ? "a name in double quotes"
             : "a value: a text in double quotes, a number, true, false, null, a list "
               "or an object";
}

/// The word at `place`, or a description of what is there.
std::string word_at(std::string_view text, std::size_t place) {
  constexpr std::string_view ends = " \t\r\n,:[]{}";
  if (place >= text.size()) return "the end of the file";
  std::size_t begin = place, end = place + 1;
  if (ends.find(text[place]) == std::string_view::npos) {
    while (begin > 0 && ends.find(text[begin - 1]) == std::string_view::npos) --begin;
    while (end < text.size() && ends.find(text[end]) == std::string_view::npos) ++end;
  }
  std::string word;
  for (const char c : text.substr(begin, std::min<std::size_t>(end - begin, 40))) {
    const auto byte = static_cast<unsigned char>(c);
    word += byte >= 0x20 && byte < 0x7f ? c : '?';
  }
  return "'" + word + "'";
}

std::string what_is_no_json(std::string_view text, const nlohmann::json::parse_error& error) {
  // It counts the bytes read from 1; the last byte read is the wrong one.
  std::size_t place = error.byte > 0 ? error.byte - 1 : 0;
  const std::string message = error.what();
  const bool is_open_text = message.find("invalid string") != std::string::npos;
  if (is_open_text) place = std::min(place, text.size());
  const std::size_t line = 1 + static_cast<std::size_t>(std::count(
                                   text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(place, text.size())), '\n'));
  const std::string where = "line " + std::to_string(line) + " is no JSON";
  if (is_open_text)
    return where + ": a text is not closed, or contains an invalid character; expected it in double quotes, on one line";
  return where + " at " + word_at(text, place) + "; expected " + right_there(message) + " there";
}

}  // namespace

nlohmann::json read_json(const std::filesystem::path& file) {
  constexpr std::size_t deepest = 100;  // copying and printing are recursive, and the stack is limited
  const std::string text = read_text(file, std::size_t{8} << 20);
  if (depth_of(text) > deepest)
    throw Error(file.string() + ": nests values " + std::to_string(depth_of(text)) + " deep; expected at most " +
                std::to_string(deepest));
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& e) {
    throw Error(file.string() + ": " + what_is_no_json(text, e));
  } catch (const nlohmann::json::out_of_range&) {
    throw Error(file.string() + ": a number is too large; expected numbers between -1.8e308 and 1.8e308");
  } catch (const nlohmann::json::exception& e) {
    throw Error(file.string() + ": no valid JSON (" + e.what() + "); expected one JSON value");
  }
}

void write_json(const std::filesystem::path& file, const nlohmann::json& json) { write_whole(file, json_text(json, 2) + "\n"); }

std::string json_text(const nlohmann::json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string hash_of(const nlohmann::json& json) { return sha256_of(json_text(json)); }

std::string differences(const nlohmann::json& before, const nlohmann::json& now) {
  constexpr std::size_t most = 4;
  const std::vector<ChangedValue> changed = changed_values(before, now);
  std::string text;
  for (std::size_t i = 0; i < changed.size(); ++i) {
    if (i == most) return text + "; and " + std::to_string(changed.size() - most) + " more";
    text += (i == 0 ? "" : "; ") + changed[i].path + ": " + json_text(changed[i].before) + " before, " +
            json_text(changed[i].now) + " now";
  }
  return text;
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  const std::string_view plain = without_dashes(name);
  std::string nearest;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : names) {
    const std::string_view plain_candidate = without_dashes(candidate);
    const std::size_t edits = edits_between(plain, plain_candidate);
    if (edits >= fewest || !are_near(plain, plain_candidate, edits)) continue;
    fewest = edits;
    nearest = candidate;
  }
  return nearest;
}

void throw_bad_member(std::string_view key, std::string_view where, std::string_view why) {
  throw Error(std::string(where) + ": '" + std::string(key) + "' " + plain_words(why));
}

}  // namespace tactile
