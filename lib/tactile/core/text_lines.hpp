#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tactile {

/// Characters of UTF-8, not bytes: "µs" is two wide.
std::size_t characters_in(std::string_view text);

/// How many bytes the UTF-8 character at the text's start has; 0 if there is none. @param text  not empty
std::size_t character_at(std::string_view text);

/// `text` in lines of at most `width` characters where its words allow it; all but the first are indented.
std::string wrapped(const std::string& text, std::size_t indent = 0, std::size_t width = 80);

/// The lines of `text` without their ends: one more than its number of '\n', so at least one.
std::vector<std::string> lines_of(std::string_view text);

/// `text` as one word of a shell command, in quotes if it needs them.
std::string shell_word(const std::string& text);

}  // namespace tactile
