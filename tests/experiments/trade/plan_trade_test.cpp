#include "tactile/experiments/trade/plan_trade.hpp"

#include <gtest/gtest.h>

#include "model/small_data.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::trade {
namespace {

void flag_run(const std::filesystem::path& run) {
  labels::Labels labels = labels::read_labels(run / "labels.json");
  labels.flags.push_back({std::nullopt, "in doubt", false});
  labels::write_labels(run / "labels.json", labels);
}

TEST(PlanTrade, JudgesRunsThatTheDatasetHasNoSamplesOf) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 4);
  flag_run(folder / "data/fan/02");
  flag_run(folder / "data/usb-hub/04");
  std::filesystem::remove(folder / "data/fan/04/labels.json");
  std::filesystem::remove(folder / "data/fan/04/truth.json");
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  const TradePlan plan = plan_trade(completed({.data = folder / "data", .trainings = 2}, dataset), dataset);

  using Names = std::vector<std::string>;
  const experiments::RunDivision &first = plan.trainings[0].runs, &second = plan.trainings[1].runs;
  EXPECT_EQ(plan.names(first.choice), (Names{"usb-hub/02", "fan/02"})) << "the flagged run of the same name";
  EXPECT_EQ(plan.names(first.reported), (Names{"fan/03", "usb-hub/03", "usb-hub/04"}));
  EXPECT_EQ(plan.names(second.reported), (Names{"fan/01", "usb-hub/01", "fan/02", "usb-hub/04"})) << "its choice run is 03";
  ASSERT_EQ(plan.left_out.size(), 1U);
  EXPECT_EQ(plan.left_out[0].run, "fan/04");
  for (const auto& [index, run] : plan.judged) {
    EXPECT_EQ(run.samples.empty(), run.folder.name() == "fan/02" || run.folder.name() == "usb-hub/04") << run.folder.name();
    EXPECT_EQ(run.events_sha256.size(), 64U);
    EXPECT_TRUE(run.truth.has_truth);
  }
  EXPECT_EQ(plan.hashes(first.choice).size(), 2U);
}

TEST(PlanTrade, DecidesAStreamByItsUsualThresholds) {
  EXPECT_EQ(model::usual_decision(model::ModelKind::stream, {}).thresholds, model::TwoThresholds{});
  EXPECT_FALSE(model::usual_decision(model::ModelKind::stream, {2, 3}).thresholds);
  EXPECT_FALSE(model::usual_decision(model::ModelKind::lenet, {}).thresholds);
}

}  // namespace
}  // namespace tactile::trade
