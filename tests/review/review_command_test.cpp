#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "alignment/made_run.hpp"
#include "labels/press_and_slip.hpp"
#include "review/page_client.hpp"
#include "support/comes_true.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/labels/saved_labels.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;
using test::get;
using test::post;
using test::run_tactile;

class ReviewCommand : public testing::Test {
 protected:
  void SetUp() override {
    run = test::write_made_run(folder / "data", {.bursts = test::press_and_slip.bursts, .length_us = 2'500'000},
                               test::lift_after_press);
    ASSERT_EQ(labels::label_runs({run}).at(0).error, "");
  }

  /// The port in the printed address; waits for it.
  static std::uint16_t port_of(const test::RunningCommand& command) {
    std::string out;
    EXPECT_TRUE(test::comes_true([&] {
      out = command.out();
      return out.find('\n') != std::string::npos;
    })) << command.err();
    const std::size_t colon = out.find(':', out.find("//"));
    return colon == std::string::npos ? std::uint16_t{0} : static_cast<std::uint16_t>(std::atoi(out.c_str() + colon + 1));
  }

  test::TemporaryFolder folder;
  RunFolder run;
};

TEST_F(ReviewCommand, ServesThePageUntilCtrlC) {
  test::RunningCommand command("review --port 0 --who ada", folder.path());
  const std::uint16_t port = port_of(command);
  ASSERT_GT(port, 0);
  EXPECT_NE(get(port, "/").body.find("<!doctype html>"), std::string::npos);
  EXPECT_NE(get(port, "/web/dygraph.min.js").body.find("Dygraph"), std::string::npos);
  EXPECT_EQ(get(port, "/web/dygraph.min.css").status, 200);
  EXPECT_EQ(get(port, "/api/who").json().at("who"), "ada");
  EXPECT_EQ(get(port, "/api/runs").json().at("runs").at(0).at("name"), "fan/01");
  command.signal(SIGINT);
  const test::CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "http://127.0.0.1:" + std::to_string(port) + "/\n");
}

TEST_F(ReviewCommand, PrintsTheAddressAsJsonToo) {
  test::RunningCommand command("review data/fan/01 --port 0 --json", folder.path());
  ASSERT_TRUE(test::comes_true([&] { return command.out().ends_with("}\n"); })) << command.err();
  const json printed = json::parse(command.out());
  EXPECT_EQ(printed.at("url"), "http://127.0.0.1:" + std::to_string(printed.at("port").get<int>()) + "/");
  command.signal(SIGTERM);
  EXPECT_EQ(command.wait().exit_code, 0);
}

TEST_F(ReviewCommand, OpensTheAddressInTheBrowser) {
  // A browser that notes what it is to show, and ends the command.
  std::ofstream(folder / "xdg-open") << "#!/bin/sh\necho \"$1\" >shown\nkill -INT $PPID\n";
  std::filesystem::permissions(folder / "xdg-open", std::filesystem::perms::owner_all);
  const test::CommandResult result =
      test::run_shell("PATH=\"$PWD:$PATH\" '" + std::string(test::tactile_binary) + "' review --port 0 --open", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(test::text_in_file(folder / "shown"), result.out);
}

TEST_F(ReviewCommand, OnAnotherAddressTheAddressHasAToken) {
  test::RunningCommand command("review --port 0 --host 0.0.0.0", folder.path());
  const std::uint16_t port = port_of(command);
  const std::string out = command.out();
  const std::size_t at = out.find("?token=");
  ASSERT_NE(at, std::string::npos) << out;
  const std::string token = out.substr(at + 7, 32);
  EXPECT_EQ(get(port, "/api/runs").status, 401);
  EXPECT_EQ(get(port, "/api/runs", "X-Tactile-Token: " + token + "\r\n").status, 200);
}

TEST_F(ReviewCommand, ABusyPortAndAMissingFolderAreSentences) {
  const test::RunningCommand first("review --port 0", folder.path());
  const test::CommandResult busy = run_tactile("review --port " + std::to_string(port_of(first)), folder.path());
  EXPECT_EQ(busy.exit_code, 1);
  EXPECT_NE(busy.err.find("another program uses this port; expected a free one"), std::string::npos) << busy.err;
  const test::CommandResult none = run_tactile("review elsewhere --port 0", folder.path());
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.err.find("elsewhere"), std::string::npos) << none.err;
}

TEST_F(ReviewCommand, AnEditIsInTheFileAndThePictureFollows) {
  const std::filesystem::path picture = run.folder / "labels.png";
  ASSERT_FALSE(std::filesystem::exists(picture));
  test::RunningCommand command("review --port 0", folder.path());
  const std::uint16_t port = port_of(command);
  const std::string version = get(port, "/api/runs/fan/01/labels").json().at("version");
  const test::Answer answer =
      post(port, "/api/runs/fan/01/edits", json{{"version", version}, {"edit", {{"kind", "confirm-run"}}}}.dump());
  ASSERT_EQ(answer.status, 200) << answer.body;
  EXPECT_TRUE(labels::read_labels(run.labels()).intervals.at(0).confirmed);
  EXPECT_TRUE(test::comes_true([&] { return std::filesystem::exists(picture); }));
}

TEST_F(ReviewCommand, KilledInTheMidstOfEditsItLosesNoneThatWasAnswered) {
  for (std::int64_t round = 0; round < 5; ++round) {
    test::RunningCommand command("review --port 0 --no-pictures", folder.path());
    const std::uint16_t port = port_of(command);
    std::string version = get(port, "/api/runs/fan/01/labels").json().at("version");
    std::thread kills([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(40 + 30 * round));
      command.signal(SIGKILL);
    });
    std::int64_t last = -1;
    for (std::int64_t to = 812'000; to < 812'500; ++to) {
      const json edit = {{"kind", "move"}, {"id", "press-1"}, {"end", "start"}, {"to_us", to + 1000 * round}};
      const test::Answer answer = post(port, "/api/runs/fan/01/edits", json{{"version", version}, {"edit", edit}}.dump());
      // The kill may cut an answer: then its edit counts as not answered.
      const json body = json::parse(answer.body, nullptr, false);
      if (answer.status != 200 || body.is_discarded()) break;
      version = body.at("version");
      last = to + 1000 * round;
    }
    kills.join();
    command.wait();
    const labels::Labels after = labels::read_labels(run.labels());  // whole, whatever happened
    const std::int64_t start = us_of(after.intervals.at(0).start.at) - test::made_camera_begin_us;
    if (last >= 0) {
      EXPECT_TRUE(start == last || start == last + 1)
          << start << " instead of " << last;  // the next one may have been saved unanswered
    }
  }
}

}  // namespace
}  // namespace tactile::review
