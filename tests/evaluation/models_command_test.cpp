#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "evaluation/trained_model.hpp"
#include "support/run_command.hpp"
#include "support/settings_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::evaluation {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;
using test::Trained;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(ModelsCommand, ListsComparesPinsAndRemovesModels) {
  const Trained trained({"fan", "usb-hub"}, 2, 1);
  const fs::path& folder = trained.folder.path();
  const std::string first = trained.bundle.name();
  ASSERT_EQ(run_tactile("train --name second --epochs 2 --batch 64 --quiet", folder).exit_code, 0);

  const auto unjudged = run_tactile("models", folder);
  EXPECT_EQ(unjudged.exit_code, 0) << unjudged.err;
  EXPECT_TRUE(has(unjudged.out, first) && has(unjudged.out, "second")) << unjudged.out;
  ASSERT_EQ(run_tactile("eval --quiet --model second", folder).exit_code, 0);
  const auto json = nlohmann::json::parse(run_tactile("models --json", folder).out).at("models");
  ASSERT_EQ(json.size(), 2U);
  for (const auto& model : json) {
    EXPECT_GT(model.at("bytes"), 100'000);
    EXPECT_EQ(model.at("pinned"), false);
    EXPECT_EQ(model.at("eval").is_null(), model.at("name") != "second");
  }

  EXPECT_GT(json.at(json.at(0).at("name") == "second" ? 0 : 1).at("speed").at("us_p50").get<double>(), 0);
  EXPECT_TRUE(json.at(json.at(0).at("name") == "second" ? 1 : 0).at("speed").is_null()) << "not measured by 'eval'";
  const auto shown = run_tactile("models show second", folder);
  for (const char* place : {"models/second", "models/second/", "second"}) {
    const auto info = run_tactile(std::string("info ") + place, folder);
    EXPECT_EQ(info.out, shown.out) << place << ": " << info.err;
  }
  EXPECT_EQ(run_tactile("info --json models/second", folder).out, run_tactile("models show --json second", folder).out);
  EXPECT_EQ(run_tactile("info models/none", folder).exit_code, 1);
  EXPECT_TRUE(has(shown.out, "time per tick [us]")) << shown.out;
  EXPECT_TRUE(has(shown.out, "training.batch") && has(shown.out, "64") && has(shown.out, "accuracy [%]")) << shown.out;
  const auto compared = run_tactile("models compare second " + first, folder);
  EXPECT_TRUE(has(compared.out, "training.epochs") && has(compared.out, "training.batch")) << compared.out;
  EXPECT_FALSE(has(compared.out, "rendering.")) << "what is the same is left out\n" << compared.out;

  EXPECT_TRUE(has(run_tactile("eval", folder).err, "models/second, the last one that 'train' made here"));
  ASSERT_EQ(run_tactile("train --name stream --kind stream --steps 10 --quiet", folder).exit_code, 0);
  const auto kinds = run_tactile("models compare second stream", folder),
             all = run_tactile("models compare --verbose second stream", folder);
  EXPECT_TRUE(has(kinds.out, "training.epochs")) << kinds.out;
  EXPECT_GT(all.out.size(), kinds.out.size()) << "settings that neither uses\n" << all.out;
  ASSERT_EQ(run_tactile("models rm stream", folder).exit_code, 0);
  ASSERT_EQ(run_tactile("train --name third --epochs 1 --quiet --split unseen --held-out fan", folder).exit_code, 0);
  EXPECT_TRUE(has(run_tactile("eval", folder).err, "models/third, the last one")) << "of either split";
  ASSERT_EQ(run_tactile("train --name second --epochs 2 --batch 64 --quiet", folder).exit_code, 0);
  EXPECT_TRUE(has(run_tactile("eval", folder).err, "models/second, the last one")) << "unchanged, but asked for last";
  const auto live = run_tactile("detect --from file:data/fan/02 --speed 0", folder);
  EXPECT_TRUE(has(live.err, "models/second, the last one that 'train' made here")) << live.err;
  const auto report = run_tactile("report", folder);
  EXPECT_TRUE(has(report.err, "reporting models/second, the last one that 'train' made here")) << report.err;
  test::expect_settings_of("report/settings.json", "report", folder);
  test::expect_settings_of("models/second/eval-settings.json", "eval", folder);
  EXPECT_EQ(read_json(folder / "models/second/eval-settings.json").at("model"), "models/second");
  EXPECT_EQ(run_tactile("models rm third", folder).exit_code, 0);

  EXPECT_EQ(run_tactile("models pin " + first, folder).exit_code, 0);
  const auto evaluated = nlohmann::json::parse(run_tactile("eval --json", folder).out);
  EXPECT_EQ(evaluated.at("model").at("name"), first) << "although the other is newer";
  EXPECT_TRUE(has(run_tactile("eval", folder).err, first + ", the pinned model"));
  const auto kept = run_tactile("models rm second " + first, folder);
  EXPECT_EQ(kept.exit_code, 1);
  EXPECT_TRUE(has(kept.err, "is pinned; run 'tactile models unpin' first")) << kept.err;
  EXPECT_TRUE(fs::exists(folder / "models/second")) << "all or none";
  ASSERT_EQ(run_tactile("eval --quiet", folder).exit_code, 0);
  EXPECT_TRUE(has(run_tactile("report", folder).err, "reporting models/" + first + ", the pinned model"));
  EXPECT_TRUE(has(run_tactile("models unpin", folder).out, first + ": no longer pinned"));
  EXPECT_EQ(run_tactile("models rm " + first, folder).exit_code, 0);
  EXPECT_FALSE(fs::exists(folder / "models" / first));
  EXPECT_TRUE(fs::exists(folder / "models/second"));
}

TEST(ModelsCommand, RefusesWhatIsNoModelAndWrongNumbersOfNames) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "models/notes");
  write_whole(folder / "models/notes/text.txt", "mine");
  EXPECT_TRUE(has(run_tactile("models", folder.path()).out, "models: no model; 'tactile train' makes one"));
  const auto removed = run_tactile("models rm notes", folder.path());
  EXPECT_EQ(removed.exit_code, 1);
  EXPECT_TRUE(has(removed.err, "models/notes: is no model; expected a name that 'tactile models' lists")) << removed.err;
  EXPECT_TRUE(fs::exists(folder / "models/notes/text.txt"));
  EXPECT_TRUE(has(run_tactile("models rm ../models/notes", folder.path()).err, "is no model"));
  EXPECT_TRUE(has(run_tactile("models compare one", folder.path()).err, "compare: takes two names or more; 1 given"));
  EXPECT_TRUE(has(run_tactile("models pin", folder.path()).err, "pin: takes one name; 0 given"));
  write_whole(folder / "models/pinned", "gone\n");
  const auto lost = run_tactile("models", folder.path());
  EXPECT_EQ(lost.exit_code, 1);
  EXPECT_TRUE(has(lost.err, "models/pinned: names a model that is not there")) << lost.err;
}

}  // namespace
}  // namespace tactile::evaluation
