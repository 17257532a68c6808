#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <sstream>
#include <thread>
#include <tuple>

#include "support/comes_true.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

using test::run_tactile;

const std::vector<std::string> commands{"simulate", "record", "serve",     "info",     "repair", "characterise", "convert",
                                        "label",    "review", "windows",   "heatmaps", "view",   "train",        "models",
                                        "eval",     "detect", "reproduce", "trade",    "report", "export",       "doctor"};

TEST(CommandLine, VersionNamesTheGitRevisionTheLibrariesAndTheCpuFeatures) {
  const auto result = run_tactile("--version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(std::regex_match(
      result.out, std::regex(R"(tactile \d+\.\d+\.\d+ \(.+\)\n)"
                             R"(libtorch +\d+\.\d+\..+\nOpenCV +\d+\.\d+\..+\nHDF5 +\d+\.\d+\.\d+\n)"
                             R"(FFmpeg +\d+\..+\nLZ4 +\d+\..+\nzstd +\d+\..+\nlibdeflate +\d+\..+\n)"
                             R"(CPU features +([A-Z0-9_-]+|no vector instructions) in use(, also [A-Z0-9_, ]+)?\n)")))
      << result.out;
}

TEST(CommandLine, HelpListsEveryCommandInTheOrderOfUse) {
  const auto result = run_tactile("--help");
  EXPECT_EQ(result.exit_code, 0);
  std::size_t place = 0;
  for (const std::string& command : commands) {
    const std::size_t found = result.out.find("\n  " + command + " ", place);
    ASSERT_NE(found, std::string::npos) << command << " in\n" << result.out;
    place = found;
  }
}

TEST(CommandLine, WordsForHelpAndVersionDoWhatTheOptionsDo) {
  for (const auto& [words, options] :
       {std::pair{"", "--help"}, {"help", "--help"}, {"help train", "train --help"}, {"version", "--version"}}) {
    const auto by_word = run_tactile(words), by_option = run_tactile(options);
    EXPECT_EQ(by_word.exit_code, 0) << words;
    EXPECT_EQ(by_word.out, by_option.out) << words;
  }
  EXPECT_EQ(run_tactile("help nonsense").exit_code, 106);
}

TEST(CommandLine, EveryCommandHasHelpWithTheCommonOptions) {
  for (const std::string& command : commands) {
    const auto result = run_tactile(command + " --help");
    EXPECT_EQ(result.exit_code, 0) << command;
    for (const char* option : {"--config", "--print-config", "--json", "--quiet", "--threads"})
      EXPECT_NE(result.out.find(option), std::string::npos) << command << " " << option;
  }
}

TEST(CommandLine, HelpKeepsWithin80Columns) {
  for (const std::string& command : commands) {
    std::istringstream help(run_tactile(command + " --help").out);
    int lines = 0;
    for (std::string line; std::getline(help, line); ++lines) EXPECT_LE(line.size(), 80U) << command << ": " << line;
    EXPECT_GT(lines, 8) << command;
  }
}

TEST(CommandLine, HelpListsOnceWhatAnOptionExcludesAndThatItTakesSeveralValues) {
  for (const std::string& command : commands) {
    std::istringstream words(run_tactile(command + " --help").out);
    std::string help;
    for (std::string word; words >> word;) help += word + " ";
    EXPECT_EQ(help.find("... ..."), std::string::npos) << command;
    EXPECT_FALSE(std::regex_search(help, std::regex("; not with --[a-z-]+; not with"))) << command;
    EXPECT_TRUE(command != "record" || help.find("; not with --object or --run ") != std::string::npos) << help;
  }
}

