#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "installation.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::cli {
namespace {

struct Row {
  std::string t, predicted;
  double p_press = 0;
};

/// The rows of a table whose columns begin with these, in this order: time, ..., class.
std::vector<Row> rows_of(const std::string& csv, std::size_t press, std::size_t predicted) {
  std::vector<Row> rows;
  std::istringstream text(csv);
  std::string line;
  for (std::getline(text, line); std::getline(text, line);) {
    std::vector<std::string> cells;
    std::istringstream of_line(line);
    for (std::string cell; std::getline(of_line, cell, ',');) cells.push_back(cell);
    rows.push_back({cells.at(0), cells.at(predicted), std::stod(cells.at(press))});
  }
  return rows;
}

TEST(Libraries, OfAnInstallationBuildTheExampleWhichPredictsAsEval) {
  const test::TemporaryFolder folder;
  const auto installed = test::install_to(folder / "tactile");
  ASSERT_EQ(installed.exit_code, 0) << installed.err;
  const auto built = test::run_shell(
      fmt::format("'{0}' -S tactile/share/doc/tactile-dev/examples/predict -B built -DCMAKE_BUILD_TYPE=Release "
                  "-DCMAKE_PREFIX_PATH=\"$PWD/tactile\" '-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror' && '{0}' --build built",
                  test::cmake_program),
      folder.path());
  ASSERT_EQ(built.exit_code, 0) << built.out << built.err;
  EXPECT_EQ(test::run_shell("ldd built/predict | grep -c libtorch", folder.path()).out, "0\n");

  for (const char* command : {"simulate --preset tiny --objects fan,usb-hub", "label", "windows", "train --epochs 2 --name m",
                              "eval --model m --run fan/02"}) {
    const auto result = test::run_shell(fmt::format("tactile/bin/tactile {} --quiet", command), folder.path());
    ASSERT_EQ(result.exit_code, 0) << command << "\n" << result.err;
  }
  const auto predicted = test::run_shell("built/predict data/fan/02/events.aedat4 models/m", folder.path());
  ASSERT_EQ(predicted.exit_code, 0) << predicted.err;
  const std::vector<Row> rows = rows_of(predicted.out, 3, 1);
  const std::vector<Row> of_eval = rows_of(test::text_in_file(folder / "models/m/runs/fan-02.csv"), 2, 4);
  ASSERT_GT(rows.size(), 1000U);
  ASSERT_EQ(rows.size(), of_eval.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].t, of_eval[i].t);
    EXPECT_EQ(rows[i].predicted, of_eval[i].predicted) << rows[i].t;
    EXPECT_NEAR(rows[i].p_press, of_eval[i].p_press, 1e-5) << rows[i].t;  // the example prints six digits
  }
  const auto failed = test::run_shell("built/predict no.aedat4 models/m", folder.path());
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_TRUE(failed.err.starts_with("predict: no.aedat4: ")) << failed.err;
}

TEST(Libraries, OfAnInstallationAreLinkedIntoASharedLibrary) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(test::install_to(folder / "tactile", "development").exit_code, 0);
  std::ofstream(folder / "CMakeLists.txt") << "cmake_minimum_required(VERSION 3.25)\n"
                                              "project(plugin LANGUAGES C CXX)\n"
                                              "find_package(tactile REQUIRED COMPONENTS events model)\n"
                                              "add_library(plugin SHARED plugin.cpp)\n"
                                              "target_link_libraries(plugin PRIVATE tactile::events tactile::model)\n"
                                              "target_link_options(plugin PRIVATE -Wl,--no-undefined)\n";
  std::ofstream(folder / "plugin.cpp") << "#include <tactile/events/recording_reader.hpp>\n"
                                          "#include <tactile/model/inference/classifier.hpp>\n"
                                          "std::size_t packets_of(const char* file) {\n"
                                          "  return tactile::events::RecordingReader(file).packets().size();\n"
                                          "}\n"
                                          "float th_ms_of(const char* bundle) {\n"
                                          "  return tactile::model::Classifier(bundle).rendering().history.count() / 1e3f;\n"
                                          "}\n";
  const auto built = test::run_shell(
      fmt::format("'{0}' -B built -DCMAKE_PREFIX_PATH=\"$PWD/tactile\" && '{0}' --build built", test::cmake_program),
      folder.path());
  EXPECT_EQ(built.exit_code, 0) << built.out << built.err;
}

TEST(Libraries, ThatAreNotThereAreNamedByCMake) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(test::install_to(folder / "tactile", "development").exit_code, 0);
  const auto result =
      test::run_shell(fmt::format("printf 'cmake_minimum_required(VERSION 3.25)\\nproject(p LANGUAGES C CXX)\\n"
                                  "find_package(tactile REQUIRED COMPONENTS events windmill)\\n' >CMakeLists.txt; '{}' -B b "
                                  "-DCMAKE_PREFIX_PATH=\"$PWD/tactile\"",
                                  test::cmake_program),
                      folder.path());
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.err.find("tactile has no component 'windmill'"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tactile::cli
