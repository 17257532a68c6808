#include "tactile/pictures/gnuplot.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::pictures {
namespace {

using test::error_of;
using test::files_in;
using test::TemporaryFolder;

Plot line_plot() {
  return {.script = "set yrange [0:10]\nplot $line with lines lw 3 lc rgb 'red' notitle",
          .tables = {{.name = "line", .columns = 2, .values = {0, 1, 1, 9, 2, std::numeric_limits<double>::quiet_NaN(), 3, 5}}},
          .width_px = 300,
          .height_px = 200};
}

/// A variable of the environment, put back when it goes.
class WithVariable {
 public:
  WithVariable(std::string name, const std::string& value) : name_(std::move(name)) {
    if (const char* before = std::getenv(name_.c_str())) before_ = before;
    ::setenv(name_.c_str(), value.c_str(), 1);
  }
  ~WithVariable() { ::setenv(name_.c_str(), before_.c_str(), 1); }
  WithVariable(const WithVariable&) = delete;
  WithVariable& operator=(const WithVariable&) = delete;

 private:
  std::string name_, before_;
};

TEST(Draw, MakesAPngOfTheSizeWithTheLineInIt) {
  const TemporaryFolder folder;
  draw(line_plot(), folder / "line.png");
  const cv::Mat picture = cv::imread((folder / "line.png").string());
  EXPECT_EQ(picture.size(), cv::Size(300, 200));
  int red = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      red += pixel[2] > 200 && pixel[1] < 80 && pixel[0] < 80 ? 1 : 0;
    }
  }
  EXPECT_GT(red, 50);
}

