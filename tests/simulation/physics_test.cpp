#include "tactile/simulation/physics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>
#include <string_view>

#include "support/error_of.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/fields.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::simulation {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 5> source_words{"published", "measured here", "derived", "assumed", "no number"};

const fs::path configs = fs::path(test::data_folder).parent_path().parent_path() / "configs";

nlohmann::json without_objects(const SimulationPhysics& physics) {
  nlohmann::json json = json_of(physics);
  json.erase("objects");
  return json;
}

std::string refusal(const std::string& text) {
  return test::error_of([&] { physics_from(nlohmann::json::parse(text), "FILE"); });
}

TEST(DefaultPhysics, AreTheFilesOfConfigsAndNoMemberIsMissingThere) {
  nlohmann::json expected = read_json(configs / "simulation.json"), cameras = read_json(configs / "cameras.json");
  expected["camera"] = cameras.at("measured");
  expected["camera"]["preset"] = "measured";
  EXPECT_EQ(without_objects(default_physics()), expected);
  for (const auto& [name, camera] : cameras.items()) {
    expected["camera"] = camera;
    expected["camera"]["preset"] = name;
    EXPECT_EQ(without_objects(with_camera(name)), expected);
  }
  EXPECT_EQ(json_of(default_physics()).at("objects"), read_json(configs / "objects.json"));
}

TEST(DefaultPhysics, AreThoseOfTheStructs) {
  const SimulationPhysics& physics = default_physics();
  EXPECT_EQ(json_of_fields(with_camera("quiet").camera), json_of_fields(EventCameraOptions{}));
  EXPECT_EQ(json_of_fields(physics.sessions), json_of_fields(SessionPhysics{}));
  EXPECT_EQ(json_of_fields(physics.variation), json_of_fields(RunVariation{}));
  EXPECT_EQ(json_of_fields(physics.after_effects), json_of_fields(AfterEffects{}));
  EXPECT_EQ(json_of_fields(physics.special_runs), json_of_fields(SpecialRuns{}));
  EXPECT_EQ(json_of_fields(physics.robot), json_of_fields(RobotPhysics{}));
  EXPECT_EQ(json_of_fields(physics.video), json_of_fields(VideoPhysics{}));
  EXPECT_EQ(json_of_fields(physics.imu), json_of_fields(ImuPhysics{}));
  EXPECT_EQ(json_of_fields(physics.clocks), json_of_fields(ClockPhysics{}));
  EXPECT_EQ(json_of_fields(physics.preset("quick").timings), json_of_fields(RunTimings{}));
}

/// The members of a file of configs/, at any depth but without the names of presets.
void collect_keys(const nlohmann::json& json, std::set<std::string>& keys) {
  for (const auto& [key, value] : json.items()) {
    if (value.is_object())
      collect_keys(value, keys);
    else
      keys.insert(key);
  }
}

TEST(Configs, HaveASourceForEachNumber) {
  std::set<std::string> keys, explained;
  for (const char* file : {"simulation.json", "cameras.json"}) collect_keys(read_json(configs / file), keys);
  std::ifstream page(configs / "README.md");
  for (std::string line; std::getline(page, line);) {
    const std::size_t bar = line.find(" | ", 2);
    if (line.substr(0, 3) != "| `" || bar == std::string::npos) continue;
    const std::string source = line.substr(bar);
    const bool is_source = std::any_of(source_words.begin(), source_words.end(),
                                       [&](std::string_view word) { return source.find(word) != std::string::npos; });
    for (std::size_t from = line.find('`'); is_source && from < bar; from = line.find('`', from)) {
      const std::size_t to = line.find('`', from + 1);
      explained.insert(line.substr(from + 1, to - from - 1));
      from = to + 1;
    }
  }
  for (const std::string& key : keys) EXPECT_TRUE(explained.contains(key)) << key << ": configs/README.md has no source for it";
  for (const char* file :
       {"objects.json", "scenes/*.json", "train-thorough.json", "windows-as-paper.json", "heatmaps-as-printed.json"})
    EXPECT_TRUE(explained.contains(file)) << file;
}

