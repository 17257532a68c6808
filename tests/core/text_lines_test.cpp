#include "tactile/core/text_lines.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/run_command.hpp"

namespace tactile {
namespace {

TEST(CharactersIn, CountsCharactersNotBytes) {
  EXPECT_EQ(characters_in(""), 0U);
  EXPECT_EQ(characters_in("µs ± 1"), 6U);
}

TEST(Wrapped, BreaksBetweenWordsAndIndentsAllButTheFirst) {
  EXPECT_EQ(wrapped("one two three", 0, 7), "one two\nthree");
  EXPECT_EQ(wrapped("one two three", 2, 9), "one two\n  three");
  EXPECT_EQ(wrapped("µµµ µµµ", 0, 7), "µµµ µµµ");
  EXPECT_EQ(wrapped("word", 0, 80), "word");
}

TEST(Wrapped, LeavesAWordWhole) { EXPECT_EQ(wrapped("a unbreakable b", 0, 4), "a\nunbreakable\nb"); }

TEST(LinesOf, AreOneMoreThanTheEndsBetweenThem) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(lines_of("one\ntwo"), (Lines{"one", "two"}));
  EXPECT_EQ(lines_of("one"), Lines{"one"});
  EXPECT_EQ(lines_of(""), Lines{""});
  EXPECT_EQ(lines_of("one\n\ntwo\n"), (Lines{"one", "", "two", ""}));
  EXPECT_EQ(lines_of(wrapped("one two three", 2, 9)), (Lines{"one two", "  three"}));
}

TEST(ShellWord, IsReadAsOneWordByAShell) {
  EXPECT_EQ(shell_word("data/fan/01"), "data/fan/01");
  for (const std::string text : {"my runs/fan", "it's", "$HOME", "", "a;b", "*", "~", "Größe", "-n", "\\"}) {
    const auto printed = test::run_shell("printf %s " + shell_word(text));
    EXPECT_EQ(printed.out, text) << shell_word(text);
  }
}

}  // namespace
}  // namespace tactile
