#include "tactile/recipes/recipe.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::recipes {
namespace {

std::string error_of(std::string_view text) {
  try {
    parse_recipes(text);
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(ParseRecipe, ReadsNameSeverityAndParameters) {
  EXPECT_EQ(parse_recipe("noise:100", 4), (Recipe{.name = "noise", .severity = 100, .seed = 4}));
  EXPECT_EQ(parse_recipe("noise").severity, recipe_named("noise").middle());
  const Recipe vibration = parse_recipe("vibration:2:hz=120");
  EXPECT_EQ(vibration.severity, 2);
  EXPECT_EQ(parameter_of(vibration, "hz"), 120);
  EXPECT_EQ(parameter_of(vibration, "direction_deg"), 0);
  EXPECT_EQ(text_of(vibration), "vibration:2:hz=120");
  EXPECT_EQ(parse_recipe("vibration:2:hz=50"), parse_recipe("vibration:2")) << "the usual value";
}

TEST(ParseRecipe, RefusesWhatCannotBeAndNamesTheNearest) {
  EXPECT_NE(error_of("nose:100").find("'noise'"), std::string::npos) << error_of("nose:100");
  EXPECT_NE(error_of("vibration:2:hertz=3").find("hz"), std::string::npos);
  for (const std::string_view wrong : {"", "noise:", "noise:-1", "noise:nan", "noise:inf", "noise:1e6", "loss:101",
                                       "dead-rows:1.5", "mirror-x:2", "rounding:0.5", "loss:10:hz=3", "vibration:2:hz=9",
                                       "vibration:2:hz=20:hz=30", "vibration:2:3", "loss:10,,loss:20", "scale:-95", "noise:100:"})
    EXPECT_NE(error_of(wrong).find("expected"), std::string::npos) << "'" << wrong << "': " << error_of(wrong);
}

TEST(RecipeList, HasUsualSeveritiesThatAscendAndAreAllowed) {
  for (const RecipeInfo& info : recipe_list()) {
    ASSERT_FALSE(info.usual.empty()) << info.name;
    EXPECT_LE(info.usual.size(), 5U) << info.name;
    double before = harmless;
    for (const double severity : info.usual) {
      EXPECT_GT(severity, before) << info.name;
      EXPECT_NO_THROW(check({.name = std::string(info.name), .severity = severity})) << info.name;
      before = severity;
    }
    EXPECT_NO_THROW(check({.name = std::string(info.name), .severity = harmless})) << info.name;
    for (const RecipeParameter& parameter : info.parameters) {
      EXPECT_LE(parameter.least, parameter.usual) << info.name;
      EXPECT_LE(parameter.usual, parameter.most) << info.name;
    }
  }
}

TEST(ReadRecipes, ReadsStepsInTheirOrder) {
  const tactile::test::TemporaryFolder folder;
  write_json(folder / "mine.json", {{"name", "mine"},
                                    {"steps",
                                     {{{"recipe", "vibration"}, {"severity", 2}, {"hz", 120}},
                                      {{"recipe", "noise"}, {"seed", 9}, {"sensor", {{"spread_decades", 0}}}}}}});
  const std::vector<Recipe> recipes = parse_recipes((folder / "mine.json").string(), 5);
  ASSERT_EQ(recipes.size(), 2U);
  EXPECT_EQ(recipes[0], parse_recipe("vibration:2:hz=120", 5));
  EXPECT_EQ(recipes[1].seed, 9U);
  ASSERT_TRUE(recipes[1].sensor);
  EXPECT_EQ(recipes[1].sensor->spread_decades, 0);
  EXPECT_EQ(recipes[1].sensor->regularity, measured_noise().regularity);
}

TEST(ReadRecipes, ReadsBackWhatItWrites) {
  for (const RecipeInfo& info : recipe_list()) {
    const Recipe recipe = parse_recipe(info.name, std::numeric_limits<std::uint64_t>::max());
    const std::vector<Recipe> back = recipes_from({{"steps", {json_of(recipe)}}}, "here", {});
    ASSERT_EQ(back.size(), 1U);
    EXPECT_EQ(back.front(), recipe) << info.name;
    EXPECT_EQ(parse_recipe(text_of(recipe), recipe.seed), recipe) << info.name;
  }
}

TEST(ReadRecipes, NamesTheStepThatIsWrong) {
  const auto error = [](const nlohmann::json& json) -> std::string {
    try {
      recipes_from(json, "mine.json", {});
    } catch (const Error& e) {
      return e.what();
    }
    return {};
  };
  const nlohmann::json good = {{"recipe", "loss"}, {"severity", 10}};
  EXPECT_NE(error({{"steps", {good, {{"recipe", "los"}}}}}).find("mine.json, step 2: 'los'"), std::string::npos);
  EXPECT_NE(error({{"steps", {{{"recipe", "loss"}, {"severitie", 10}}}}}).find("'severity'"), std::string::npos);
  EXPECT_NE(error({{"steps", {{{"recipe", "loss"}, {"severity", "much"}}}}}).find("step 1"), std::string::npos);
  EXPECT_NE(error({{"steps", {{{"recipe", "loss"}, {"sensor", "s.json"}}}}}).find("sensor"), std::string::npos);
  EXPECT_NE(error({{"steps", nlohmann::json::array()}}).find("no steps"), std::string::npos);
  EXPECT_NE(error({{"step", {good}}}).find("'steps'"), std::string::npos);
}

TEST(ReadSensorNoise, ReadsWhatCharacteriseMeasured) {
  const auto measured = [](double value) { return nlohmann::json{{"value", value}, {"uncertainty", 0.1}}; };
  const tactile::test::TemporaryFolder folder;
  write_json(folder / "sensor.json",
             {{"background",
               {{"on_hz", measured(0.3)},
                {"off_hz", measured(0.1)},
                {"spread_decades", measured(0.2)},
                {"regularity", measured(3)},
                {"on_spread", measured(0.05)}}},
              {"unusual_pixels",
               {{"regularity", measured(-1)},
                {"pixels",
                 {{{"kind", "hot"}, {"x", 1}, {"y", 2}, {"rate_hz", measured(50)}, {"on_share", 0.75}},
                  {{"kind", "stuck"}, {"x", 3}, {"y", 2}, {"rate_hz", measured(5000)}, {"on_share", 0}}}}}}});
  const SensorNoise noise = read_sensor_noise(folder / "sensor.json");
  EXPECT_DOUBLE_EQ(noise.on_share, 0.75);
  EXPECT_EQ(noise.spread_decades, 0.2);
  EXPECT_EQ(noise.regularity, 3);
  EXPECT_EQ(noise.hot_hz, std::vector<double>(21, 50.0)) << "stuck pixels are left out";
  EXPECT_EQ(noise.hot_regularity, 0) << "intervals that scatter more than those of a Poisson process count as Poisson";
  EXPECT_THROW(read_sensor_noise(folder / "none.json"), Error);
}

}  // namespace
}  // namespace tactile::recipes
