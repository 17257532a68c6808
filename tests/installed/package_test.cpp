#include <fmt/core.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <regex>

#include "installation.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/version.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

std::string deb(const std::string& name) { return fmt::format("{}_{}_amd64.deb", name, version()); }

TEST(Package, HasTheInstalledFilesNamesItsLibrariesAndIsRemovedWithoutATrace) {
  const test::TemporaryFolder folder;
  const auto made = test::run_shell(fmt::format("DEBEMAIL=hand@lab.example DEBFULLNAME='A Hand' '{}/scripts/package' '{}'",
                                                test::source_folder, folder.path().string()));
  ASSERT_EQ(made.exit_code, 0) << made.out << made.err;
  ASSERT_TRUE(fs::exists(folder / deb("tactile")) && fs::exists(folder / deb("tactile-dev"))) << made.out;

  const std::string control = test::run_shell(fmt::format("dpkg-deb -f {}", deb("tactile")), folder.path()).out;
  EXPECT_NE(control.find("\nVersion: " + std::string(version()) + "\n"), std::string::npos) << control;
  EXPECT_NE(control.find("\nMaintainer: A Hand <hand@lab.example>\n"), std::string::npos) << control;
  for (const char* library :
       {"libtorch", "libopencv-core", "libhdf5", "libdeflate", "libavcodec", "libstdc\\+\\+", "gnuplot-nox"})
    EXPECT_TRUE(std::regex_search(control, std::regex(fmt::format("\nDepends: .*{}", library)))) << library << "\n" << control;
  EXPECT_EQ(control.find("-dev"), std::string::npos) << control;

  ASSERT_EQ(test::run_shell(fmt::format("dpkg-deb -x {} unpacked", deb("tactile")), folder.path()).exit_code, 0);
  const std::set<std::string> files = test::files_below(folder / "unpacked/usr");
  EXPECT_TRUE(files.contains("bin/tactile") && files.contains("share/zsh/vendor-completions/_tactile") &&
              files.contains("share/man/man1/tactile-label.1.gz"));
  ASSERT_EQ(test::install_to(folder / "usr", "program").exit_code, 0);
  EXPECT_EQ(files, test::files_below(folder / "usr"));
  const auto simulated = test::run_shell("unpacked/usr/bin/tactile simulate --preset tiny --objects fan --quiet", folder.path());
  EXPECT_EQ(simulated.exit_code, 0) << simulated.err;

  if (::geteuid() != 0) GTEST_SKIP() << "only root may install a package, also into another root";
  const auto with_root = [&folder](const std::string& arguments) {
    return test::run_shell(fmt::format("dpkg --root=\"$PWD/root\" --force-depends {}", arguments), folder.path());
  };
  ASSERT_EQ(test::run_shell("mkdir -p root/var/lib/dpkg/info root/var/lib/dpkg/updates && touch root/var/lib/dpkg/status",
                            folder.path())
                .exit_code,
            0);
  const auto installed = with_root("-i " + deb("tactile"));
  ASSERT_EQ(installed.exit_code, 0) << installed.err;
  EXPECT_TRUE(fs::exists(folder / "root/usr/bin/tactile"));
  EXPECT_EQ(test::run_shell("root/usr/bin/tactile doctor --quiet", folder.path()).exit_code, 0);
  const auto removed = with_root("-r tactile");
  EXPECT_EQ(removed.exit_code, 0) << removed.err;
  for (const std::string& file : test::files_below(folder / "root")) EXPECT_TRUE(file.starts_with("var/l")) << file;
  EXPECT_FALSE(fs::exists(folder / "root/usr"));
}

}  // namespace
}  // namespace tactile::cli
