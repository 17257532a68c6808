#include "tactile/capture/session_plan.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/capture/new_run.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::capture {
namespace {

class SessionPlanFile : public testing::Test {
 protected:
  SessionPlan read(const std::string& text) const {
    write_whole(folder / "plan.json", text);
    return read_session_plan(folder / "plan.json");
  }
  test::TemporaryFolder folder;
};

TEST_F(SessionPlanFile, ListsObjectsAndRuns) {
  const SessionPlan plan = read(R"({"session": "monday", "objects": [{"name": "fan", "runs": 10}, {"name": "usb-hub"}],
                                    "duration": 8, "start_on": "output_bit_register_64", "stop_on": "bits:3"})");
  EXPECT_EQ(plan.name, "monday");
  ASSERT_EQ(plan.objects.size(), 2U);
  EXPECT_EQ(plan.objects[0].name, "fan");
  EXPECT_EQ(plan.objects[0].runs, 10);
  EXPECT_EQ(plan.objects[1].runs, 1);
  EXPECT_EQ(plan.duration_s, 8.0);
  EXPECT_EQ(plan.start_on->field, "output_bit_register_64");
  EXPECT_EQ(plan.stop_on->bit, 3);
}

TEST_F(SessionPlanFile, NeedsOnlyObjects) {
  const SessionPlan plan = read(R"({"objects": [{"name": "fan"}]})");
  EXPECT_EQ(plan.name, "");
  EXPECT_FALSE(plan.duration_s);
  EXPECT_FALSE(plan.start_on);
}

TEST_F(SessionPlanFile, IsRefusedWithTheFileAndWhatIsWrong) {
  for (const char* text :
       {"", "[]", "{}", R"({"objects": []})", R"({"objects": [{"runs": 3}]})", R"({"objects": [{"name": "Fan"}]})",
        R"({"objects": [{"name": "fan", "runs": 0}]})", R"({"objects": [{"name": "fan", "runs": 1.5}]})",
        R"({"objects": [{"name": "fan", "runs": 100}]})", R"({"objects": [{"name": "fan"}, {"name": "fan"}]})",
        R"({"objects": [{"name": "fan", "count": 2}]})", R"({"objects": [{"name": "fan"}], "duration": 0})",
        R"({"objects": [{"name": "fan"}], "duration": "8"})", R"({"objects": [{"name": "fan"}], "start_on": "a b"})",
        R"({"objects": [{"name": "fan"}], "start-on": "a"})", R"({"session": 5, "objects": [{"name": "fan"}]})"}) {
    EXPECT_THROW(read(text), Error) << text;
  }
  try {
    read(R"({"objects": [{"name": "fan"}], "durration": 8})");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("the nearest is 'duration'"), std::string::npos) << e.what();
  }
}

TEST_F(SessionPlanFile, NamesTheKeyAndWhatIsExpected) {
  const auto complaint_of = [&](const std::string& member) {
    try {
      read(R"({"objects": [{"name": "fan"}], )" + member + "}");
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string file = (folder / "plan.json").string();
  EXPECT_EQ(complaint_of(R"("duration": "x")"), file + ": 'duration' is \"x\"; expected seconds above 0");
  EXPECT_EQ(complaint_of(R"("session": 5)"), file + ": 'session' is 5; expected a text");
  EXPECT_EQ(complaint_of(R"("stop_on": [])"), file + ": 'stop_on' is []; expected a text");
  EXPECT_TRUE(complaint_of(R"("start_on": "a b")").starts_with(file + ": 'start_on': 'a b' is not a bit of the robot; expected"));
}

TEST(CompleteRuns, CountsThoseThatAreMarkedSo) {
  const test::TemporaryFolder data;
  EXPECT_EQ(complete_runs(data / "none", {}, "fan"), 0);
  for (const bool complete : {true, false, true}) {
    const RunFolder run = make_run_folder(data.path(), "fan");
    write_whole(run.events(), "");
    write_run_info(
        run, {.object = "fan", .run = run.run, .session = "", .simulated = false, .complete = complete, .width = 1, .height = 1});
  }
  write_whole(make_run_folder(data.path(), "fan").events(), "");  // tells nothing
  EXPECT_EQ(complete_runs(data.path(), {}, "fan"), 2);
  EXPECT_EQ(complete_runs(data.path(), {}, "usb-hub"), 0);
}

TEST(CompleteRuns, LeavesOutThoseThatWereBrokenOff) {
  const test::TemporaryFolder data;
  for (const char* why :
       {"duration", "interrupted", "source gone: tcp://camera:7777: closed", "source ended", "stopped by Enter"}) {
    const RunFolder run = make_run_folder(data.path(), "fan");
    write_whole(run.events(), "");
    RunInfo info{.object = "fan", .run = run.run, .session = "", .simulated = false, .complete = true, .width = 1, .height = 1};
    info.extra["ended"] = why;
    write_run_info(run, info);
  }
  EXPECT_EQ(complete_runs(data.path(), {}, "fan"), 3);
  SessionPlan with_duration;
  with_duration.duration_s = 8;
  EXPECT_EQ(complete_runs(data.path(), with_duration, "fan"), 2) << "a source that ends has not lasted";
}

}  // namespace
}  // namespace tactile::capture
