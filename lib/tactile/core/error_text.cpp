#include "tactile/core/error_text.hpp"

#include <array>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

/// The part of `text` between `before` and `after`; empty if they are not there.
std::string_view between(std::string_view text, std::string_view before, std::string_view after) {
  const std::size_t begin = text.find(before);
  if (begin == std::string_view::npos) return {};
  const std::size_t from = begin + before.size(), end = after.empty() ? text.size() : text.find(after, from);
  return end == std::string_view::npos ? std::string_view() : text.substr(from, end - from);
}

/// Without the hidden folder in which a file is made (`PartFolder`): "data/.a.csv.part-Ab3Xyz/a.csv" is "data/a.csv".
std::string without_part_folders(std::string text) {
  constexpr std::string_view mark = ".part-";
  constexpr std::size_t random_letters = 6;
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) {
    const std::size_t slash = text.find('/', at), begin = text.find_last_of("/ '", at) + 1;  // 0 if there is none
    if (slash != at + mark.size() + random_letters || text[begin] != '.') continue;
    text.erase(begin, slash + 1 - begin);
    at = begin;
  }
  return text;
}

}  // namespace

std::string kind_in_words(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kinds{{{"null", "null"},
                                                                                {"object", "an object"},
                                                                                {"array", "a list"},
                                                                                {"string", "a text"},
                                                                                {"boolean", "true or false"},
                                                                                {"number", "a number"}}};
  for (const auto& [theirs, ours] : kinds) {
    if (name.starts_with(theirs)) return std::string(ours);
  }
  return "a value of another type";
}

std::string plain_words(std::string_view text) {
  if (!text.starts_with("[json.exception.")) return std::string(text);
  if (const auto expected = between(text, "type must be ", ", but is "); !expected.empty())
    return "is " + kind_in_words(between(text, ", but is ", "")) + "; expected " + kind_in_words(expected);
  if (const auto key = between(text, "key '", "' not found"); !key.empty()) return "lacks the member '" + std::string(key) + "'";
  if (text.find("array index ") != std::string_view::npos) return "is a list that is too short";
  if (const auto found = between(text, ") with ", ""); !found.empty())
    return "is " + kind_in_words(found) + "; expected an object or a list";
  if (text.find("out_of_range") != std::string_view::npos) return "contains a number that is too large";
  return "has an unexpected structure";
}

std::string sentence_of(const std::exception& error, std::string_view about) {
  if (dynamic_cast<const Error*>(&error) != nullptr) return without_part_folders(error.what());
  if (const auto* file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    return file->path1().string() + ": cannot be used (" + file->code().message() +
           "); expected a file or folder that can be read, and written if it is an output";
  }
  const std::string begin = about.empty() ? std::string() : std::string(about) + ": ";
  if (dynamic_cast<const nlohmann::json::exception*>(&error) != nullptr)
    return begin + "a value in a JSON file " + plain_words(error.what()) + "; expected a file as tactile writes it";
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr || dynamic_cast<const std::length_error*>(&error) != nullptr)
    return begin + "not enough memory; expected more memory, fewer --threads, or a smaller recording";
  return begin + error.what();
}

}  // namespace tactile
