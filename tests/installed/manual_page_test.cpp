#include <fmt/core.h>
#include <gtest/gtest.h>

#include <regex>

#include "installation.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

/// The commands and options that a help lists, each at the start of a line.
std::set<std::string> entries_of(const std::string& help) {
  std::set<std::string> entries;
  const std::regex entry(R"((^|\n) {2}(?:-h, )?(--[a-z0-9-]+|[a-z]+)(?= |\n))");
  for (auto found = std::sregex_iterator(help.begin(), help.end(), entry); found != std::sregex_iterator(); ++found)
    entries.insert((*found)[2]);
  return entries;
}

class ManualPage : public testing::Test {
 protected:
  ManualPage() { EXPECT_EQ(test::run_tactile(fmt::format("pages '{}'", folder_.path().string())).exit_code, 0); }

  fs::path page(const std::string& command) const {
    return folder_ / "man1" / (command.empty() ? "tactile.1" : "tactile-" + command + ".1");
  }

  /// A page as `man` shows it.
  static test::CommandResult shown(const fs::path& page, const std::string& options = "") {
    return test::run_shell(fmt::format("MANWIDTH=100 LC_ALL=C.UTF-8 man {} -l '{}'", options, page.string()));
  }

  static std::set<std::string> commands() {
    std::set<std::string> names = entries_of(test::run_tactile("--help").out);
    std::erase_if(names, [](const std::string& name) { return name.starts_with("--"); });
    return names;
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(ManualPage, OfEachCommandHasEveryOptionOfItsHelp) {
  ASSERT_GE(commands().size(), 20U);
  for (const std::string& command : commands()) {
    const std::string text = shown(page(command)).out;
    const std::set<std::string> options = entries_of(test::run_tactile(command + " --help").out);
    EXPECT_TRUE(options.contains("--help") && options.contains("--threads")) << command;
    for (const std::string& option : options)
      EXPECT_TRUE(std::regex_search(text, std::regex("\n +(-h, )?" + option + "( |\n)"))) << command << " " << option << "\n"
                                                                                          << text;
  }
}

TEST_F(ManualPage, OfTheProgramNamesEveryCommandAndItsPage) {
  const std::string text = shown(page("")).out;
  for (const std::string& command : commands()) {
    EXPECT_TRUE(std::regex_search(text, std::regex("\n +" + command + "( |\n)"))) << command;
    EXPECT_NE(text.find("tactile-" + command + "(1)"), std::string::npos) << command;
  }
  EXPECT_EQ(text.find("pages"), std::string::npos);  // it is only for those who install
}

TEST_F(ManualPage, GivesGroffNoReasonToWarn) {
  int pages = 0;
  for (const auto& entry : fs::directory_iterator(page("").parent_path())) {
    const auto result = shown(entry.path(), "--warnings=w -E UTF-8");
    EXPECT_EQ(result.exit_code, 0) << entry.path();
    EXPECT_EQ(result.err, "") << entry.path();
    ++pages;
  }
  EXPECT_EQ(pages, static_cast<int>(commands().size()) + 1);
}

TEST_F(ManualPage, IsFoundByItsDescription) {
  const auto result = test::run_shell(fmt::format("lexgrog '{}'", page("doctor").string()));
  EXPECT_NE(result.out.find("\"tactile-doctor - Check this machine"), std::string::npos) << result.out << result.err;
}

TEST_F(ManualPage, IsTheSameWhereverItIsMade) {
  const std::string made = test::text_in_file(page("train"));
  const test::TemporaryFolder other;
  ASSERT_EQ(test::run_shell(fmt::format("taskset -c 0 '{}' pages . ", test::tactile_binary), other.path()).exit_code, 0);
  EXPECT_EQ(test::text_in_file(other / "man1" / "tactile-train.1"), made);
  EXPECT_NE(made.find("one per core"), std::string::npos);  // not the number of this machine's
}

}  // namespace
}  // namespace tactile::cli