TEST(CommandLine, ReportsInOneSentenceWhatIsWrongAndWhatIsRight) {
  const std::vector<std::tuple<std::string, int, std::string>> cases{
      {"doctor --thrads 1", 109,
       "--thrads: is not an option of 'tactile doctor'; the nearest is '--threads', and 'tactile doctor --help' lists all"},
      {"doctor --thrads=1", 109,
       "--thrads: is not an option of 'tactile doctor'; the nearest is '--threads', and 'tactile doctor --help' lists all"},
      {"view a.aedat4 --ot a.png", 109,
       "--ot: is not an option of 'tactile view'; the nearest is '--out', and 'tactile view --help' lists all"},
      {"--json doctor", 109, "--json: precedes the command; expected 'tactile doctor --json'"},
      {"simulate data more", 109, "'more': is one argument too many; expected 'tactile simulate [OPTIONS] [DATA]'"},
      {"doctor --threads 0", 105, "--threads: 0 is out of range; expected 1 to 1024"},
      {"doctor --threads 1.5", 105, "--threads: 1.5 is not a whole number; expected 1 to 1024"},
      {"windows --guard-ms nan", 105, "--guard-ms: 'nan' is not a number; expected 0 to 1000000"},
      {"serve sim --port 70000", 105, "--port: 70000 is out of range; expected 0 to 65535"},
      {"simulate --preset big", 105, "--preset: 'big' is unknown; expected paper, quick or tiny"},
      {"doctor --config no.json", 105, "--config: there is no no.json; expected a file that can be read"},
      {"convert a.csv", 106, "OUT: is missing; expected 'tactile convert [OPTIONS] IN OUT'"},
      {"record --duration", 114, "--duration: has no value; expected --duration S, 0.001 to 1000000000"},
      {"simulate --seed 1 --seed 2", 114, "--seed: is given 2 times; expected it once"},
      {"doctor --json=perhaps", 104, "--json: takes no value; expected none"},
      {"serve a --port 1 --unix b", 108, "--port: cannot be used with --unix; expected one of the two"}};
  const test::TemporaryFolder folder;
  write_whole(folder / "a.aedat4", "");
  for (const auto& [arguments, exit_code, sentence] : cases) {
    const auto result = run_tactile(arguments, folder.path());
    EXPECT_EQ(result.exit_code, exit_code) << arguments;
    EXPECT_EQ(result.err, "tactile: " + sentence + "\n") << arguments;
    EXPECT_TRUE(result.out.empty()) << arguments;
  }
}

TEST(CommandLine, AFullStandardOutputIsAnErrorHoweverItIsWrittenTo) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_tactile("simulate --preset tiny --objects fan --quiet", folder.path()).exit_code, 0);
  // More than stdio keeps before it writes, and less.
  for (const char* arguments :
       {"--help", "--version", "train --help", "info --json data", "info data/fan/01", "label --json", "doctor --json"}) {
    const auto result = run_tactile(std::string(arguments) + " >/dev/full", folder.path());
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_TRUE(result.err.ends_with(
        "tactile: standard output: cannot be written (No space left on device); expected a place with room\n"))
        << arguments << "\n"
        << result.err;
  }
}

TEST(CommandLine, NoStandardStreamThatIsClosedOrFullAbortsIt) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_tactile("simulate --preset tiny --objects fan --quiet", folder.path()).exit_code, 0);
  for (const char* streams : {">&- 2>&-", "<&- >&- 2>&-", ">&- 2>/dev/full"}) {
    EXPECT_EQ(run_tactile(std::string("info x ") + streams, folder.path()).exit_code, 1) << streams;
    EXPECT_EQ(run_tactile(std::string("info data/fan/01 ") + streams, folder.path()).exit_code, 1) << streams;
    EXPECT_EQ(run_tactile(std::string("bogus ") + streams, folder.path()).exit_code, 106) << streams;
    EXPECT_EQ(run_tactile(std::string("label ") + streams, folder.path()).exit_code, 1) << streams;
  }
  EXPECT_EQ(run_tactile("info data/fan/01 2>&-", folder.path()).exit_code, 0);
  const auto closed = run_tactile("info data/fan/01 >&-", folder.path());
  EXPECT_EQ(closed.err,
            "tactile: standard output: cannot be written (Bad file descriptor); expected one that is open for writing\n");
  // The recording that was made with its standard streams closed has nothing in it that was meant for them.
  EXPECT_EQ(run_tactile("convert data/fan/01 whole.aedat4 <&- 2>&-", folder.path()).exit_code, 0);
  EXPECT_EQ(run_tactile("convert data/fan/01 closed.aedat4 <&- >&- 2>&-", folder.path()).exit_code, 1);
  EXPECT_EQ(run_tactile("info --check whole.aedat4", folder.path()).exit_code, 0);
  EXPECT_EQ(run_tactile("info --check closed.aedat4", folder.path()).exit_code, 0);
}

