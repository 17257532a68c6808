#include "installation.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "support/temporary_folder.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

TEST(Installation, RunsWhereverItsFolderIsMoved) {
  const test::TemporaryFolder folder;
  const auto installed = test::install_to(folder / "first", "program");
  ASSERT_EQ(installed.exit_code, 0) << installed.err;
  fs::rename(folder / "first", folder / "second");
  fs::create_symlink(folder / "second/bin/tactile", folder / "tactile");

  fs::create_directory(folder / "work");
  const auto run = [&folder](const std::string& arguments) {
    return test::run_shell("PATH=\"$PWD/..:$PATH\" tactile " + arguments, folder / "work");
  };
  // The start of the README's pipeline.
  for (const char* command : {"simulate --preset tiny --objects fan,usb-hub", "label", "windows", "heatmaps --th 40", "info data",
                              "doctor", "--version"}) {
    const auto result = run(command);
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.err;
  }
  EXPECT_TRUE(fs::exists(folder / "work/data/fan/01/labels.png"));
  const std::string no_camera = run("record --from camera:NOTHERE --object fan").err;
  if (no_camera.find("no libcaer") != std::string::npos) {
    EXPECT_NE(no_camera.find("served by " + (folder / "second/share/tactile/scripts/dv-bridge").string()), std::string::npos)
        << no_camera;
  }
}

TEST(Installation, HasWhatEachReaderLooksFor) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(test::install_to(folder.path(), "program").exit_code, 0);
  const std::set<std::string> files = test::files_below(folder.path());
  for (const char* file :
       {"bin/tactile", "libexec/tactile/tactile-all", "libexec/tactile/tactile-torch.so", "libexec/tactile/tactile-opencv.so",
        "share/tactile/configs/scenes/hard.json", "share/tactile/scripts/dv-bridge", "share/doc/tactile/README.md",
        "share/doc/tactile/docs/cli/README.md", "share/doc/tactile/docs/pictures/run.png", "share/doc/tactile/copyright",
        "share/man/man1/tactile.1.gz", "share/man/man1/tactile-label.1.gz", "share/bash-completion/completions/tactile",
        "share/zsh/site-functions/_tactile", "share/fish/vendor_completions.d/tactile.fish"})
    EXPECT_TRUE(files.contains(file)) << file;
  const auto pages = test::run_shell(
      fmt::format("python3 '{}/tests/docs/check_pages.py' '{}'", test::source_folder, (folder / "share/doc/tactile").string()));
  EXPECT_EQ(pages.exit_code, 0) << pages.out << pages.err;
  for (const std::string& file : files) EXPECT_FALSE(file.ends_with(".a") || file.ends_with(".hpp")) << file;
  EXPECT_EQ(
      test::run_shell(fmt::format("man --warnings=w -l '{}' >/dev/null", (folder / "share/man/man1/tactile.1.gz").string())).err,
      "");
}

TEST(Installation, KnowsNoFolderOfTheBuild) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep the paths of sources for their messages";
#endif
  const test::TemporaryFolder folder;
  ASSERT_EQ(test::install_to(folder.path()).exit_code, 0);
  for (const std::string& file : test::files_below(folder.path())) {
    if (file.ends_with(".a")) continue;  // may have the paths of sources in messages
    const std::string contents = test::text_in_file(folder / file);
    EXPECT_EQ(contents.find(test::build_folder), std::string::npos) << file;
    EXPECT_EQ(contents.find(folder.path().string()), std::string::npos) << file;
  }
}

TEST(Installation, NamesBothPlacesIfAPartIsMissing) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "bin");
  fs::copy_file(test::tactile_binary, folder / "bin/tactile");
  const auto result = test::run_shell("bin/tactile label", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(
      result.err.ends_with("bin/tactile-all: cannot be run (No such file or directory); expected this part of tactile in the "
                           "folder of the program, or in "
                           "../libexec/tactile\n"))
      << result.err;
}

}  // namespace
}  // namespace tactile::cli