TEST(DefaultPhysics, HaveThePapersPresets) {
  const SimulationPhysics& physics = default_physics();
  EXPECT_EQ(physics.preset("paper").runs, 10);
  EXPECT_TRUE(physics.preset("paper").special_runs);
  EXPECT_EQ(physics.preset("quick").runs, 3);
  EXPECT_FALSE(physics.preset("quick").special_runs);
  EXPECT_EQ(physics.preset("tiny").runs, 2);
  EXPECT_FALSE(physics.preset("tiny").special_runs);
  EXPECT_LT(longest_run_s(physics.plan_options(physics.preset("tiny"), 1)), 3.5);
  EXPECT_NE(test::error_of([&] { physics.preset("papr"); }).find("the nearest is 'paper'"), std::string::npos);
}

TEST(DefaultPhysics, KnowThePapersTenObjectsAndWhyTheyAreSo) {
  const std::vector<std::string> names{"3d-printed-object", "uhu-glue-stick", "sprayer",           "water-bottle", "fan",
                                       "white-box",         "textured-box",   "plastic-container", "small-box",    "usb-hub"};
  const SimulationPhysics& physics = default_physics();
  ASSERT_EQ(physics.objects.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(physics.objects[i].name, names[i]);
    EXPECT_EQ(physics.place_of(names[i]), i);
    EXPECT_GT(physics.objects[i].why.size(), 40U) << names[i];
    EXPECT_TRUE(physics.objects[i].why.ends_with('.')) << names[i];
  }
  const std::string refused = test::error_of([&] { physics.object("sprayr"); });
  EXPECT_NE(refused.find("the nearest is 'sprayer'"), std::string::npos) << refused;
  EXPECT_NE(refused.find("usb-hub"), std::string::npos) << "all are listed: " << refused;
}

/// Every number of an object that affects the skin, in units of its standard deviation over the objects.
std::vector<std::vector<double>> features() {
  std::vector<std::vector<double>> all;
  for (const ObjectModel& object : default_physics().objects) {
    std::vector<double>& numbers = all.emplace_back();
    const nlohmann::json json = json_of_fields(object);
    for (const auto& [key, value] : json.items()) {
      if (value.is_number() && key != "weight_g" && key != "reflectivity") numbers.push_back(value.get<double>());
    }
  }
  const auto count = static_cast<double>(all.size());
  for (std::size_t k = 0; k < all[0].size(); ++k) {
    double mean = 0, square = 0;
    for (const auto& numbers : all) mean += numbers[k] / count;
    for (const auto& numbers : all) square += (numbers[k] - mean) * (numbers[k] - mean) / count;
    for (auto& numbers : all) numbers[k] = (numbers[k] - mean) / std::sqrt(square);
  }
  return all;
}

TEST(DefaultPhysics, MakeThePlasticContainerTheMostIrregularAndTheFarthestFromTheOthers) {
  const auto& objects = default_physics().objects;
  const std::size_t container = default_physics().place_of("plastic-container");
  const std::vector<std::vector<double>> all = features();
  const auto distance_to_nearest = [&](std::size_t i) {
    double nearest = 1e9;
    for (std::size_t j = 0; j < all.size(); ++j) {
      double square = 0;
      for (std::size_t k = 0; k < all[i].size(); ++k) square += (all[i][k] - all[j][k]) * (all[i][k] - all[j][k]);
      if (j != i) nearest = std::min(nearest, std::sqrt(square));
    }
    return nearest;
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == container) continue;
    EXPECT_LT(objects[i].irregularity_mm, objects[container].irregularity_mm) << objects[i].name;
    EXPECT_LT(distance_to_nearest(i), distance_to_nearest(container)) << objects[i].name;
  }
}

