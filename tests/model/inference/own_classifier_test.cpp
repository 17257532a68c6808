#include "tactile/model/inference/own_classifier.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "events/made_recording.hpp"
#include "model/small_data.hpp"
#include "model/stream_data.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/exported_network.hpp"
#include "tactile/model/training/lenet.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

constexpr events::SensorSize own_sensor{160, 120};  // heatmaps of 32 x 24

/// A network's file with its description, and what it predicts.
class OwnNetworkFile : public testing::Test {
 protected:
  OwnDescription heatmaps_of_sensor() const {
    OwnDescription description;
    description.input_name = "heatmaps";
    description.output_name = "logits";
    description.sensor = own_sensor;
    return description;
  }

  OwnDescription counts_of_sensor() const {
    OwnDescription description = heatmaps_of_sensor();
    description.input = OwnInput::counts;
    description.rendering.history = description.rendering.tick;
    description.grid = {0, 0, 160, 120};
    return description;
  }

  /// A TorchScript file of these methods.
  fs::path torchscript(const std::string& methods, const OwnDescription& description) const {
    write_whole(folder / "methods", methods);
    const std::string program = (fs::path(test::tactile_binary).parent_path() / "torchscript").string();
    const auto made = test::run_shell("'" + program + "' net.pt < methods", folder.path());
    EXPECT_EQ(made.exit_code, 0) << made.err;
    write_json(folder / "net.json", description);
    return folder / "net.pt";
  }

  /// A bundle, and its ONNX file with the description.
  std::pair<ModelBundle, fs::path> exported(const ModelDescription& model, const Weights& weights) const {
    const ModelBundle bundle{folder / "bundle"};
    write_bundle(bundle, model, {weights, {}}, {});
    write_whole(folder / "net.onnx", exported_onnx(model, weights, "test", {}));
    write_json(folder / "net.json", exported_description(model, weights, 1));
    return {bundle, folder / "net.onnx"};
  }

  std::string error_of(const fs::path& file) const {
    std::string error = test::error_of([&] { open_classifier(file, 1, EngineKind::fast); });
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  }

  test::TemporaryFolder folder;
};

ModelDescription described(ModelKind kind) {
  ModelDescription description;
  description.settings.kind = kind;
  description.input = kind == ModelKind::stream ? own_sensor : events::SensorSize{32, 24};
  if (kind == ModelKind::stream) description.settings.rendering.history = description.settings.rendering.tick;
  return description;
}

