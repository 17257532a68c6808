#include "tactile/experiments/run_division.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::experiments {
namespace {

using Names = std::vector<std::string>;

const std::vector<labels::LabelFlag> on_slip{{1, "it slides", false}};

class RunDivisionOf : public testing::Test {
 protected:
  /// Runs 01 to 03 of mug and fan; flagged are those that are named.
  windows::Dataset dataset(const Names& flagged) {
    std::uint64_t seed = 0;
    for (const char* object : {"fan", "mug"}) {
      for (const char* run : {"01", "02", "03"}) {
        const bool is_flagged = std::find(flagged.begin(), flagged.end(), std::string(object) + "/" + run) != flagged.end();
        test::make_run(
            data.path(),
            {.object = object, .run = run, .seed = ++seed, .flags = is_flagged ? on_slip : std::vector<labels::LabelFlag>{}});
      }
    }
    windows::write_dataset(data.path(), data / "dataset.h5", {}, 1);
    return windows::Dataset(data / "dataset.h5");
  }

  test::TemporaryFolder data;
  const Names choice{"02"};
};

TEST_F(RunDivisionOf, WholeRunsAreDividedByTheirIds) {
  const windows::Dataset whole = dataset({});
  const RunDivision runs = divide_runs(whole, "01", choice);
  EXPECT_EQ(names_of(whole, runs.train), (Names{"fan/01", "mug/01"}));
  EXPECT_EQ(names_of(whole, runs.choice), (Names{"fan/02", "mug/02"}));
  EXPECT_EQ(names_of(whole, runs.reported), (Names{"fan/03", "mug/03"}));
  EXPECT_EQ(names_of(whole, runs.all_test), (Names{"fan/02", "fan/03", "mug/02", "mug/03"}));
  EXPECT_TRUE(remarks_on(whole, runs).empty());
}

TEST_F(RunDivisionOf, ReportsEveryRunInTurnWhereTrainingsRotate) {
  const windows::Dataset whole = dataset({});
  EXPECT_EQ(rotated_run(whole, "02", 0), "02");
  EXPECT_EQ(rotated_run(whole, "02", 2), "01");
  EXPECT_EQ(rotated_run(whole, "07", 1), "02") << "the first run stands for one that there is not";
  const std::vector<std::pair<Names, Names>> trained_and_reported{{{"fan/01", "mug/01"}, {"fan/03", "mug/03"}},
                                                                  {{"fan/02", "mug/02"}, {"fan/01", "mug/01"}},
                                                                  {{"fan/03", "mug/03"}, {"fan/02", "mug/02"}},
                                                                  {{"fan/01", "mug/01"}, {"fan/03", "mug/03"}}};
  for (std::size_t training = 0; training < trained_and_reported.size(); ++training) {
    const RunDivision runs = rotated_division(whole, "01", choice, training);
    EXPECT_EQ(names_of(whole, runs.train), trained_and_reported[training].first);
    EXPECT_EQ(names_of(whole, runs.reported), trained_and_reported[training].second);
    EXPECT_EQ(runs.choice.size(), 2U);
  }
}

TEST_F(RunDivisionOf, NeverReportsOnARunLearnedFromOrChosenOn) {
  const windows::Dataset damaged = dataset({"mug/02", "fan/03"});
  for (std::size_t training = 0; training < 5; ++training) {
    const RunDivision runs = rotated_division(damaged, "01", choice, training);
    for (const std::uint32_t run : runs.reported) {
      EXPECT_EQ(std::count(runs.train.begin(), runs.train.end(), run), 0);
      EXPECT_EQ(std::count(runs.choice.begin(), runs.choice.end(), run), 0);
    }
    EXPECT_EQ(runs.train.size(), 2U) << "each object has a training run, " << training;
  }
}

TEST_F(RunDivisionOf, ARunThatTakesAnothersPlaceIsNeitherChosenNorReportedOn) {
  const windows::Dataset damaged = dataset({"mug/01"});
  const RunDivision runs = divide_runs(damaged, "01", choice);
  EXPECT_EQ(names_of(damaged, runs.train), (Names{"fan/01", "mug/02"}));
  EXPECT_EQ(names_of(damaged, runs.choice), (Names{"fan/02"}));
  EXPECT_EQ(names_of(damaged, runs.reported), (Names{"fan/03", "mug/03"}));
  EXPECT_EQ(remarks_on(damaged, runs), (Names{"mug: no run of it is left to choose settings on"}));
}

TEST_F(RunDivisionOf, ObjectsWithoutARunInASetAreNamed) {
  const windows::Dataset damaged = dataset({"mug/01", "mug/03", "fan/03"});
  const RunDivision runs = divide_runs(damaged, "01", choice);
  EXPECT_EQ(names_of(damaged, runs.train), (Names{"fan/01", "mug/02"}));
  EXPECT_EQ(names_of(damaged, runs.reported), (Names{"fan/02"})) << "chosen on nothing, so that it is reported on";
  EXPECT_EQ(remarks_on(damaged, runs), (Names{"mug: not tested, none of its runs but 02 has samples"}));
}

TEST_F(RunDivisionOf, WithoutAnythingToTestOnIsAnError) {
  const windows::Dataset damaged = dataset({"mug/02", "mug/03", "fan/02", "fan/03"});
  EXPECT_NE(test::error_of([&] { divide_runs(damaged, "01", choice); }).find("no run with samples is left to test on"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile::experiments