TEST(DefaultPhysics, DrawSpecialRunsInTheStatedSharesFromTheFourthRunOfThePaperOn) {
  const SimulationPhysics& physics = default_physics();
  const auto count = [&](const std::string& preset, int run_number) {
    std::array<int, 4> kinds{};  // plain, two presses, without slip, without press
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      for (const ObjectModel& object : physics.objects) {
        Random random(seed_for(seed, {object.name}));
        const RunPlan plan = draw_run_plan(object, physics.plan_options(physics.preset(preset), run_number), random);
        const bool two = plan.presses.size() == 2, pressed_before = plan.presses.at(0).contact_s < 0;
        EXPECT_EQ(two + !plan.lift + pressed_before <= 1, true) << "one thing at a time";
        ++kinds[two ? 1 : !plan.lift ? 2 : pressed_before ? 3 : 0];
      }
    }
    return kinds;
  };
  const std::array<int, 4> all_plain{2000, 0, 0, 0};
  EXPECT_EQ(count("paper", 3), all_plain);
  EXPECT_EQ(count("quick", 9), all_plain);
  const std::array<int, 4> drawn = count("paper", 4);
  const std::array shares{physics.special_runs.two_presses, physics.special_runs.without_slip,
                          physics.special_runs.without_press};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(shares[i], 0.02);
    EXPECT_NEAR(drawn[i + 1], 2000 * shares[i], 4 * std::sqrt(2000 * shares[i] * (1 - shares[i])));
  }
}

TEST(Physics, ComeBackAsTheyWereWritten) {
  SimulationPhysics physics = default_physics();
  physics.camera.size = {320, 240};
  physics.camera.threshold = 0.3;
  physics.variation.depth_mm = {0.5, 0.6};
  physics.presets.at("tiny").runs = 5;
  physics.objects[2].depth_mm = 0.7;
  physics.objects.push_back({.name = "cup", .why = "Round."});
  const nlohmann::json json = json_of(physics);
  EXPECT_NE(json, json_of(default_physics()));
  EXPECT_EQ(json_of(physics_from(json, "FILE")), json);
}

TEST(Physics, ReplaceAndAddObjectsMemberByMember) {
  const test::TemporaryFolder folder;
  write_whole(folder / "soft.json",
              R"({"why": "Softer.", "camera": {"threshold": 0.5}, "presets": {"quick": {"runs": 7}},
                  "objects": [{"name": "cup", "radius_mm": 40}, {"name": "fan", "compliance": 0.4}]})");
  const SimulationPhysics physics = read_physics(folder / "soft.json");
  EXPECT_EQ(physics.source, "soft.json");
  EXPECT_EQ(default_physics().source, "default");
  EXPECT_EQ(physics.camera.threshold, 0.5);
  EXPECT_EQ(physics.camera.readout_us, default_physics().camera.readout_us);
  EXPECT_EQ(physics.preset("quick").runs, 7);
  ASSERT_EQ(physics.objects.size(), 11U);
  EXPECT_EQ(physics.object("fan").compliance, 0.4);
  EXPECT_EQ(physics.object("fan").ring_hz, default_physics().object("fan").ring_hz);
  EXPECT_EQ(physics.place_of("cup"), 10U);
  EXPECT_EQ(physics.object("cup").radius_mm, 40);
  EXPECT_EQ(physics.object("cup").depth_mm, ObjectModel{}.depth_mm);
}

