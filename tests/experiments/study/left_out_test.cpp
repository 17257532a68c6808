#include "tactile/experiments/study/left_out.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::study {
namespace {

TEST(LeftOut, NamesRunsAndIntervalsWithTheirReasons) {
  const test::TemporaryFolder data;
  test::make_run(data.path(), {.object = "fan", .run = "01", .seed = 1});
  test::make_run(data.path(), {.object = "fan", .run = "02", .seed = 2, .flags = {{std::nullopt, "two sessions mixed", false}}});
  test::make_run(data.path(), {.object = "fan", .run = "03", .seed = 3, .flags = {{0, "it rings", false}}});
  test::make_run(data.path(), {.object = "fan", .run = "04", .seed = 4, .flags = {{1, "looked at", true}}});
  windows::write_dataset(data.path(), data / "dataset.h5", {}, 1);
  test::make_run(data.path(), {.object = "fan", .run = "05", .seed = 5, .labelled = false});
  const auto left_out = left_out_of(windows::Dataset(data / "dataset.h5"), find_runs(data.path()));
  const std::vector<std::vector<std::string>> expected{{"fan/02", "run", "flagged: two sessions mixed"},
                                                       {"fan/03", "run", "no samples: press-1 is flagged"},
                                                       {"fan/03", "press-1", "flagged: it rings"},
                                                       {"fan/05", "run", "no samples: no labels"}};
  ASSERT_EQ(left_out.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ((std::vector<std::string>{left_out[i].run, left_out[i].what, left_out[i].reason}), expected[i]);
}

}  // namespace
}  // namespace tactile::study
