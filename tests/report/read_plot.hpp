#pragma once

#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"

namespace tactile::test {

/// An axis across a panel, with its tics in pixels.
struct XAxis {
  double begin = 0, end = 0;
  double left_px = 0, right_px = 0;
  bool is_aslant = false;
  struct Tic {
    std::string label;
    double place = 0;
  };
  std::vector<Tic> tics;

  double px(double place) const { return left_px + (right_px - left_px) * (place - begin) / (end - begin); }
  bool has(const std::string& label) const {
    return std::any_of(tics.begin(), tics.end(), [&label](const Tic& tic) { return tic.label == label; });
  }
};

inline std::vector<XAxis> x_axes(const pictures::Plot& plot) {
  static const std::regex margin("set ([lr])margin at screen ([0-9.]+)"),
      range(R"(set xrange \[(-?[0-9.e+-]+):(-?[0-9.e+-]+)\])"), tics(R"(set xtics (.*)\((.*)\))"),
      tic("'([^']*)' (-?[0-9.e+-]+)");
  std::vector<XAxis> axes;
  std::istringstream lines(plot.script);
  for (std::string line; std::getline(lines, line);) {
    std::smatch found;
    if (std::regex_match(line, found, margin)) {
      if (found[1] == "l") axes.emplace_back();
      (found[1] == "l" ? axes.back().left_px : axes.back().right_px) = std::stod(found[2]) * plot.width_px;
    } else if (std::regex_match(line, found, range)) {
      axes.back().begin = std::stod(found[1]), axes.back().end = std::stod(found[2]);
    } else if (std::regex_match(line, found, tics)) {
      axes.back().is_aslant = found[1].str().find("rotate by 45") != std::string::npos;
      const std::string list = found[2];
      for (auto at = std::sregex_iterator(list.begin(), list.end(), tic); at != std::sregex_iterator(); ++at)
        axes.back().tics.push_back({(*at)[1], std::stod((*at)[2])});
    }
  }
  return axes;
}

/// Words placed in a figure.
struct Words {
  std::string text;
  double x = 0, y = 0;  ///< [px] from the top left corner
};

inline std::vector<Words> words_in(const pictures::Plot& plot) {
  static const std::regex label("set label '([^']*)' at screen ([0-9.-]+), screen ([0-9.-]+) .*");
  std::vector<Words> words;
  std::istringstream lines(plot.script);
  for (std::string line; std::getline(lines, line);) {
    if (std::smatch found; std::regex_match(line, found, label))
      words.push_back({found[1], std::stod(found[2]) * plot.width_px, (1 - std::stod(found[3])) * plot.height_px});
  }
  return words;
}

}  // namespace tactile::test
