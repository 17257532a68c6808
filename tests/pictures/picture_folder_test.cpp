#include "tactile/pictures/picture_folder.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>
#include <vector>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile::pictures {
namespace {

namespace fs = std::filesystem;

const cv::Mat grey(3, 4, CV_8UC1, cv::Scalar(77));

void make(const fs::path& target, const std::vector<std::string>& names) {
  PictureFolder folder(target, "value");
  for (const std::string& name : names) {
    folder.write(name, grey);
    folder.list(name, "1");
  }
  EXPECT_EQ(folder.listed(), names.size());
  folder.commit();
}

std::set<std::string> files_below(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_directory()) names.insert(entry.path().lexically_relative(folder).string());
  }
  return names;
}

TEST(PictureFolder, AppearsWithItsListOnceItIsWhole) {
  const test::TemporaryFolder folder;
  {
    PictureFolder pictures(folder / "a/b", "value");
    pictures.write("fan/01/x.png", grey);
    pictures.list("fan/01/x.png", "5");
    EXPECT_FALSE(fs::exists(folder / "a/b"));
    pictures.commit();
  }
  EXPECT_EQ(files_below(folder.path()), (std::set<std::string>{"a/b/fan/01/x.png", "a/b/pictures.csv"}));
  EXPECT_EQ(read_text(folder / "a/b/pictures.csv"), "file,value\nfan/01/x.png,5\n");
  EXPECT_EQ(cv::norm(cv::imread((folder / "a/b/fan/01/x.png").string(), cv::IMREAD_UNCHANGED), grey), 0);
}

TEST(PictureFolder, LeavesNothingWhereItIsGivenUp) {
  const test::TemporaryFolder folder;
  { PictureFolder(folder / "given-up", "value").write("x.png", grey); }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  make(folder / "kept", {"old.png"});
  { PictureFolder(folder / "kept", "value").write("new.png", grey); }
  EXPECT_EQ(files_below(folder.path()), (std::set<std::string>{"kept/old.png", "kept/pictures.csv"}));
}

TEST(PictureFolder, ReplacesPicturesOfItsOwnAndAnEmptyFolder) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "empty");
  make(folder / "empty", {"a.png"});
  make(folder / "empty/", {"below/b.png"});
  EXPECT_EQ(files_below(folder.path()), (std::set<std::string>{"empty/below/b.png", "empty/pictures.csv"}));
  fs::create_directory_symlink("empty", folder / "link");
  make(folder / "link", {"c.png"});
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(files_below(folder / "empty"), (std::set<std::string>{"c.png", "pictures.csv"}));
}

TEST(PictureFolder, KeepsWhatAppearsWhileItIsFilled) {
  const test::TemporaryFolder folder;
  PictureFolder added(folder / "a", "value");
  make(folder / "b", {"old.png"});
  PictureFolder replaced(folder / "b", "value");
  fs::create_directories(folder / "a");
  for (const char* name : {"a/notes.txt", "b/notes.txt"}) std::ofstream(folder / name) << "precious";
  EXPECT_THROW(added.commit(), Error);
  EXPECT_THROW(replaced.commit(), Error);
  EXPECT_TRUE(fs::exists(folder / "a/notes.txt"));
  EXPECT_TRUE(fs::exists(folder / "b/notes.txt"));
  EXPECT_TRUE(fs::exists(folder / "b/old.png"));
}

TEST(PictureFolder, RefusesAFolderWithAnythingElseInIt) {
  const test::TemporaryFolder folder;
  make(folder / "mine", {"a.png"});
  std::ofstream(folder / "mine/notes.txt") << "precious";
  const std::string error = test::error_of([&] { PictureFolder(folder / "mine", "value"); });
  EXPECT_NE(error.find("mine: holds notes.txt, which is no picture"), std::string::npos) << error;
  EXPECT_THROW(check_picture_folder(folder / "mine"), Error);
  EXPECT_EQ(files_below(folder.path()), (std::set<std::string>{"mine/a.png", "mine/notes.txt", "mine/pictures.csv"}));
  fs::remove(folder / "mine/notes.txt");
  EXPECT_NO_THROW(check_picture_folder(folder / "mine"));

  std::ofstream(folder / "file") << "";
  EXPECT_NE(test::error_of([&] { PictureFolder(folder / "file", "value"); }).find("is a file"), std::string::npos);
  // A list of somebody else's is none of ours.
  fs::create_directories(folder / "other");
  std::ofstream(folder / "other/pictures.csv") << "name,size\nx.png,1\n";
  EXPECT_THROW(PictureFolder(folder / "other", "value"), Error);
  EXPECT_THROW(PictureFolder("/proc/nowhere/pictures", "value"), Error);
}

}  // namespace
}  // namespace tactile::pictures
