#include "tactile/model/bundle/own_description.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::model {
namespace {

nlohmann::json counts_json() {
  return nlohmann::json::parse(R"({
    "format": 1, "classes": ["none", "press", "slip"], "learned_from": [],
    "input": {"kind": "counts", "shape": [9, 144]}, "grid": [10, 20, 630.5, 470],
    "sensor": {"width": 640, "height": 480},
    "rendering": {"history_us": 2000, "tick_us": 2000, "factor": 0.2, "denoise": "mean", "resize": "area"},
    "states": [{"input": "memory", "output": "next_memory", "shape": [1, 40]}]})");
}

nlohmann::json heatmap_json() {
  nlohmann::json json = counts_json();
  json["input"] = {{"kind", "heatmap"}, {"name", "x"}, {"shape", {1, 1, 96, 128}}};
  json["rendering"]["history_us"] = 40'000;
  json["output"] = {{"name", "y"}};
  json["temperature"] = 1.5;
  json.erase("grid");
  json.erase("states");
  return json;
}

TEST(OwnDescription, IsReadAndWritten) {
  const OwnDescription counts = own_description_in(counts_json(), "a.json");
  EXPECT_EQ(counts.input, OwnInput::counts);
  EXPECT_EQ(counts.input_name, "counts");
  EXPECT_EQ(counts.output_name, "logits");
  EXPECT_EQ(counts.sensor, (events::SensorSize{640, 480}));
  EXPECT_EQ(counts.rendering.tick, 2ms);
  EXPECT_EQ(counts.grid, (std::array<double, 4>{10, 20, 630.5, 470}));
  EXPECT_EQ(counts.states, (std::vector<NetworkState>{{"memory", "next_memory", {1, 40}}}));
  EXPECT_EQ(counts.temperature, 1);
  const OwnDescription heatmap = own_description_in(heatmap_json(), "a.json");
  EXPECT_EQ(heatmap.input_shape(), (std::vector<std::int64_t>{1, 1, 96, 128}));
  EXPECT_EQ(heatmap.input_name, "x");
  EXPECT_EQ(heatmap.output_name, "y");
  EXPECT_TRUE(heatmap.states.empty());
  EXPECT_EQ(heatmap.temperature, 1.5);
  for (const OwnDescription& description : {counts, heatmap}) {
    const nlohmann::json written = description;
    EXPECT_EQ(nlohmann::json(own_description_in(written, "a.json")), written);
  }
}

TEST(OwnDescription, SaysWhatIsWrong) {
  const auto expect_refused = [](nlohmann::json json, const std::function<void(nlohmann::json&)>& change,
                                 const std::string& part) {
    change(json);
    const std::string error = test::error_of([&] { own_description_in(json, "a.json"); });
    EXPECT_EQ(error.find("a.json: "), 0U) << error;
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  using Json = nlohmann::json;
  for (const char* key : {"format", "classes", "input", "sensor", "rendering", "grid", "learned_from"})
    expect_refused(
        counts_json(), [&](Json& json) { json.erase(key); }, key);
  expect_refused(
      counts_json(),
      [](Json& json) {
        json["classes"] = {"press", "slip"};
      },
      "its classes are not none, press and slip");
  expect_refused(
      counts_json(), [](Json& json) { json["format"] = 2; }, "of format 2; expected 1");
  expect_refused(
      counts_json(), [](Json& json) { json["input"]["kind"] = "frames"; }, "expected heatmap or counts");
  expect_refused(
      counts_json(),
      [](Json& json) {
        json["input"]["shape"] = {1, 9, 144};
      },
      "input.shape of [1,9,144]; expected [9,144]");
  expect_refused(
      counts_json(), [](Json& json) { json["rendering"]["history_us"] = 40'000; }, "expected 2000, the tick");
  expect_refused(
      heatmap_json(),
      [](Json& json) {
        json["input"]["shape"] = {1, 1, 96, 127};
      },
      "expected [1,1,96,128]");
  expect_refused(
      heatmap_json(), [](Json& json) { json["rendering"]["factor"] = 0.3; }, "factor");
  expect_refused(
      heatmap_json(), [](Json& json) { json["rendering"]["history_us"] = 1'000'000'000; }, "history_us is 1000000000; expected");
  expect_refused(
      heatmap_json(), [](Json& json) { json["sensor"]["width"] = 1'000'000; }, "expected sides of 1 to 32767");
  expect_refused(
      heatmap_json(), [](Json& json) { json["temperature"] = 0; }, "a temperature of 0");
  for (const Json& shape : {Json{1, 0}, Json{-1, 4}, Json{1 << 13, 1 << 13}, Json{std::int64_t{1} << 40, std::int64_t{1} << 40}})
    expect_refused(
        counts_json(), [&](Json& json) { json["states"][0]["shape"] = shape; }, "16777216 values at most");
  expect_refused(
      counts_json(),
      [](Json& json) {
        json["states"][0]["shape"] = {1 << 12, 1 << 11};
        for (int i = 0; i < 2; ++i) json["states"].push_back(json["states"][0]);
      },
      "16777216 values at most in all states");
  expect_refused(
      counts_json(), [](Json& json) { json["states"] = Json(100, json["states"][0]); }, "100 states; expected 64 at most");
  expect_refused(
      Json::array(), [](Json&) {}, "format");
}

TEST(OwnDescription, IsBesideTheNetworksFile) {
  const test::TemporaryFolder folder;
  write_whole(folder / "a.pt", "");
  write_whole(folder / "a.bin", "");
  std::filesystem::create_directories(folder / "b.onnx");
  EXPECT_TRUE(is_own_network(folder / "a.pt"));
  for (const char* other : {"a.bin", "b.onnx", "c.pt"}) EXPECT_FALSE(is_own_network(folder / other)) << other;
  EXPECT_NE(
      test::error_of([&] { read_own_description(folder / "a.pt"); }).find("a.pt: has no description; expected a.json beside"),
      std::string::npos);
  write_json(folder / "a.json", heatmap_json());
  EXPECT_EQ(read_own_description(folder / "a.pt").input_name, "x");
}

}  // namespace
}  // namespace tactile::model
