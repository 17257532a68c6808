#include "tactile/report/html_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <regex>

#include "tactile/core/text_lines.hpp"

namespace tactile::report {
namespace {

constexpr std::size_t long_text = 30;  // [characters] of a field that is given more room on a narrow screen

/// A colour of figures, which are drawn on white, and the one that has its place on a dark page.
struct FigureColour {
  int red, green, blue;
  std::string_view dark;
};

constexpr std::array figure_palette{FigureColour{0xFF, 0xFF, 0xFF, "#16181c"},  // paper
                                    FigureColour{0x30, 0x30, 0x30, "#e8e8ea"},  // ink
                                    FigureColour{0x60, 0x60, 0x60, "#b4b9c0"}, FigureColour{0x70, 0x70, 0x70, "#a6abb3"},
                                    FigureColour{0xB8, 0xB8, 0xB8, "#70757e"}, FigureColour{0xC4, 0xC4, 0xC4, "#5c616a"},
                                    FigureColour{0xE6, 0xE6, 0xE6, "#2c3037"},
                                    // press and slip, their uncertainties and their areas
                                    FigureColour{0x00, 0x5A, 0xC8, "#6cb0ff"}, FigureColour{0xE6, 0x5A, 0x00, "#ff9d5c"},
                                    FigureColour{0x8D, 0xB4, 0xEA, "#3f6ea8"}, FigureColour{0xF4, 0xAE, 0x80, "#a8683c"},
                                    FigureColour{0xDC, 0xE8, 0xF8, "#1c3350"}, FigureColour{0xFC, 0xE6, 0xD6, "#4a2e1a"},
                                    // other lines
                                    FigureColour{0x00, 0x9E, 0x73, "#3fd6a6"}, FigureColour{0xCC, 0x79, 0xA7, "#e8a3c9"},
                                    FigureColour{0x56, 0xB4, 0xE9, "#8fd0f5"}, FigureColour{0xB8, 0x86, 0x0B, "#e0b64a"},
                                    FigureColour{0x7B, 0x32, 0x94, "#c78fe0"}};

/// The palette as variables of CSS.
std::string palette_css(bool is_dark) {
  std::string css;
  for (std::size_t i = 0; i < figure_palette.size(); ++i) {
    const FigureColour& colour = figure_palette[i];
    css += is_dark ? fmt::format("--f{}:{};", i, colour.dark)
                   : fmt::format("--f{}:#{:02x}{:02x}{:02x};", i, colour.red, colour.green, colour.blue);
  }
  return css;
}

/// A figure of gnuplot from its contents on, in the page's colours: those of the palette are variables of CSS, its white
/// background is left out, and its names begin with `id`, which is the figure's alone.
std::string inner_svg(const std::string& svg, const std::string& id) {
  static const std::regex name(R"( id=(['"]))"), use(R"(xlink:href=(['"])#)"),
      background(R"(<rect x="0" y="0"[^>]*fill="#ffffff"/>)"), colour(R"(rgb\( *(\d+), *(\d+), *(\d+)\))");
  const std::size_t described = svg.find("</desc>");
  std::string contents = described == std::string::npos ? svg : svg.substr(described + 7);
  contents = std::regex_replace(contents, background, "");
  contents = std::regex_replace(contents, name, " id=$1" + id + "-");
  contents = std::regex_replace(contents, use, "xlink:href=$1#" + id + "-");
  std::string page;
  auto after = contents.cbegin();
  for (std::sregex_iterator found(contents.begin(), contents.end(), colour), last; found != last; ++found) {
    page.append(after, (*found)[0].first);
    after = (*found)[0].second;
    const auto at = std::find_if(figure_palette.begin(), figure_palette.end(), [&](const FigureColour& one) {
      return std::stoi((*found)[1]) == one.red && std::stoi((*found)[2]) == one.green && std::stoi((*found)[3]) == one.blue;
    });
    page += at == figure_palette.end() ? found->str() : fmt::format("var(--f{})", at - figure_palette.begin());
  }
  return page.append(after, contents.cend());
}

constexpr std::string_view style = R"css(
:root { color-scheme: light dark; --paper: #fff; --ink: #1d1d1f; --faint: #5f6368; --line: #d9dbe0; --field: #f4f5f7;
  --good: #00614a; --good-field: #d9f2e8; --bad: #8f2d00; --bad-field: #fde5d8; --open: #4a4a4a; --open-field: #e9e9ec; --link: #0050b3; }
@media (prefers-color-scheme: dark) { :root { --paper: #16181c; --ink: #e8e8ea; --faint: #a6abb3; --line: #3a3e46; --field: #1f2228;
  --good: #8fe3c4; --good-field: #0f3a2d; --bad: #ffb693; --bad-field: #4a2110; --open: #d0d0d4; --open-field: #33363d; --link: #8ab8ff; } }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0 auto; padding: 1rem 1rem 4rem; max-width: 66rem; background: var(--paper); color: var(--ink);
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 1rem 0 .5rem; }
h2 { font-size: 1.3rem; margin: 2.5rem 0 .5rem; padding-top: .5rem; border-top: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.5rem 0 .5rem; }
p { max-width: 46rem; margin: .5rem 0; }
li { max-width: 46rem; }
a { color: var(--link); }
nav ul { columns: 2 16rem; padding-left: 1.2rem; margin: .5rem 0; }
.warning { border-left: .35rem solid var(--bad); background: var(--bad-field); padding: .6rem .9rem; margin: 1rem 0; max-width: none; }
.scroll { overflow-x: auto; max-width: 100%; }
table { border-collapse: collapse; margin: .75rem 0; font-size: .92rem; min-width: min(100%, 26rem); }
caption { text-align: left; color: var(--faint); padding: .25rem 0; }
th, td { text-align: left; vertical-align: top; padding: .35rem .7rem .35rem 0; border-bottom: 1px solid var(--line); }
thead th { border-bottom: 2px solid var(--line); white-space: nowrap; }
tbody th { font-weight: 600; }
/* A caption stays where it can be read while its table scrolls. */
caption span { display: inline-block; position: sticky; left: 0; max-width: min(46rem, calc(100vw - 2rem)); }
thead th.number { text-align: right; white-space: normal; }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
tbody th, td { min-width: 7.5rem; }
.long { min-width: 13rem; }
td.number { min-width: 5rem; }
small { display: block; color: var(--faint); font-weight: 400; }
.good, .bad, .open { display: inline-block; padding: .05rem .5rem; border-radius: .6rem; white-space: nowrap; font-weight: 600; }
.good { color: var(--good); background: var(--good-field); }
.bad { color: var(--bad); background: var(--bad-field); }
.open { color: var(--open); background: var(--open-field); }
figure { margin: 1.25rem 0; }
figure svg { display: block; height: auto; width: 100%; }
figure svg text { font-family: "DejaVu Sans", Verdana, sans-serif; }
figcaption { color: var(--faint); font-size: .92rem; margin-top: .4rem; max-width: 46rem; }
@media (max-width: 40rem) {
  .stacks thead { display: none; }
  .stacks, .stacks caption, .stacks tbody, .stacks tr, .stacks td, .stacks tbody th { display: block; }
  .stacks tr { border-bottom: 1px solid var(--line); padding: .5rem 0; }
  .stacks th, .stacks td { border: 0; padding: .2rem 0; }
  .stacks td::before { content: attr(data-head); display: block; color: var(--faint); font-size: .8rem; } }
details { margin: 1rem 0; border-left: .2rem solid var(--line); padding-left: .8rem; }
summary { cursor: pointer; color: var(--link); font-weight: 600; }
@media print { details::details-content { content-visibility: visible; block-size: auto; } }
@media print { .scroll { overflow: visible; } nav { display: none; } figure, tr { break-inside: avoid; } }
)css";

std::string words_of(const HtmlCell& cell) {
  const std::string text = html_text(cell.text);
  std::string words = text;
  // A mark besides the colour: not everybody sees that, and print may have none.
  if (cell.tone == HtmlTone::good) words = "<span class=\"good\">✓ " + text + "</span>";
  if (cell.tone == HtmlTone::bad) words = "<span class=\"bad\">✗ " + text + "</span>";
  if (cell.tone == HtmlTone::open) words = "<span class=\"open\">? " + text + "</span>";
  if (!cell.second_line.empty()) words += "<small>" + html_text(cell.second_line) + "</small>";
  return words;
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string escaped;
  while (!text.empty()) {
    const std::size_t length = character_at(text);
    const auto first = static_cast<unsigned char>(text[0]);
    if (length == 0)
      escaped += "\uFFFD";
    else if (first == '&')
      escaped += "&amp;";
    else if (first == '<')
      escaped += "&lt;";
    else if (first == '>')
      escaped += "&gt;";
    else if (first == '"')
      escaped += "&quot;";
    else if (first == '\'')
      escaped += "&#39;";
    else if (first < 0x20 || first == 0x7F)
      escaped += ' ';
    else
      escaped += text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return escaped;
}

void HtmlPage::section(std::string_view id, std::string_view heading) {
  sections_.emplace_back(html_text(id), html_text(heading));
  body_ += fmt::format("<h2 id=\"{}\">{}</h2>\n", sections_.back().first, sections_.back().second);
}

void HtmlPage::heading(std::string_view text) { here() += fmt::format("<h3>{}</h3>\n", html_text(text)); }

void HtmlPage::paragraph(std::string_view text) { here() += fmt::format("<p>{}</p>\n", html_text(text)); }

void HtmlPage::warning(std::string_view text) { here() += fmt::format("<p class=\"warning\">{}</p>\n", html_text(text)); }

void HtmlPage::list(const std::vector<std::string>& items) {
  here() += "<ul>\n";
  for (const std::string& item : items) here() += fmt::format("<li>{}</li>\n", html_text(item));
  here() += "</ul>\n";
}

void HtmlPage::table(const HtmlTable& table) {
  if (table.rows.empty()) return;
  if (!table.folded.empty()) begin_folded(table.folded);
  std::string& page = here();
  // What scrolls must be reachable without a mouse.
  page += fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" "
      "aria-label=\"{0}\"><table{1}>\n<caption><span>{0}</span></caption>\n<thead><tr>",
      html_text(table.caption), table.stacks ? " class=\"stacks\"" : "");
  for (std::size_t i = 0; i < table.head.size(); ++i) {
    const bool over_numbers = i > 0 && i < table.rows.front().size() && table.rows.front()[i].tone == HtmlTone::number;
    page += fmt::format("<th scope=\"col\"{}>{}</th>", over_numbers ? " class=\"number\"" : "", html_text(table.head[i]));
  }
  page += "</tr></thead>\n<tbody>\n";
  for (const std::vector<HtmlCell>& row : table.rows) {
    page += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool is_number = row[i].tone == HtmlTone::number, is_long = characters_in(row[i].text) > long_text;
      const bool is_named = table.stacks && i > 0 && i < table.head.size();
      page += fmt::format("<{}{}{}>{}</{}>", i == 0 ? "th scope=\"row\"" : "td",
                          is_number ? " class=\"number\""
                          : is_long ? " class=\"long\""
                                    : "",
                          is_named ? fmt::format(" data-head=\"{}\"", html_text(table.head[i])) : "", words_of(row[i]),
                          i == 0 ? "th" : "td");
    }
    page += "</tr>\n";
  }
  page += "</tbody>\n</table></div>\n";
  if (!table.folded.empty()) end_folded();
}

void HtmlPage::figure(const HtmlFigure& figure) {
  here() += fmt::format(
      "<figure id=\"{0}\"><svg viewBox=\"0 0 {1} {2}\" style=\"max-width:{1}px\" role=\"img\" aria-label=\"{3}\">{4}\n"
      "<figcaption>{5}</figcaption></figure>\n",
      html_text(figure.id), figure.width_px, figure.height_px, html_text(figure.in_words), inner_svg(figure.svg, figure.id),
      html_text(figure.caption));
}

void HtmlPage::begin_folded(std::string_view summary) {
  here() += fmt::format("<details><summary>{}</summary>\n", html_text(summary));
}

void HtmlPage::end_folded() { here() += "</details>\n"; }

std::string HtmlPage::text() const {
  std::string contents;
  for (const auto& [id, heading] : sections_) contents += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", id, heading);
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n"
      "<title>{0}</title>\n<style>{1}:root {{ {5} }}\n@media (prefers-color-scheme: dark) {{ :root {{ {6} }} "
      "}}\n</style>\n</head>\n<body>\n<main>\n<h1>{0}</h1>\n{2}<nav "
      "aria-label=\"Contents\"><ul>\n{3}</ul></nav>\n"
      "{4}</main>\n</body>\n</html>\n",
      html_text(title_), style, before_, contents, body_, palette_css(false), palette_css(true));
}

}  // namespace tactile::report
