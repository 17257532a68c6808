#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>
#include <vector>

#include "installation.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

/// A folder with two runs, two models and a file, and the completions that the program wrote.
class Completion : public testing::Test {
 protected:
  Completion() {
    EXPECT_EQ(test::run_tactile(fmt::format("pages '{}'", pages_.path().string())).exit_code, 0);
    for (const char* file : {"data/fan/01/events.aedat4", "data/usb-hub/02/events.aedat4", "data/usb-hub/no-run/other.txt",
                             "models/first/model.json", "models/second/model.json", "models/no-model/other.txt",
                             "others/third/model.json", "hot.csv", "notes.txt", "a b.txt"}) {
      fs::create_directories((work_ / file).parent_path());
      write_whole(work_ / file, "");
    }
  }

  /// What bash offers after this line, sorted.
  std::vector<std::string> bash(const std::string& line) const {
    // bash splits a line at blanks, and at : and =, which are words by themselves.
    const std::string script = fmt::format(
        "source '{}'\nCOMP_LINE='{}'\nCOMP_POINT=${{#COMP_LINE}}\nsplit=${{COMP_LINE//:/ : }}\nread -ra COMP_WORDS "
        "<<<\"${{split//=/ = }}\"\n"
        "[[ $COMP_LINE == *[[:space:]:=] ]] && COMP_WORDS+=('')\nCOMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))\n"
        "\"$(complete -p tactile | sed 's/.*-F \\([^ ]*\\).*/\\1/')\"\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
        (pages_ / "bash" / "tactile").string(), line);
    write_whole(pages_ / "line.sh", script);
    return sorted_lines(test::run_shell(fmt::format("bash '{}'", (pages_ / "line.sh").string()), work_.path()));
  }

  /// What fish offers after this line that begins with its last word, without descriptions, sorted. From version 4 on, fish also
  /// offers words that contain the same letters elsewhere.
  std::vector<std::string> fish(const std::string& line) const {
    auto offered =
        sorted_lines(test::run_shell(fmt::format("HOME='{0}' fish --no-config -c \"source '{1}'; complete -C '{2}'\" | cut -f 1",
                                                 pages_.path().string(), (pages_ / "fish" / "tactile.fish").string(), line),
                                     work_.path()));
    const std::string typed = line.substr(line.rfind(' ') + 1);
    std::erase_if(offered, [&](const std::string& word) { return !word.starts_with(typed); });
    return offered;
  }

  /// The line that a terminal's zsh runs after Tab and Enter; nothing if it does not run one.
  std::string zsh(const std::string& line) const {
    const std::string script = fmt::format(
        "zmodload zsh/zpty\nzpty z 'zsh -f -i'\n"
        "zpty -w z \"PROMPT=; fpath=('{0}' \\$fpath); autoload -Uz compinit; compinit -u -D; tactile() {{ print -r -- "
        "\\\"<\\$*>\\\" }}; "
        "cd '{1}'; print be''gun\"\nzpty -r z out '*begun*'\n"
        "zpty -n -w z $'{2}\\t\\n'\nzpty -r z out $'*\\n<*>*'\nprint -r -- \"${{${{out#*$'\\n'<}}%%>*}}\"\nzpty -d z\n",
        (pages_ / "zsh").string(), work_.path().string(), line);
    write_whole(pages_ / "line.zsh", script);
    const std::string out = test::run_shell(fmt::format("timeout 120 zsh -f '{}'", (pages_ / "line.zsh").string())).out;
    return out.substr(0, out.find_first_of("\r\n"));
  }

 private:
  static std::vector<std::string> sorted_lines(const test::CommandResult& result) {
    EXPECT_EQ(result.err, "");
    std::vector<std::string> lines;
    std::istringstream text(result.out);
    for (std::string line; std::getline(text, line);) {
      if (!line.empty()) lines.push_back(line);
    }
    std::sort(lines.begin(), lines.end());
    return lines;
  }

  test::TemporaryFolder pages_, work_;
};

using Words = std::vector<std::string>;

