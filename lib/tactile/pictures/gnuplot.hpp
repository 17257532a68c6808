#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tactile::pictures {

/// Numbers that a script reads as `$name`.
struct PlotTable {
  std::string name;            ///< a letter, then letters, digits and underscores
  std::size_t columns = 2;     ///< > 0
  std::vector<double> values;  ///< row by row, whole rows; what is not finite is a gap
};

/// A figure in gnuplot's words.
struct Plot {
  std::string script;  ///< its commands; encoding, terminal and output are set, and text is taken as it is (`noenhanced`)
  std::vector<PlotTable> tables;
  int width_px = 1600;   ///< 100 to 10'000
  int height_px = 1000;  ///< 100 to 10'000
};

/// `text` as a string in a script, in which no character has a meaning for gnuplot. An apostrophe becomes the typographic
/// one, control characters become blanks, bytes that are no UTF-8 question marks.
std::string plot_text(std::string_view text);

/// For an early check before long work. @throws Error  if `draw` cannot write this extension
void check_is_picture(const std::filesystem::path& file);

/// Draws the figure as PNG or SVG, by the file's extension, whole or not at all; the same figure gives the same bytes. Words
/// are as large in both: a point is 4/3 px, so that 11 points are 14.7 px in a figure shown as wide as it is. Runs
/// the system's gnuplot, which reads script and numbers from memory and answers through a pipe: no shell, no other files, no
/// settings of the user.
/// @throws Error  if gnuplot is not installed, rejects the script, or dies; if the extension is another, a size or a
///                table out of range, or the file cannot be written
/// Source: gnuplot 5.4, terminals `pngcairo` and `svg`.
void draw(const Plot& plot, const std::filesystem::path& file);

}  // namespace tactile::pictures