TEST(Draw, MakesAnSvg) {
  const TemporaryFolder folder;
  Plot plot = line_plot();
  plot.script = "set label " + plot_text("<a> & 'b'") + " at graph 0.5, 0.5\n" + plot.script;
  draw(plot, folder / "line.svg");
  const std::string svg = read_text(folder / "line.svg");
  EXPECT_NE(svg.find("<svg"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_NE(svg.find("font-size=\"13.33\""), std::string::npos) << "10 points, as large as in the PNG";
  EXPECT_NE(svg.find("&amp; ’b’"), std::string::npos) << svg;
}

TEST(Draw, GivesTheSameBytesAgainAlsoOnThreads) {
  const TemporaryFolder folder;
  draw(line_plot(), folder / "first.png");
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int i = 0; i < 4; ++i) threads.emplace_back([&, i] { draw(line_plot(), folder / (std::to_string(i) + ".png")); });
  for (std::thread& thread : threads) thread.join();
  const std::string first = read_text(folder / "first.png");
  for (int i = 0; i < 4; ++i) EXPECT_EQ(read_text(folder / (std::to_string(i) + ".png")), first);
}

TEST(Draw, TakesTextAsItIs) {
  const TemporaryFolder folder;
  const auto picture_of = [&](const std::string& text) {
    Plot plot = line_plot();
    plot.script = "set title " + plot_text(text) + "\n" + plot.script;
    draw(plot, folder / "text.svg");
    return read_text(folder / "text.svg");
  };
  const std::string harm = (folder / "harm").string();
  EXPECT_NE(picture_of("`touch " + harm + "`").find("`touch"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(harm));
  EXPECT_NE(picture_of("it's x_1^2 @a {b} 50% \\n #").find("it’s x_1^2 @a {b} 50% \\n #"), std::string::npos);
  EXPECT_NE(picture_of("'; system \"touch " + harm + "\"; '").find("touch"), std::string::npos);
  EXPECT_NE(picture_of("a\nsystem 'touch " + harm + "'").find("a system"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(harm));
  EXPECT_NE(picture_of("\xC3\xA9 \xFF \xC3").find("\xC3\xA9 ? ?"), std::string::npos);
}

TEST(PlotText, QuotesAndMends) {
  EXPECT_EQ(plot_text(""), "''");
  EXPECT_EQ(plot_text("it's"), "'it’s'");
  EXPECT_EQ(plot_text("a\tb\r\nc\x7F"), "'a b  c '");
  EXPECT_EQ(plot_text("µs → 10 €\xF0\x9F\x98\x80"), "'µs → 10 €\xF0\x9F\x98\x80'");
  EXPECT_EQ(plot_text("\xC0\xAF|\xED\xA0\x80|\xF5|\xE2\x82"), "'?\?|?\?\?|?|?\?'") << "too long, half a pair, none, cut off";
}

TEST(Draw, ReportsWhatGnuplotComplainsOfAndLeavesNothing) {
  const TemporaryFolder folder;
  Plot plot = line_plot();
  plot.script = "plot nonsense(x) wrong";
  const std::string error = error_of([&] { draw(plot, folder / "line.png"); });
  EXPECT_NE(error.find("line.png: gnuplot could not draw it (line"), std::string::npos) << error;
  plot.script = "exit";
  EXPECT_NE(error_of([&] { draw(plot, folder / "line.png"); }).find("could not draw it"), std::string::npos) << "no picture";
  EXPECT_EQ(files_in(folder.path()), 0U);
}

TEST(Draw, KeepsThePictureThatIsThereIfItFails) {
  const TemporaryFolder folder;
  draw(line_plot(), folder / "line.png");
  const std::string before = read_text(folder / "line.png");
  Plot plot = line_plot();
  plot.script = "plot wrong(";
  error_of([&] { draw(plot, folder / "line.png"); });
  EXPECT_EQ(read_text(folder / "line.png"), before);
}

TEST(Draw, ExplainsHowToInstallGnuplotWhereItIsNot) {
  const TemporaryFolder folder;
  const WithVariable no_programs("PATH", folder.path().string());
  const std::string error = error_of([&] { draw(line_plot(), folder / "line.png"); });
  EXPECT_NE(error.find("gnuplot: is not installed"), std::string::npos) << error;
  EXPECT_NE(error.find("apt install gnuplot-nox"), std::string::npos) << error;
}

TEST(Draw, ReportsWhatEndedGnuplot) {
  const TemporaryFolder folder;
  {
    std::ofstream(folder / "gnuplot") << "#!/bin/sh\nkill -TERM $$\n";
    std::filesystem::permissions(folder / "gnuplot", std::filesystem::perms::owner_all);
  }
  const WithVariable own("PATH", folder.path().string());
  const std::string error = error_of([&] { draw(line_plot(), folder / "line.png"); });
  EXPECT_NE(error.find("ended by signal 15"), std::string::npos) << error;
}

TEST(Draw, ReadsNoSettingsOfTheUsers) {
  const TemporaryFolder folder;
  draw(line_plot(), folder / "before.png");
  std::ofstream(folder / ".gnuplot") << "set title 'mine'\n";
  const WithVariable home("HOME", folder.path().string());
  draw(line_plot(), folder / "after.png");
  EXPECT_EQ(read_text(folder / "before.png"), read_text(folder / "after.png"));
}

TEST(Draw, TakesManyNumbers) {
  const TemporaryFolder folder;
  Plot plot = line_plot();
  plot.tables[0].values.clear();
  for (int i = 0; i < 100'000; ++i) {
    plot.tables[0].values.push_back(i);
    plot.tables[0].values.push_back(i % 10);
  }
  draw(plot, folder / "many.png");
  EXPECT_EQ(cv::imread((folder / "many.png").string()).size(), cv::Size(300, 200));
}

TEST(Draw, RefusesWhatItCannotDraw) {
  const TemporaryFolder folder;
  EXPECT_NE(error_of([&] { draw(line_plot(), folder / "line.pdf"); }).find("expected .png or .svg"), std::string::npos);
  Plot plot = line_plot();
  plot.width_px = 100'000;
  EXPECT_NE(error_of([&] { draw(plot, folder / "line.png"); }).find("100000 x 200 pixels"), std::string::npos);
  plot = line_plot();
  plot.tables[0].name = "a;b";
  EXPECT_NE(error_of([&] { draw(plot, folder / "line.png"); }).find("'a;b'"), std::string::npos);
  plot = line_plot();
  plot.tables[0].columns = 3;
  EXPECT_NE(error_of([&] { draw(plot, folder / "line.png"); }).find("8 values in rows of 3"), std::string::npos);
}

}  // namespace
}  // namespace tactile::pictures
