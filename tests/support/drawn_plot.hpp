#pragma once

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/pictures/gnuplot.hpp"

namespace tactile::test {

/// Draws a plot as PNG and as SVG and returns the SVG. The test fails if the PNG has the wrong size.
inline std::string drawn(const pictures::Plot& plot) {
  const TemporaryFolder folder;
  pictures::draw(plot, folder / "figure.png");
  pictures::draw(plot, folder / "figure.svg");
  EXPECT_EQ(cv::imread((folder / "figure.png").string()).size(), cv::Size(plot.width_px, plot.height_px));
  return read_text(folder / "figure.svg");
}

}  // namespace tactile::test
