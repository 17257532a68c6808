#include "tactile/review/split_desk.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "alignment/made_run.hpp"
#include "support/comes_true.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/review/page_message.hpp"
#include "tactile/review/review.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;

/// A recording of two runs, each a press and a slip, with 5 s of rest between them.
class SplittingOnThePage : public testing::Test {
 protected:
  void SetUp() override {
    run = test::write_made_run(
        folder / "takes",
        {.bursts = {{800'000, 1'000'000}, {1'600'000, 2'100'000}, {7'300'000, 7'500'000}, {8'200'000, 8'700'000}},
         .length_us = 10'000'000},
        test::made_lift(1'600'000, 500'000, 0.06, -123'456'789));
    std::filesystem::remove(run.robot());
    review = std::make_unique<Review>(
        ReviewOptions{
            .data = "takes", .models = folder / "models", .studies = folder.path(), .pieces = folder / "pieces", .who = "ada"},
        ReviewHelp{}, [this] { return look_for_runs(folder / "takes"); });
  }

  json asked(const PageRequest& request) const {
    try {
      return json::parse(review->answer(request).body);
    } catch (const Refusal& e) {
      return {{"status", e.status()}, {"error", e.what()}};
    }
  }
  json looked(const std::string& quiet_ms = "2000") const {
    return asked({.method = "GET", .path = "/api/splits/fan/01", .query = {{"quiet_ms", quiet_ms}}, .body = ""});
  }
  json settled(const std::string& quiet_ms = "2000") const {
    json desk;
    EXPECT_TRUE(test::comes_true([&] {
      desk = looked(quiet_ms);
      return desk.at("state") != "proposing" && desk.at("state") != "cutting";
    })) << desk;
    return desk;
  }
  json sent(const json& body) const {
    return asked({.method = "POST", .path = "/api/splits/fan/01", .query = {}, .body = body.dump()});
  }

  test::TemporaryFolder folder;
  RunFolder run;
  std::unique_ptr<Review> review;
};

TEST_F(SplittingOnThePage, ProposesCutsAndWritesThoseThatAPersonChose) {
  const json desk = settled();
  ASSERT_EQ(desk.at("state"), "proposed") << desk;
  EXPECT_EQ(desk.at("object"), "fan");
  ASSERT_EQ(desk.at("cuts_us").size(), 1U) << desk;
  EXPECT_GT(desk.at("cuts_us").at(0), 2'100'000);
  EXPECT_LT(desk.at("cuts_us").at(0), 7'300'000);
  EXPECT_EQ(desk.at("touches").size(), 4U);
  EXPECT_FALSE(std::filesystem::exists(folder / "pieces")) << "a proposal writes nothing";
  sent({{"cuts_us", {3'000'000, 4'500'000}}, {"objects", {"mug"}}});
  const json cut = settled();
  ASSERT_EQ(cut.at("state"), "cut") << cut;
  EXPECT_EQ(cut.at("cuts_us"), json({3'000'000, 4'500'000}));
  ASSERT_EQ(cut.at("result").at("runs").size(), 3U);
  EXPECT_EQ(cut.at("result").at("runs").at(2).at("run"), "mug/03");
  EXPECT_TRUE(cut.at("result").at("warning").is_null()) << cut;
  std::uint64_t events = 0;
  for (const RunFolder& piece : find_runs(folder / "pieces")) {
    const events::RecordingReader recording(piece.events());
    for (const events::PacketRecord& packet : recording.packets()) events += static_cast<std::uint64_t>(packet.elements);
  }
  std::uint64_t expected = 0;
  const events::RecordingReader whole(run.events());
  for (const events::PacketRecord& packet : whole.packets()) expected += static_cast<std::uint64_t>(packet.elements);
  EXPECT_EQ(events, expected);
}

TEST_F(SplittingOnThePage, AnotherQuietTimeIsAnotherProposal) {
  EXPECT_EQ(settled().at("cuts_us").size(), 1U);
  EXPECT_EQ(settled("30000").at("cuts_us").size(), 0U);
}

TEST_F(SplittingOnThePage, RefusesWhatIsNoCut) {
  EXPECT_EQ(sent({{"cuts_us", {3'000'000}}, {"objects", {"mug"}}}).at("status"), 409) << "nobody has looked at it";
  settled();
  for (const json& body :
       {json{{"cuts_us", {3'000'000, 2'000'000}}, {"objects", {"mug"}}}, json{{"cuts_us", {0}}, {"objects", {"mug"}}},
        json{{"cuts_us", {9e15}}, {"objects", {"mug"}}}, json{{"cuts_us", {99'000'000}}, {"objects", {"mug"}}},
        json{{"cuts_us", "all"}, {"objects", {"mug"}}}, json{{"objects", {"mug"}}}, json{{"cuts_us", {1}}}})
    EXPECT_EQ(sent(body).at("status"), 400) << body;
  sent({{"cuts_us", {3'000'000}}, {"objects", {"../mug"}}});
  const json failed = settled();
  EXPECT_EQ(failed.at("state"), "failed");
  EXPECT_NE(failed.at("error").get<std::string>().find("'../mug'"), std::string::npos) << failed;
  EXPECT_FALSE(std::filesystem::exists(folder / "pieces"));
  EXPECT_EQ(asked({.method = "GET", .path = "/api/splits/fan/02", .query = {}, .body = ""}).at("status"), 404);
}

}  // namespace
}  // namespace tactile::review
