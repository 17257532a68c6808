#include <gtest/gtest.h>

#include <atomic>
#include <cstring>

#include "review/reviewing.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/review/review.hpp"
#include "windows/made_runs.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;
using test::request;
using test::ReviewingARun;

TEST_F(ReviewingARun, AnEditIsSavedAndAnsweredWithTheNewLabels) {
  review_runs();
  const PageResponse answer =
      edit({{"kind", "move"}, {"id", "press-1"}, {"end", "start"}, {"to_us", 812'345}, {"within_us", 250}});
  ASSERT_EQ(answer.status, 200) << answer.body;
  const json view = json::parse(answer.body);
  const json press = view.at("intervals").at(0);
  EXPECT_EQ(press.at("start_us"), 812'345);
  EXPECT_EQ(press.at("start_low_us"), 812'095);
  EXPECT_EQ(press.at("start_high_us"), 812'595);
  EXPECT_EQ(press.at("source"), "person");
  EXPECT_EQ(press.at("confirmed"), true);
  EXPECT_EQ(view.at("history").at(0).at("who"), "ada");
  EXPECT_EQ(view.at("can_undo"), true);
  EXPECT_EQ(view.at("version"), labels::read_versioned_labels(run).version);
  EXPECT_EQ(labels::read_labels(run.labels()).intervals.at(0).start.at, after(events.front().t, 812'345us));
}

TEST_F(ReviewingARun, EditsAreUndoneAndRedone) {
  review_runs();
  const json before = json_of(request("/api/runs/fan/01/labels"));
  ASSERT_EQ(edit({{"kind", "reject"}, {"id", "press-1"}}).status, 200);
  ASSERT_EQ(edit({{"kind", "class"}, {"id", "slip-1"}, {"touch", "press"}}).status, 200);
  const json edited = json_of(request("/api/runs/fan/01/labels"));
  const json undone = json::parse(post("/api/runs/fan/01/undo", {{"version", version()}, {"count", 2}}).body);
  EXPECT_EQ(undone.at("intervals"), before.at("intervals"));
  EXPECT_EQ(undone.at("rejected"), before.at("rejected"));
  EXPECT_EQ(undone.at("can_redo"), true);
  EXPECT_EQ(undone.at("can_undo"), false);
  EXPECT_EQ(undone.at("history").at(0).at("undone"), true);
  const json redone = json::parse(post("/api/runs/fan/01/redo", {{"version", version()}, {"count", 2}}).body);
  EXPECT_EQ(redone.at("intervals"), edited.at("intervals"));
  EXPECT_EQ(post("/api/runs/fan/01/redo", {{"version", version()}}).status, 400);
}

TEST_F(ReviewingARun, AnEditOfOlderLabelsIsAConflictWithTheCurrentOnes) {
  review_runs();
  const std::string seen = version();
  const labels::EditNote eve{.who = "eve", .why = ""};
  ASSERT_TRUE(std::holds_alternative<labels::VersionedLabels>(
      labels::save_edit(run, std::nullopt, labels::RejectInterval{"press-1"}, eve)));
  const std::string file = read_text(run.labels());
  for (const auto& [path, body] :
       {std::pair<std::string, json>("edits", {{"version", seen}, {"edit", {{"kind", "confirm-run"}}}}),
        {"undo", {{"version", seen}}},
        {"redo", {{"version", seen}}}}) {
    const PageResponse answer = post("/api/runs/fan/01/" + path, body);
    EXPECT_EQ(answer.status, 409) << path;
    const json conflict = json::parse(answer.body);
    EXPECT_EQ(conflict.at("current").at("intervals").size(), 1U);
    EXPECT_EQ(conflict.at("current").at("version"), version());
    EXPECT_EQ(conflict.at("current").at("history").at(0).at("who"), "eve");
  }
  EXPECT_EQ(read_text(run.labels()), file);
}

TEST_F(ReviewingARun, AnEditThatCannotBeMadeIsRefusedAndSavesNothing) {
  review_runs();
  const std::string file = read_text(run.labels());
  EXPECT_EQ(edit({{"kind", "reject"}, {"id", "press-9"}}).status, 400);
  EXPECT_EQ(edit({{"kind", "move"}, {"id", "press-1"}, {"end", "start"}, {"to_us", 99'000'000}}).status, 400);
  EXPECT_EQ(edit({{"kind", "lift"}, {"flag", 0}}).status, 400);
  EXPECT_EQ(post("/api/runs/fan/01/edits", {{"edit", {{"kind", "confirm-run"}}}}).status, 400);  // of no version
  EXPECT_EQ(ask({.method = "POST", .path = "/api/runs/fan/01/edits", .query = {}, .body = std::string(40'000, '[')}).status, 400);
  EXPECT_EQ(ask(request("/api/runs/fan/01/edits")).status, 405);
  EXPECT_EQ(post("/api/runs/fan/01/labels", json::object()).status, 405);
  EXPECT_EQ(read_text(run.labels()), file);
}

TEST_F(ReviewingARun, ALiftedFlagHasItsReason) {
  labels::Labels flagged = labels::read_labels(run.labels());
  flagged.flags.push_back({.interval_index = 0, .reason = "<img src=x onerror=alert(1)>", .confirmed = false, .key = "k"});
  labels::write_labels(run.labels(), flagged);
  review_runs();
  const json before = json_of(request("/api/runs/fan/01/labels"));
  const std::size_t index = before.at("flags").size() - 1;
  EXPECT_EQ(before.at("flags").at(index).at("what"),
            "<img src=x onerror=alert(1)>");  // text; the page must not make markup of it
  EXPECT_EQ(before.at("flags").at(index).at("interval_id"), "press-1");
  const json after = json::parse(edit({{"kind", "lift"}, {"flag", index}}, "seen in the film").body);
  EXPECT_EQ(after.at("flags").at(index).at("confirmed"), true);
  EXPECT_EQ(after.at("flags").at(index).at("lifted_why"), "seen in the film");
}

TEST_F(ReviewingARun, ThePictureOfEditedLabelsIsDrawnOnceItEnds) {
  std::atomic<int> drawn{0};
  std::string of;
  review_runs({.classify = {}, .default_model = {}, .draw_labels = [&](const RunFolder& one, const labels::Labels& labels) {
                 of = one.name() + " " + std::to_string(labels.history.entries.size());
                 ++drawn;
               }});
  ASSERT_EQ(edit({{"kind", "confirm-run"}}).status, 200);
  review.reset();
  EXPECT_EQ(drawn, 1);
  EXPECT_EQ(of, "fan/01 1");
}

}  // namespace
}  // namespace tactile::review