#if !defined(__SANITIZE_ADDRESS__)  // whose shadow takes more than any of these limits
TEST(CommandLine, EndsWhereThereIsLittleMemory) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_tactile("simulate --preset tiny --objects fan --quiet", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("label --no-pictures --quiet", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("windows --quiet", folder.path()).exit_code, 0);
  // Training loads libtorch, and a picture the rest of OpenCV.
  for (const char* arguments : {"--help", "info data/fan/01", "windows --help", "windows --verify --quiet", "label",
                                "doctor --quiet", "train --epochs 1 --force --quiet", "view data/fan/01 --out a.png --quiet"}) {
    for (const int limit_mb : {50, 300, 350, 450, 550, 600, 700, 1000}) {
      const auto result = test::run_shell(
          fmt::format("ulimit -v {}; exec timeout -s KILL 300 '{}' {}", limit_mb * 1000, test::tactile_binary, arguments),
          folder.path());
      if (result.exit_code == 0) continue;
      EXPECT_EQ(result.exit_code, 1) << arguments << " within " << limit_mb << " MB\n" << result.err;
      EXPECT_NE(result.err.find("memory"), std::string::npos) << arguments << " within " << limit_mb << " MB\n" << result.err;
    }
  }
}

/// Within these limits HDF5 lacks memory in its child process, in its first call, or in a thread.
TEST(CommandLine, ADatasetIsNotCalledDamagedOrWaitedForWhereThereIsLittleMemory) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_tactile("simulate --preset tiny --objects fan --quiet", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("label --no-pictures --quiet", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("windows --quiet", folder.path()).exit_code, 0);
  int failed = 0;
  for (int limit_mb = 270; limit_mb <= 330; limit_mb += 2) {
    const auto result = test::run_shell(fmt::format("ulimit -v {}; exec timeout -s KILL 300 '{}' windows --verify --quiet",
                                                    limit_mb * 1000, test::tactile_binary),
                                        folder.path());
    if (result.exit_code == 0) continue;
    ++failed;
    EXPECT_EQ(result.exit_code, 1) << limit_mb << " MB\n" << result.out << result.err;
    EXPECT_NE(result.err.find("memory"), std::string::npos) << limit_mb << " MB\n" << result.err;
  }
  EXPECT_GT(failed, 0);
}
#endif

/// A signal may come while libraries load, and while one program of ours becomes another.
TEST(CommandLine, NoSignalKillsItBareHoweverEarlyItComes) {
  const test::TemporaryFolder folder;
  std::mt19937 random(3);
  const std::array signals{SIGINT, SIGTERM, SIGHUP};
  for (const char* arguments : {"simulate --preset quick", "doctor", "record --from sim", "serve sim --port 0"}) {
    const bool is_the_end = std::string(arguments).starts_with("record") || std::string(arguments).starts_with("serve");
    for (int i = 0; i < 6; ++i) {
      test::RunningCommand command(arguments, folder.path());
      const int signal = signals.at(static_cast<std::size_t>(i) % signals.size());
      ASSERT_TRUE(test::comes_true([&] { return command.blocks_or_catches(signal) || command.has_ended(); }));
      std::this_thread::sleep_for(std::chrono::milliseconds(i == 0 ? 0 : random() % 300));
      command.signal(signal);
      const auto result = command.wait();
      if (is_the_end) {
        EXPECT_EQ(result.exit_code, 0) << arguments << "\n" << result.err;
      } else if (result.exit_code != 0 || result.out.empty()) {  // it may have been done by then
        EXPECT_EQ(result.exit_code, 128 + signal) << arguments;
        EXPECT_NE(result.err.find("tactile: interrupted"), std::string::npos) << arguments << "\n" << result.err;
      }
    }
  }
}

