#pragma once

#include <string>
#include <string_view>

namespace tactile {

/// ASCII letters in lower case; other characters stay.
inline std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

/// Without blanks, tabs and line ends at either end.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(blanks);
  return begin == std::string_view::npos ? std::string_view() : text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

/// `text` as a message shows it: in quotes, cut after 40 characters; '?' stands for any that is not printable ASCII.
inline std::string shown_text(std::string_view text) {
  std::string plain;
  for (const char c : text.substr(0, 40)) plain += c >= ' ' && c < 127 ? c : '?';
  return "'" + plain + (text.size() > 40 ? "...'" : "'");
}

}  // namespace tactile