TEST(Physics, ChangeTheCameraThatTheyName) {
  const SimulationPhysics physics = physics_from({{"camera", {{"preset", "quiet"}, {"threshold", 0.4}}}}, "FILE");
  EXPECT_EQ(physics.camera.threshold, 0.4);
  EXPECT_EQ(physics.camera.readout_us, 200);
  EXPECT_EQ(physics.camera.hot_pixels, 24);
  const test::TemporaryFolder folder;
  write_whole(folder / "camera.json", R"({"camera": {"preset": "quiet", "threshold": 0.4}})");
  const SimulationPhysics noisy = read_physics(folder / "camera.json", "noisy");
  EXPECT_EQ(noisy.camera.threshold, 0.4) << "the command line names the camera, the file changes it";
  EXPECT_EQ(noisy.camera.hot_pixels, with_camera("noisy").camera.hot_pixels);
  EXPECT_EQ(refusal(R"({"camera": {"preset": "quite"}})"),
            "FILE: 'quite' is no preset of the camera; the nearest is 'quiet', of "
            "measured, noisy, quiet");
  EXPECT_EQ(refusal(R"({"camera": {"preset": 3}})").substr(0, 5), "FILE:");
  EXPECT_EQ(refusal(R"({"camera": {"hot_hz": []}})"),
            "FILE: camera.hot_hz is []; expected 1 to 1000 ascending numbers from 0.001 to 1000000");
}

TEST(Physics, RefuseWhatTheyCannotBeByItsName) {
  EXPECT_EQ(refusal(R"({"camera": {"threshold": -1}})"), "FILE: camera.threshold is -1; expected 1e-06 to 1000");
  EXPECT_EQ(refusal(R"({"camera": {"treshold": 1}})"), "FILE: there is no 'camera.treshold'; the nearest is 'camera.threshold'");
  EXPECT_EQ(refusal(R"({"camra": {}})"), "FILE: there is no 'camra'; the nearest is 'camera'");
  EXPECT_EQ(refusal(R"({"object": []})"), "FILE: there is no 'object'; the nearest is 'objects'");
  EXPECT_EQ(refusal(R"({"presets": {"quik": {}}})"), "FILE: there is no 'presets.quik'; the nearest is 'presets.quick'");
  EXPECT_EQ(refusal(R"({"variation": {"depth_mm": [2, 1]}})"),
            "FILE: variation.depth_mm is [2,1]; expected [low, high], ascending, from 0.05 to 2");
  EXPECT_EQ(refusal(R"({"objects": [{"name": "fan", "compliance": 1}]})"),
            "FILE: objects.fan.compliance is 1; expected 0 to 0.95");
  EXPECT_EQ(refusal(R"({"objects": [{"name": "fan", "weight": 1}]})"),
            "FILE: there is no 'objects.fan.weight'; the nearest is 'objects.fan.weight_g'");
  EXPECT_EQ(refusal(R"({"special_runs": {"two_presses": 0.5, "without_slip": 0.75, "without_press": 0}})"),
            "FILE: special_runs.two_presses, without_slip, without_press and firm_lifts add up to 1.33; expected at most 1");
  EXPECT_NO_THROW(
      physics_from({{"special_runs", {{"two_presses", 0.6}, {"without_slip", 0.3}, {"without_press", 0.02}}}}, "FILE"));
  EXPECT_EQ(refusal(R"({"why": 3})"), "FILE: why is 3; expected a text");
  for (const std::string wrong :
       {"[]", "3", R"({"camera": 3})", R"({"objects": {}})", R"({"objects": [3]})", R"({"objects": [{}]})",
        R"({"objects": [{"name": "../fan"}]})", R"({"objects": [{"name": "Fan"}]})",
        R"({"objects": [{"name": "fan"}, {"name": "fan"}]})", R"({"camera": {"hot_hz": [3000, 100]}})",
        R"({"camera": {"size": [20, 20], "dead_pixels": 300}})", R"({"camera": {"hot_pixels": 1.5}})"}) {
    EXPECT_EQ(refusal(wrong).substr(0, 5), "FILE:") << wrong;
  }
  const test::TemporaryFolder folder;
  EXPECT_THROW(read_physics(folder / "none.json"), Error);
  write_whole(folder / "broken.json", "{");
  EXPECT_THROW(read_physics(folder / "broken.json"), Error);
}

}  // namespace
}  // namespace tactile::simulation
