#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "hand_made_events.hpp"
#include "tactile/core/error.hpp"

namespace tactile::recipes {
namespace {

using events::Event;
using test::event;

constexpr events::SensorSize sensor{40, 30};

/// A severity that suits this small sensor and the events of the tests.
Recipe usual_recipe(const RecipeInfo& info) {
  const double severity = info.name == "hot-pixels"       ? 20
                          : info.name == "readout-limit"  ? 20'000  // their rate is 0.1 Mev/s
                          : info.name.starts_with("dead") ? 5
                                                          : info.middle();
  return {.name = std::string(info.name), .severity = severity};
}

std::vector<Event> in_pieces(const std::vector<Event>& events, const Recipe& recipe, std::size_t piece) {
  RecipeStream stream({&recipe, 1}, sensor);
  std::vector<Event> out;
  for (std::size_t begin = 0; begin < events.size(); begin += piece)
    stream.push(std::span(events).subspan(begin, std::min(piece, events.size() - begin)), out);
  stream.finish(out);
  return out;
}

TEST(EveryRecipe, GivesTheSameEventsHoweverTheyAreDivided) {
  const auto events = test::random_events(4000, sensor);
  for (const RecipeInfo& info : recipe_list()) {
    const Recipe recipe = usual_recipe(info);
    const auto whole = worsened(events, {&recipe, 1}, sensor);
    for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{1000}})
      EXPECT_EQ(in_pieces(events, recipe, piece), whole) << info.name << " in pieces of " << piece;
  }
}

TEST(EveryRecipe, ChangesNothingAtSeverity0) {
  const auto events = test::random_events(500, sensor);
  for (const RecipeInfo& info : recipe_list()) {
    const Recipe recipe{.name = std::string(info.name), .severity = harmless};
    EXPECT_EQ(worsened(events, {&recipe, 1}, sensor), events) << info.name;
  }
}

TEST(EveryRecipe, ChangesSomethingAtAUsualSeverity) {
  const auto events = test::random_events(20'000, sensor);
  for (const RecipeInfo& info : recipe_list())
    EXPECT_NE(worsened(events, std::vector{usual_recipe(info)}, sensor), events) << info.name;
}

TEST(EveryRecipe, AscendsInTimeInsideTheSensorAlsoAtItsStrongest) {
  const auto events = test::random_events(3000, sensor);
  for (const RecipeInfo& info : recipe_list()) {
    for (double severity : {info.least, info.usual.front(), info.usual.back(), info.most}) {
      if (info.name == "noise") severity = std::min(severity, 600.0);
      if (info.name == "hot-pixels") severity = std::min(severity, 1200.0);
      if (info.name == "dead-rows" || info.name == "dead-columns") severity = std::min(severity, 30.0);
      const Recipe recipe{.name = std::string(info.name), .severity = severity};
      const auto out = worsened(events, {&recipe, 1}, sensor);
      EXPECT_TRUE(std::is_sorted(out.begin(), out.end(), [](const Event& a, const Event& b) { return a.t < b.t; })) << info.name;
      for (const Event& e : out)
        ASSERT_TRUE(e.x >= 0 && e.y >= 0 && e.x < sensor.width && e.y < sensor.height && e.on <= 1) << info.name;
    }
  }
}

TEST(EveryRecipe, TakesNoEventsOneEventAndTimesNearTheEndsOfInt64) {
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min(), last = std::numeric_limits<std::int64_t>::max();
  const std::vector<Event> far{event(first, 3, 4), event(first + 5, 3, 4), event(-1, 3, 4),
                               event(0, 3, 4),     event(last - 1, 3, 4),  event(last, 3, 4)};
  for (const RecipeInfo& info : recipe_list()) {
    const Recipe recipe = usual_recipe(info);
    EXPECT_TRUE(worsened({}, {&recipe, 1}, sensor).empty()) << info.name;
    EXPECT_LE(worsened(std::vector{event(17, 3, 4)}, {&recipe, 1}, sensor).size(), 3000U) << info.name;
    const auto out = worsened(far, {&recipe, 1}, sensor);
    EXPECT_LE(out.size(), 3000U) << info.name << " adds nothing in pauses";
    EXPECT_TRUE(std::is_sorted(out.begin(), out.end(), [](const Event& a, const Event& b) { return a.t < b.t; })) << info.name;
  }
}

TEST(EveryRecipe, DependsOnItsSeedWhereItDraws) {
  const auto events = test::random_events(20'000, sensor);
  for (const std::string_view name :
       {"noise", "hot-pixels", "dead-rows", "dead-columns", "loss", "burst-loss", "packet-loss", "flicker-100", "flicker-120",
        "jitter", "late", "scale", "polarity", "threshold", "vibration"}) {
    Recipe recipe = usual_recipe(recipe_named(name));
    if (name == "polarity" || name == "packet-loss") recipe.severity = 50;
    const auto one = worsened(events, {&recipe, 1}, sensor);
    recipe.seed = 2;
    EXPECT_NE(worsened(events, {&recipe, 1}, sensor), one) << name;
  }
}

TEST(RecipeStream, AppliesRecipesInTheirOrderAndARecipeTwiceWithOtherDraws) {
  const auto events = test::random_events(20'000, sensor);
  const std::vector<Recipe> twice{parse_recipe("loss:50"), parse_recipe("loss:50")};
  EXPECT_NEAR(static_cast<double>(worsened(events, twice, sensor).size()), 5000.0, 400.0);
  const std::vector<Recipe> moved{parse_recipe("shift:5"), parse_recipe("mirror-x:1")}, back{moved[1], moved[0]};
  const std::vector<Event> one{event(0, 10, 0)};
  EXPECT_EQ(worsened(one, moved, sensor).front().x, 24);
  EXPECT_EQ(worsened(one, back, sensor).front().x, 34);
}

TEST(RecipeStream, RefusesEventsThatGoBackInTimeOrLieOutside) {
  const std::vector<Recipe> none;
  for (const std::vector<Event>& wrong :
       {std::vector{event(10), event(9)}, std::vector{event(0, 40, 0)}, std::vector{event(0, 0, -1)}})
    EXPECT_THROW(worsened(wrong, none, sensor), Error);
  EXPECT_THROW(RecipeStream(none, {0, 10}), Error);
  for (const std::string_view wrong : {"dead-rows:31", "dead-columns:41", "hot-pixels:1201", "noise:601"})
    EXPECT_THROW(RecipeStream(std::vector{parse_recipe(wrong)}, sensor), Error) << wrong;
}

}  // namespace
}  // namespace tactile::recipes