TEST(CommandLine, UnknownOptionAndUnknownCommandAreUsageErrors) {
  for (const char* arguments : {"doctor --bogus", "bogus", "--bogus"}) {
    const auto result = run_tactile(arguments);
    EXPECT_GE(result.exit_code, 100) << arguments;
    EXPECT_TRUE(result.out.empty());
    EXPECT_FALSE(result.err.empty());
  }
}

TEST(CommandLine, ValueOutOfRangeIsRefusedWithTheRange) {
  const auto result = run_tactile("doctor --threads 0");
  EXPECT_GE(result.exit_code, 100);
  EXPECT_TRUE(std::regex_search(result.err, std::regex("1.*1024"))) << result.err;
}

TEST(CommandLine, MistypedCommandNamesTheNearest) {
  const auto result = run_tactile("simulat");
  EXPECT_GE(result.exit_code, 100);
  EXPECT_NE(result.err.find("'simulate'"), std::string::npos) << result.err;
}

TEST(CommandLine, SeedOutOfRangeAndNanAreRefused) {
  for (const char* arguments :
       {"windows --seed -1", "windows --seed 99999999999999999999", "simulate --seed -1", "windows --guard-ms nan"}) {
    const auto result = run_tactile(arguments);
    EXPECT_GE(result.exit_code, 100) << arguments;
    EXPECT_LT(result.err.size(), 200U) << result.err;
  }
}

TEST(CommandLine, ErrorIsOneLineThatNamesWhatIsWrong) {
  const auto result = run_tactile("label /no/such/folder");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_NE(result.err.find("/no/such/folder"), std::string::npos);
}

TEST(Config, KeyThatNoOptionHasNamesTheNearestOne) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"thread": 1})");
  const auto result = run_tactile("doctor --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("'thread'"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("'threads'"), std::string::npos) << result.err;
}

TEST(Config, ValueIsCheckedAsOnTheCommandLine) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"threads": 0})");
  const auto result = run_tactile("doctor --config config.json", folder.path());
  EXPECT_GE(result.exit_code, 100);
  EXPECT_TRUE(std::regex_search(result.err, std::regex("1.*1024"))) << result.err;
}

TEST(Config, FillsInWhatTheCommandLineLeavesOpenAndNoMore) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"json": true, "threads": 0})");
  const auto result = run_tactile("doctor --threads 1 --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.substr(0, 1), "{");
}

TEST(Config, PositionalAndListTakeTheirValuesToo) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"data": ["/no/such/folder"]})");
  const auto result = run_tactile("label --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("/no/such/folder"), std::string::npos) << result.err;
}

TEST(Config, ThatIsNoJsonIsAnErrorThatNamesIt) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", "threads = 1");
  const auto result = run_tactile("doctor --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("config.json"), std::string::npos) << result.err;
}

TEST(Config, FilesThatComeAlongAreTakenByTheirCommands) {
  const test::TemporaryFolder folder;
  for (const char* name : {"heatmaps-as-printed", "windows-as-paper", "train-thorough"}) {
    const std::string file = std::string(test::data_folder) + "/../../configs/" + name + ".json";
    const std::string command(name, std::string(name).find('-'));
    const auto result = run_tactile(fmt::format("{} --config '{}'", command, file), folder.path());
    EXPECT_EQ(result.exit_code, 1) << "there is no data here";
    EXPECT_EQ(result.err.find(name), std::string::npos) << result.err;
  }
}

