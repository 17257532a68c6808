#pragma once

#include <exception>
#include <string>
#include <string_view>

namespace tactile {

/// What went wrong, as a sentence for people. The text of an `Error` is one already; exceptions of the standard library and of
/// the JSON library name files and members in their own words, or not at all.
/// @param about  the run or file that was worked on: begins the sentence where the error itself names none
std::string sentence_of(const std::exception& error, std::string_view about = {});

/// A type of JSON value, "a list", from the JSON library's name for it, "array".
std::string kind_in_words(std::string_view name);

/// What the JSON library says of a value, in plain words: "is a number; expected a text". Any other text as it is.
std::string plain_words(std::string_view json_library_text);

}  // namespace tactile
