#include <fmt/core.h>
#include <gtest/gtest.h>

#include "hand_made_events.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_csv.hpp"

namespace tactile::recipes {
namespace {

using tactile::test::run_tactile;

constexpr events::SensorSize converted_sensor{320, 240};

/// The path of a CSV with these events, and the events that another CSV has.
std::string csv_of(const std::vector<events::Event>& events) {
  std::string text = "t,x,y,p\n";
  for (const events::Event& e : events) text += fmt::format("{},{},{},{}\n", us_of(e.t), e.x, e.y, e.on);
  return text;
}

std::vector<events::Event> events_in(const std::filesystem::path& csv) {
  events::EventCsvReader reader(csv, converted_sensor, {});
  std::vector<events::Event> all;
  for (auto piece = reader.next(); !piece.empty(); piece = reader.next()) all.insert(all.end(), piece.begin(), piece.end());
  return all;
}

TEST(ConvertStress, WritesWhatTheRecipesMakeOfTheEvents) {
  const tactile::test::TemporaryFolder folder;
  const auto events = test::random_events(5000, converted_sensor);
  write_whole(folder / "in.csv", csv_of(events));
  const std::string size = fmt::format("--size {}x{} ", converted_sensor.width, converted_sensor.height);
  const auto result =
      run_tactile("convert in.csv out.csv --json --seed 3 --stress noise:100,jitter:2000,late:20 " + size, folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto recipes = parse_recipes("noise:100,jitter:2000,late:20", 3);
  const auto expected = worsened(events, recipes, converted_sensor);
  EXPECT_EQ(events_in(folder / "out.csv"), expected);
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("stress").size(), 3U);
  EXPECT_EQ(json.at("stress").at(0), json_of(recipes[0]));
  EXPECT_EQ(json.at("streams").at(0).at("elements"), expected.size());

  // The same through AEDAT4 and its packets, and from a file of recipes.
  write_json(folder / "mine.json", {{"steps", {json_of(recipes[0]), json_of(recipes[1]), json_of(recipes[2])}}});
  for (const std::string& arguments : {"in.csv plain.aedat4 " + size, std::string("plain.aedat4 worse.aedat4 --stress mine.json"),
                                       std::string("worse.aedat4 back.csv")}) {
    const auto step = run_tactile("convert " + arguments, folder.path());
    ASSERT_EQ(step.exit_code, 0) << step.err;
  }
  EXPECT_EQ(events_in(folder / "back.csv"), expected);
}

TEST(ConvertStress, AppliesRecipesToTheCrop) {
  const tactile::test::TemporaryFolder folder;
  write_whole(folder / "in.csv", csv_of({test::event(0, 100, 50), test::event(10, 119, 50)}));
  const auto result = run_tactile("convert in.csv out.csv --size 320x240 --crop 100,50,20x10 --stress mirror-x", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(events_in(folder / "out.csv"), (std::vector{test::event(0, 19, 0), test::event(10, 0, 0)}));
}

TEST(ConvertStress, NamesTheNearestRecipeAndWritesNothing) {
  const tactile::test::TemporaryFolder folder;
  write_whole(folder / "in.csv", csv_of({test::event(0)}));
  for (const auto& [recipe, word] :
       {std::pair("lost:20", "'loss'"), std::pair("loss:120", "from 0 to 100"), std::pair("none.json", "none.json")}) {
    const auto refused = run_tactile(std::string("convert in.csv out.csv --stress ") + recipe, folder.path());
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find(word), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv"));
  }
}

}  // namespace
}  // namespace tactile::recipes
