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

TEST(HtmlPage, GivesFiguresThePagesColoursAndNamesOfTheirOwn) {
  const std::string svg =
      "<?xml version=\"1.0\"?>\n<svg width=\"600\" height=\"300\">\n<title>Gnuplot</title>\n<desc>Produced by it</desc>\n"
      "<rect x=\"0\" y=\"0\" width=\"600\" height=\"300\" fill=\"#ffffff\"/>\n<circle id='gpDot'/><use xlink:href='#gpDot' "
      "id=\"b\"/>"
      "<path stroke='rgb(  0,  90, 200)'/><g fill=\"rgb(48,48,48)\"/><g fill=\"rgb(1, 2, 3)\"/>"
      "<image xlink:href='data:image/png;base64,x'/></svg>\n";
  HtmlPage page("Two");
  for (const char* id : {"one", "two"})
    page.figure({.id = id, .svg = svg, .width_px = 600, .height_px = 300, .in_words = "w", .caption = "c"});
  const std::string html = page.text();
  EXPECT_EQ(count_of(html, "<img"), 0U);
  EXPECT_EQ(count_of(html, "<svg viewBox=\"0 0 600 300\" style=\"max-width:600px\""), 2U);
  EXPECT_EQ(count_of(html, "Gnuplot") + count_of(html, "#ffffff\"") + count_of(html, "rgb(48") + count_of(html, "rgb(  0"), 0U);
  for (const char* own : {"id='one-gpDot'", "xlink:href='#one-gpDot'", "id=\"two-b\""}) EXPECT_EQ(count_of(html, own), 1U) << own;
  EXPECT_EQ(count_of(html, "xlink:href='data:image/png;base64,x'"), 2U);
  EXPECT_EQ(count_of(html, "rgb(1, 2, 3)"), 2U) << "what is no colour of figures stays";
  const std::size_t ink = html.find("<g fill=\"var(--f");
  ASSERT_NE(ink, std::string::npos);
  const std::string name = html.substr(ink + 13, html.find(')', ink) - ink - 13);
  EXPECT_EQ(count_of(html, name + ":#303030;"), 1U) << "on a light page";
  EXPECT_EQ(count_of(html, name + ":"), 2U) << "and on a dark one";
}

TEST(HtmlPage, FoldsATableThatIsADetail) {
  HtmlPage page("Folded");
  page.table({.caption = "c", .head = {"a"}, .rows = {{{.text = "x"}}}, .folded = "details"});
  const std::string html = page.text();
  EXPECT_LT(html.find("<details><summary>details</summary>"), html.find("<table"));
  EXPECT_LT(html.find("</table>"), html.find("</details>"));
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
  EXPECT_EQ(count_of(html, "&lt;script&gt;"), 17U) << html;
  EXPECT_LT(html.find("<details><summary>"), html.find("figure-x"));
  EXPECT_GT(html.find("</details>"), html.find("figure-x"));
  EXPECT_EQ(count_of(html, "http://") + count_of(html, "https://") + count_of(html, "url("), 0U);
  EXPECT_EQ(count_of(html, "<table>"), 1U);
  EXPECT_EQ(count_of(html, "<svg/>"), 1U);
  for (const char* part : {"name=\"viewport\"", "default-src 'none'", "href=\"#part\"", "id=\"part\"", "lang=\"en\""})
    EXPECT_EQ(count_of(html, part), 1U) << part;
}

}  // namespace
}  // namespace tactile::report