TEST(Config, GivesARequiredOptionToo) {
  const test::TemporaryFolder folder;
  write_whole(folder / "config.json", R"({"out": "sheet.png", "th": 10})");
  const auto result =
      run_tactile("view '" + std::string(test::data_folder) + "/aedat4/dv-lz4.aedat4' --config config.json", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "sheet.png"));
}

TEST(PrintConfig, IsThatOfAnyCommandAndTakenByItAgain) {
  const test::TemporaryFolder folder;
  for (const std::string& command : commands) {
    const std::string places = command == "convert" || command == "repair" ? " in.aedat4 out.csv"
                               : command == "view"                         ? " in.aedat4 --out out.png"
                               : command == "info" || command == "serve"   ? " in.aedat4"
                               : command == "characterise"                 ? " in.aedat4"
                                                                           : "";
    write_whole(folder / "in.aedat4", "");
    const auto first = run_tactile(command + places + " --print-config", folder.path());
    ASSERT_EQ(first.exit_code, 0) << command << ": " << first.err;
    ASSERT_TRUE(nlohmann::json::accept(first.out)) << command << ": " << first.out;
    write_whole(folder / "settings.json", first.out);
    // Places that are required stay on the command line.
    const auto again = run_tactile(command + places + " --config settings.json --print-config", folder.path());
    EXPECT_EQ(again.exit_code, 0) << command << ": " << again.err;
    EXPECT_EQ(again.out, first.out) << command;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "data")) << "nothing runs";
}

TEST(PrintConfig, HasNumbersTextsListsAndFlagsAsTheFileOfConfigDoes) {
  const test::TemporaryFolder folder;
  const auto printed = run_tactile(
      "train mine --th 20 --train-run 02 --held-out fan,sprayer --split unseen --strict --name 7 --force --quiet --print-config",
      folder.path());
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  const auto settings = nlohmann::json::parse(printed.out);
  EXPECT_EQ(settings.at("data"), "mine");
  EXPECT_EQ(settings.at("th"), 20);
  EXPECT_EQ(settings.at("train-run"), "02") << "no number: JSON would write 2";
  EXPECT_EQ(settings.at("held-out"), (std::vector<std::string>{"fan", "sprayer"}));
  EXPECT_EQ(settings.at("strict"), true);
  EXPECT_EQ(settings.at("epochs"), 10) << "a default";
  EXPECT_EQ(settings.at("lr"), 0.001);
  EXPECT_FALSE(settings.contains("validation")) << "its default depends on --early-stop";
  for (const char* option : {"force", "quiet", "config", "print-config", "resume", "json"})
    EXPECT_FALSE(settings.contains(option)) << option;
  const auto trade = nlohmann::json::parse(run_tactile("trade --th 20,40 --print-config", folder.path()).out);
  EXPECT_EQ(trade.at("th"), (std::vector<int>{20, 40}));
  EXPECT_EQ(trade.at("factor"), nlohmann::json::parse("[0.1, 0.2, 0.25]"));
  EXPECT_EQ(trade.at("choice-runs"), std::vector<std::string>{"02"});
  EXPECT_FALSE(trade.contains("trainings"));
  EXPECT_FALSE(trade.contains("models"));
}

TEST(Doctor, ReportsWhatMattersInJson) {
  const auto result = run_tactile("doctor --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* key : {"\"libtorch\"", "\"blas\"", "\"timer_step_ns\"", "\"disk_write_mb_per_s\"", "\"libcaer\""}) {
    EXPECT_NE(result.out.find(key), std::string::npos) << key;
  }
}

/// The file that measures the disk takes a while to write and to sync.
TEST(Doctor, WritesToAFileThatAKillCannotLeave) {
  const test::TemporaryFolder folder;
  const auto result = test::run_shell("'" + std::string(test::tactile_binary) + R"sh(' doctor --quiet >/dev/null & pid=$!
    while [ -e /proc/$pid/exe ]; do ls -l /proc/$pid/fd 2>/dev/null | grep -o "$PWD/.*(deleted)"; done; wait $pid)sh",
                                      folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out, "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace tactile::cli