/// Events with a pause of 3 s.
std::vector<events::Event> events_with_pause() {
  std::vector<events::Event> events = test::steady_events(20'000, 1'000, 20, own_sensor);
  const std::vector<events::Event> more = test::steady_events(10'000, 3'400'000, 30, own_sensor);
  events.insert(events.end(), more.begin(), more.end());
  return events;
}

/// The largest difference of the logits of both, tick after tick.
double largest_difference(EventClassifier& one, EventClassifier& other, std::span<const events::Event> events) {
  double largest = 0;
  std::size_t next = 0;
  for (CameraTime t{4ms}; next < events.size(); t += 2ms) {
    const auto end = static_cast<std::size_t>(std::find_if(events.begin() + static_cast<std::ptrdiff_t>(next), events.end(),
                                                           [&](const auto& event) { return event.t >= t; }) -
                                              events.begin());
    std::array<Logits, 2> logits;
    for (std::size_t i = 0; EventClassifier * classifier : {&one, &other}) {
      classifier->add(events.subspan(next, end - next));
      classifier->move_to(t);
      classifier->prepare();
      logits.at(i++) = classifier->classify();
    }
    for (std::size_t k = 0; k < touch_count; ++k)
      largest = std::max(largest, std::abs(static_cast<double>(logits[0][k]) - static_cast<double>(logits[1][k])));
    EXPECT_EQ(one.events(), other.events());
    next = end;
  }
  return largest;
}

TEST_F(OwnNetworkFile, AnExportedStreamHasTheEnginesLogits) {
  const auto [bundle, file] = exported(described(ModelKind::stream), test::stream_weights());
  const Classifier engine(bundle.folder, 1), own = open_classifier(file, 1, EngineKind::fast);
  EXPECT_EQ(own.kind(), ModelKind::own);
  EXPECT_EQ(own.engine(), EngineKind::opencv);
  heatmaps::HeatmapOptions rendering = engine.rendering();
  rendering.mask = {{7, 11}};
  const auto events = events_with_pause();
  const auto one = engine.on_events(own_sensor, rendering), other = own.on_events(own_sensor, rendering);
  EXPECT_LE(largest_difference(*one, *other, events), 1e-5);
  one->restart(), other->restart();
  EXPECT_LE(largest_difference(*one, *other, std::span(events).first(5'000)), 1e-5);
}

TEST_F(OwnNetworkFile, AnExportedLeNetHasTheEnginesLogits) {
  const auto [bundle, file] = exported(described(ModelKind::lenet), LeNet({32, 24}, 3).weights());
  const Classifier engine(bundle.folder, 1), own = open_classifier(file, 1, EngineKind::fast);
  EXPECT_LE(largest_difference(*engine.on_events(own_sensor, engine.rendering()), *own.on_events(own_sensor, own.rendering()),
                               test::steady_events(8'000, 1'000, 30, own_sensor)),
            1e-5);
}

TEST_F(OwnNetworkFile, TorchScriptReadsTheHeatmapOfATick) {
  const Classifier own =
      open_classifier(torchscript("def forward(self, x):\n  return torch.stack([x.sum(), x[0, 0, 3, 5], x.max()]).unsqueeze(0)\n",
                                  heatmaps_of_sensor()),
                      1, EngineKind::fast);
  EXPECT_EQ(own.engine(), EngineKind::libtorch);
  const auto classifier = own.on_events(own_sensor, own.rendering());
  heatmaps::HeatmapRenderer renderer(own_sensor, own.rendering());
  const auto events = test::steady_events(5'000, 1'000, 30, own_sensor);
  classifier->add(events), renderer.add(events);
  for (const auto t : {CameraTime{60ms}, CameraTime{100ms}}) {
    classifier->move_to(t), renderer.move_to(t);
    classifier->prepare();
    std::vector<std::uint8_t> heatmap(std::size_t{32} * 24);
    renderer.render(std::span(heatmap));
    double sum = 0;
    for (const std::uint8_t cell : heatmap) sum += cell / 255.0;
    const Logits logits = classifier->classify();
    EXPECT_NEAR(logits[0], sum, 1e-3);
    EXPECT_NEAR(logits[1], heatmap[3 * 32 + 5] / 255.0, 1e-6);
    EXPECT_NEAR(logits[2], *std::max_element(heatmap.begin(), heatmap.end()) / 255.0, 1e-6);
    EXPECT_EQ(classifier->classify(), logits);
  }
}

TEST_F(OwnNetworkFile, StatesMoveOnOncePerTickWhicheverAreAskedFor) {
  OwnDescription counts = counts_of_sensor(), heatmaps = heatmaps_of_sensor();
  for (OwnDescription* description : {&counts, &heatmaps}) description->states = {{"n", "next_n", {1, 2}}};
  const std::string of_counts =
      "def forward(self, x, n):\n"
      "  on = x[:, 72:].sum()\n"
      "  n = n + torch.stack([torch.ones([]), on]).unsqueeze(0)\n"
      "  return torch.cat([n, x.sum().reshape([1, 1])], 1), n\n";
  const std::string of_heatmaps =
      "def forward(self, x, n):\n"
      "  n = n + torch.stack([torch.ones([]), x.max().ceil()]).unsqueeze(0)\n"
      "  return torch.cat([n, x.max().ceil().reshape([1, 1])], 1), n\n";
  for (const auto& [methods, description] : {std::pair{of_counts, counts}, {of_heatmaps, heatmaps}}) {
    const Classifier own = open_classifier(torchscript(methods, description), 1, EngineKind::fast);
    const auto classifier = own.on_events(own_sensor, own.rendering());
    for (int times = 0; times < 2; ++times) {
      // ON at 1 ms and 3 ms, OFF at 3 ms; nothing afterwards.
      classifier->add(
          std::vector{test::event_at(1'000, 5, 5, 1), test::event_at(3'000, 5, 5, 1), test::event_at(3'500, 9, 9, 0)});
      classifier->move_to(CameraTime{4ms});
      for (int again = 0; again < 3; ++again) classifier->prepare();
      EXPECT_EQ(classifier->classify(), (Logits{2, 2, description.input == OwnInput::counts ? 2.0F : 1.0F}));
      classifier->move_to(CameraTime{12ms});
      EXPECT_EQ(classifier->classify(), (Logits{6, description.input == OwnInput::counts ? 2.0F : 6.0F,
                                                description.input == OwnInput::counts ? 0.0F : 1.0F}));
      classifier->restart();
    }
    heatmaps::HeatmapOptions other = own.rendering();
    other.tick = other.history = 1ms;
    EXPECT_NE(test::error_of([&] { own.on_events(own_sensor, other); }).find("a tick of 1000 us; expected the 2000 us"),
              std::string::npos);
    EXPECT_NE(test::error_of([&] {
                own.on_events({320, 240}, own.rendering());
              }).find("events of a sensor of 320 x 240 px"),
              std::string::npos);
  }
}

TEST_F(OwnNetworkFile, SaysWhatIsWrongInOneSentence) {
  const auto expect_refused = [&](const std::string& body, const std::string& part, const OwnDescription& description) {
    const std::string error = error_of(torchscript("def forward(self, x):\n  " + body + "\n", description));
    EXPECT_NE(error.find("net.pt: "), std::string::npos) << error;
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  const OwnDescription heatmaps = heatmaps_of_sensor();
  expect_refused("return torch.zeros([1, 4])", "its output logits has the shape [1, 4]; expected [1, 3]", heatmaps);
  expect_refused("return torch.zeros([1, 3]), x", "it gives 2 values; expected 1", heatmaps);
  expect_refused("return 'press'", "its output logits is no tensor", heatmaps);
  expect_refused("return torch.zeros([1, 3]) / 0 * 0", "value 1 of its output logits is", heatmaps);
  expect_refused("return x.matmul(torch.zeros([5, 5]))", "libtorch cannot run it (RuntimeError: ", heatmaps);
  OwnDescription with_state = heatmaps;
  with_state.states = {{"n", "next_n", {1, 2}}};
  expect_refused("return torch.zeros([1, 3])", "libtorch cannot run it (", with_state);
  OwnDescription counts = counts_of_sensor();
  counts.grid = {5, 0, 5, 10};
  EXPECT_NE(
      error_of(torchscript("def forward(self, x):\n  return torch.zeros([1, 3])\n", counts)).find("net.json: a grid from x 5"),
      std::string::npos);

  for (const char* name : {"net.pt", "net.onnx"}) {
    write_whole(folder / name, "no network");
    EXPECT_NE(error_of(folder / name).find("cannot read it ("), std::string::npos);
  }
  const fs::path file = exported(described(ModelKind::stream), test::stream_weights()).second;
  OwnDescription description = read_own_description(file);
  description.states.front().input = "another";
  write_json(folder / "net.json", description);
  EXPECT_NE(error_of(file).find("net.onnx: OpenCV's dnn cannot run it ("), std::string::npos);
  description = read_own_description(file);
  description.states.front() = {"mean_5", "next_mean_5", {9, 25}};
  write_json(folder / "net.json", description);
  EXPECT_NE(error_of(file).find("net.onnx: OpenCV's dnn cannot run it ("), std::string::npos);
  fs::remove(folder / "net.json");
  EXPECT_NE(error_of(file).find("net.onnx: has no description; expected net.json beside it"), std::string::npos);
  write_json(folder / "net.json", exported_description(described(ModelKind::stream), test::stream_weights(), 1));
  EXPECT_NE(test::error_of([&] { open_classifier(file, 1, EngineKind::libtorch); }).find("is run by OpenCV's dnn"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] {
              open_classifier(file, 1, EngineKind::fast, {.precision = Precision::int8});
            }).find("--precision int8"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] { Classifier(file, 1); }).find("a network of one's own"), std::string::npos);
}

/// The times and probabilities of a table of ticks, by line.
std::map<std::string, std::string> ticks_in(const fs::path& file) {
  std::map<std::string, std::string> ticks;
  std::istringstream lines(read_text(file));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(','), fourth = line.find(',', line.find(',', line.find(',', first + 1) + 1) + 1);
    ticks[line.substr(0, first)] = line.substr(first, fourth - first);
  }
  return ticks;
}

TEST_F(OwnNetworkFile, EvalAndDetectShowTheSameTicks) {
  test::make_run(folder / "data/fan/01", 1);
  torchscript("def forward(self, x):\n  return torch.stack([x.max(), x.sum(), x[0, 0, 9].sum()]).unsqueeze(0)\n",
              heatmaps_of_sensor());
  fs::rename(folder / "net.pt", folder / "touch.pt");
  fs::rename(folder / "net.json", folder / "touch.json");
  exported(described(ModelKind::stream), test::stream_weights());
  for (const std::string name : {"touch.pt", "net.onnx"}) {
    const auto offline = test::run_tactile("eval data --run fan/01 --out ticks --model " + name, folder.path());
    ASSERT_EQ(offline.exit_code, 0) << offline.err;
    const auto live =
        test::run_tactile("detect --from file:data/fan/01 --speed 0 --ticks live.csv --json --model " + name, folder.path());
    ASSERT_EQ(live.exit_code, 0) << live.err;
    EXPECT_NE(live.out.find(name == "touch.pt" ? "\"libtorch\"" : "\"opencv\""), std::string::npos) << live.out;
    const auto all = ticks_in(folder / "ticks/fan-01.csv"), seen = ticks_in(folder / "live.csv");
    EXPECT_GT(seen.size(), 500U);
    for (const auto& [t, values] : seen) EXPECT_EQ(all.at(t), values) << name << " at " << t;
  }
  fs::remove(folder / "touch.json");
  for (const std::string command : {"eval data --run fan/01", "detect --from file:data/fan/01 --speed 0"}) {
    const auto refused = test::run_tactile(command + " --quiet --model touch.pt", folder.path());
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find("touch.pt: has no description; expected touch.json beside it"), std::string::npos) << refused.err;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  }
}

}  // namespace
}  // namespace tactile::model
