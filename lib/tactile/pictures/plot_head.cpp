#include "tactile/pictures/plot_head.hpp"

#include <algorithm>

#include "tactile/core/text_lines.hpp"

namespace tactile::pictures {
namespace {

// [px]; characters are as wide as in most words
constexpr int side = 20, title_row = 26, key_row = 20, sample_width = 30, between_entries = 22;
constexpr double title_character = 10.4, word_character = 8.3;

std::vector<std::string> lines_within(const std::string& words, int width_px, double character_px) {
  return lines_of(wrapped(words, 0, static_cast<std::size_t>(std::max(20.0, (width_px - 2 * side) / character_px))));
}

}  // namespace

std::string shortened(std::string_view text, std::size_t characters) {
  if (characters_in(text) <= characters) return std::string(text);
  // Where characters begin.
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U) begins.push_back(i);
  }
  if (begins.size() <= characters) return std::string(text);
  const std::size_t kept = characters - 1, front = (kept + 1) / 2, back = kept / 2;
  const std::size_t front_end = begins[front];
  const std::size_t back_begin = back == 0 ? text.size() : begins[begins.size() - back];
  return std::string(text.substr(0, front_end)) + "…" + std::string(text.substr(back_begin));
}

PlotHead::PlotHead(std::string_view title, int width_px) : width_px_(width_px), bottom_(12) {
  constexpr double rows = 1.8;  // lines seldom fill their row
  const auto most = static_cast<std::size_t>(rows * (width_px - 2 * side) / title_character);
  for (std::string& line : lines_within(shortened(title, most), width_px, title_character)) {
    title_.push_back({std::move(line), bottom_ + title_row / 2});
    bottom_ += title_row;
  }
}

void PlotHead::key(const std::string& words, const LineStyle& style) {
  const int width = sample_width + 8 + static_cast<int>(word_character * static_cast<double>(characters_in(words)));
  if (next_x_ == 0 || next_x_ + width > width_px_ - side) {
    next_x_ = side;
    bottom_ += key_row;
  }
  keys_.push_back({words, next_x_, bottom_ - key_row / 2, style});
  next_x_ += width + between_entries;
}

void PlotHead::note(const std::string& words) {
  if (words.empty()) return;
  next_x_ = 0;  // the next key begins a row
  for (std::string& line : lines_within(words, width_px_, word_character)) {
    bottom_ += key_row;
    notes_.push_back({std::move(line), bottom_ - key_row / 2});
  }
}

void PlotHead::write(PlotWriter& writer) const {
  for (const Line& line : title_) writer.write(line.words, side, line.y, "left font ',15' front", figure_colours::ink);
  for (const Line& line : notes_) writer.write(line.words, side, line.y, "left font ',12' front", figure_colours::faint_ink);
  for (const Entry& entry : keys_) {
    const auto& [words, x, y, style] = entry;
    const double right = x + sample_width;
    const auto [from_x, to_x] = std::pair(static_cast<double>(x) / width_px_, right / width_px_);
    const auto screen_y = [&](double pixel) { return 1 - pixel / writer.height_px(); };
    if (style.fill > 0) {
      writer.add(
          "set object rectangle from screen {:.6f}, screen {:.6f} to screen {:.6f}, screen {:.6f} fillcolor rgb '{}' "
          "fillstyle solid {:g} noborder",
          from_x, screen_y(y + 6), to_x, screen_y(y - 6), style.colour, style.fill);
    } else if (style.width > 0) {
      writer.add("set arrow from screen {:.6f}, screen {:.6f} to screen {:.6f}, screen {:.6f} nohead lc rgb '{}' dt {} lw {:g}",
                 from_x, screen_y(y), to_x, screen_y(y), style.colour, style.dashes, style.width);
    }
    if (style.mark)
      writer.write("", x + sample_width / 2.0, y,
                   fmt::format("point pt {} ps {:g} lw {:g} lc rgb '{}'", *style.mark, style.size, std::max(1.0, style.width),
                               style.colour),
                   style.colour);
    writer.write(words, right + 8, y, "left font ',12' front", figure_colours::ink);
  }
}

}  // namespace tactile::pictures
