#include "tactile/core/text_lines.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tactile