TEST_F(Completion, OfBashOffersCommandsOptionsAndValues) {
  const std::vector<std::pair<std::string, Words>> cases{
      {"tactile tr", {"trade", "train"}},
      {"tactile help rep", {"repair", "report", "reproduce"}},
      {"tactile label --com", {"--compare-truth"}},
      {"tactile simulate --preset ", {"paper", "quick", "tiny"}},
      {"tactile simulate --seed 1 --preset t", {"tiny"}},
      {"tactile simulate --preset=q", {"quick"}},
      {"tactile simulate --seed ", {}},
      {"tactile record --preview --out data/f", {"data/fan/"}},
      {"tactile record --preview --st", {"--start-on", "--stop-on", "--stream"}},
      {"tactile simulate --objects fan,water", {"fan,water-bottle"}},
      {"tactile stress --recipe hot", {"hot-pixels"}},
      {"tactile pages", {}}};
  for (const auto& [line, offered] : cases) EXPECT_EQ(bash(line), offered) << line;
}

TEST_F(Completion, OfBashOffersRunsModelsAndFilesThatExist) {
  const std::vector<std::pair<std::string, Words>> cases{
      {"tactile info a", {"a\\ b.txt"}},
      {"tactile info ", {"a\\ b.txt", "data/", "data/fan/01", "data/usb-hub/02", "hot.csv", "models/", "notes.txt", "others/"}},
      {"tactile review m", {"models/"}},
      {"tactile label data/u", {"data/usb-hub/", "data/usb-hub/02"}},
      {"tactile windows ", {"data/", "models/", "others/"}},
      {"tactile eval --run ", {"fan/01", "usb-hub/02"}},
      {"tactile eval --run fan/01,u", {"fan/01,usb-hub/02"}},
      {"tactile eval --model ", {"first", "second"}},
      {"tactile eval --models others --model ", {"third"}},
      {"tactile label --mask ", {"data/", "hot.csv", "models/", "others/"}},
      {"tactile detect --from file:data/fan/", {"data/fan/01"}},
      {"tactile convert data/fan/01 n", {"notes.txt"}}};
  for (const auto& [line, offered] : cases) EXPECT_EQ(bash(line), offered) << line;
}

TEST_F(Completion, OfBashHasEveryOptionOfEveryCommand) {
  for (const char* command : {"simulate", "record", "label", "train", "trade", "doctor"}) {
    std::istringstream help(test::run_tactile(fmt::format("{} --help", command)).out);
    const Words offered = bash(fmt::format("tactile {} --", command));
    int options = 0;
    for (std::string line; std::getline(help, line);) {
      const std::size_t begin = line.starts_with("  -h, ") ? 6 : 2;
      if (!line.starts_with("  -")) continue;
      const std::string option = line.substr(begin, line.find(' ', begin) - begin);
      EXPECT_TRUE(std::find(offered.begin(), offered.end(), option) != offered.end()) << command << " " << option;
      ++options;
    }
    EXPECT_EQ(static_cast<int>(offered.size()), options) << command;
  }
}

TEST_F(Completion, OfFishOffersTheSame) {
  const std::vector<std::pair<std::string, Words>> cases{
      {"tactile tr", {"trade", "train"}},
      {"tactile help rep", {"repair", "report", "reproduce"}},
      {"tactile label --com", {"--compare-truth"}},
      {"tactile simulate --preset ", {"paper", "quick", "tiny"}},
      {"tactile simulate --objects fan,water", {"fan,water-bottle"}},
      {"tactile stress --recipe hot", {"hot-pixels"}},
      {"tactile info data/", {"data/fan/", "data/fan/01", "data/usb-hub/", "data/usb-hub/02"}},
      {"tactile eval --run fan/01,u", {"fan/01,usb-hub/02"}},
      {"tactile eval --models others --model t", {"third"}},
      {"tactile eval --model s", {"second"}}};
  for (const auto& [line, offered] : cases) EXPECT_EQ(fish(line), offered) << line;
}

TEST_F(Completion, OfZshCompletesTheSame) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"tactile lab", "label"},
      {"tactile help trai", "help train"},
      {"tactile label --compare", "label --compare-truth"},
      {"tactile simulate --preset t", "simulate --preset tiny"},
      {"tactile simulate --preset=q", "simulate --preset=quick"},
      {"tactile simulate --objects fan,water", "simulate --objects fan,water-bottle"},
      {"tactile info data/usb-hub/0", "info data/usb-hub/02"},
      {"tactile eval --run fan/01,u", "eval --run fan/01,usb-hub/02"},
      {"tactile eval --models others --model t", "eval --models others --model third"},
      {"tactile label --mask h", "label --mask hot.csv"}};
  for (const auto& [line, run] : cases) EXPECT_EQ(zsh(line), run) << line;
}

}  // namespace
}  // namespace tactile::cli
