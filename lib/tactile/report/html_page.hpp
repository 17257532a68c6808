#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tactile::report {

/// `text` as HTML in which no character has a meaning for HTML, in attributes too. Control characters
/// become blanks, bytes that are no UTF-8 U+FFFD.
std::string html_text(std::string_view text);

/// How a table's field is shown.
enum class HtmlTone : std::uint8_t { plain, number, good, bad, open };

struct HtmlCell {
  std::string text;
  HtmlTone tone = HtmlTone::plain;
  std::string second_line{};  ///< smaller, below; may be empty
};

struct HtmlTable {
  std::string caption;
  std::vector<std::string> head;
  std::vector<std::vector<HtmlCell>> rows;  ///< as long as `head`; the first cell names the row
  bool stacks = false;                      ///< on a narrow screen each row is a list of its fields: for tables of much text
  std::string folded{};                     ///< if not empty, the words on which a click shows the table
};

struct HtmlFigure {
  std::string id;   ///< lower-case letters, digits and hyphens
  std::string svg;  ///< a whole SVG file of gnuplot
  int width_px = 0, height_px = 0;
  std::string in_words;  ///< for readers who cannot see it
  std::string caption;
};

/// One self-contained page: it contains its styles and figures. It loads nothing and runs no script; a policy in its head forbids
/// both. Readable on a phone, in print, in light and dark: figures take the page's colours and its width. Whatever it is given is
/// text, and escaped.
class HtmlPage {
 public:
  explicit HtmlPage(std::string title) : title_(std::move(title)) {}

  const std::string& title() const { return title_; }

  void section(std::string_view id, std::string_view heading);  ///< begins one; listed in the page's contents
  void heading(std::string_view text);                          ///< within a section
  void paragraph(std::string_view text);
  void warning(std::string_view text);  ///< framed
  void list(const std::vector<std::string>& items);
  void table(
      const HtmlTable& table);  ///< scrolls where it is wider than the page and does not stack; one without rows is left out
  void figure(const HtmlFigure& figure);
  void begin_folded(std::string_view summary);  ///< the part until `end_folded` is shown on a click, and in print
  void end_folded();

  std::string text() const;  ///< the whole page

 private:
  std::string title_;
  std::string before_;  // what stands above the contents
  std::string body_;
  std::vector<std::pair<std::string, std::string>> sections_;  // id and heading

  std::string& here() { return sections_.empty() ? before_ : body_; }
};

}  // namespace tactile::report
