#include "tactile/experiments/usual_trainings.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::experiments {
namespace {

/// A dataset of two simulated runs.
unsigned of_presets(const std::string& first, const std::string& second) {
  const test::TemporaryFolder folder;
  for (const auto& [run, preset] : {std::pair("01", first), std::pair("02", second)}) {
    test::make_run(folder.path(), {.run = run, .simulated = true});
    const RunFolder made{folder / "fan" / run, "fan", run};
    nlohmann::json json = read_json(made.info());
    json["simulation"]["preset"] = preset;
    write_json(made.info(), json);
  }
  windows::write_dataset(folder.path(), folder / "dataset.h5", {}, 1);
  return usual_trainings(windows::Dataset(folder / "dataset.h5"));
}

TEST(UsualTrainings, AreTwoOfTinyDataAndElseFive) {
  EXPECT_EQ(of_presets("tiny", "tiny"), 2U);
  EXPECT_EQ(of_presets("tiny", "quick"), 5U);
  const test::TemporaryFolder real;
  for (const char* run : {"01", "02"}) test::make_run(real.path(), {.run = run});
  windows::write_dataset(real.path(), real / "dataset.h5", {}, 1);
  EXPECT_EQ(usual_trainings(windows::Dataset(real / "dataset.h5")), 5U);
}

}  // namespace
}  // namespace tactile::experiments
