#include "tactile/report/html_page.hpp"

#include <gtest/gtest.h>

namespace tactile::report {
namespace {

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

TEST(HtmlText, StandsForItself) {
  EXPECT_EQ(html_text("fan µs"), "fan µs");
  EXPECT_EQ(html_text("<b title=\"x\" y='z'>&amp;"), "&lt;b title=&quot;x&quot; y=&#39;z&#39;&gt;&amp;amp;");
  EXPECT_EQ(html_text(std::string("a\0\n\x7f", 4)), "a   ");
  EXPECT_EQ(html_text("a\xFF\xC3z\xED\xA0\x80"), "a\uFFFD\uFFFDz\uFFFD\uFFFD\uFFFD");
}

TEST(Base64, IsThatOfTheRfc) {
  EXPECT_EQ(base64_of(""), "");
  EXPECT_EQ(base64_of("f"), "Zg==");
  EXPECT_EQ(base64_of("fo"), "Zm8=");
  EXPECT_EQ(base64_of("foo"), "Zm9v");
  EXPECT_EQ(base64_of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64_of(std::string("\xFF\xFE\0", 3)), "//4A");
}

TEST(HtmlPage, NeedsNoOtherFileAndEscapesWhateverItIsGiven) {
  const std::string hostile = "<script>alert(\"1\")</script>'";
  HtmlPage page(hostile);
  page.warning(hostile);
  page.section("part", hostile);
  page.heading(hostile);
  page.paragraph(hostile);
  page.list({hostile});
  page.table({.caption = hostile,
              .head = {hostile, "b"},
              .rows = {{{.text = hostile, .second_line = hostile}, {.text = hostile, .tone = HtmlTone::bad}}}});
  page.table({.caption = "empty", .head = {"a"}, .rows = {}});
  page.begin_folded(hostile);
  page.figure({.id = "figure-x", .svg = "<svg/>", .width_px = 1000, .height_px = 500, .in_words = hostile, .caption = hostile});
  page.end_folded();
  const std::string html = page.text();
  EXPECT_EQ(count_of(html, "<script"), 0U);
  EXPECT_EQ(count_of(html, "&lt;script&gt;"), 18U) << html;
  EXPECT_LT(html.find("<details><summary>"), html.find("figure-x"));
  EXPECT_GT(html.find("</details>"), html.find("figure-x"));
  EXPECT_EQ(count_of(html, "http://") + count_of(html, "https://") + count_of(html, "url("), 0U);
  EXPECT_EQ(count_of(html, "<table>"), 1U);
  EXPECT_EQ(count_of(html, "data:image/svg+xml;base64,PHN2Zy8+"), 1U);
  for (const char* part :
       {"name=\"viewport\"", "prefers-color-scheme: dark", "default-src 'none'", "href=\"#part\"", "id=\"part\"", "lang=\"en\""})
    EXPECT_EQ(count_of(html, part), 1U) << part;
}

}  // namespace
}  // namespace tactile::report
