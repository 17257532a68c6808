#include "tactile/experiments/study/sample_confusions.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::study {
namespace {

NamedConfusion confusion_of_run(const std::string& object, const std::string& run, std::uint64_t right) {
  NamedConfusion confusion{object + "/" + run, object, {}};
  confusion.confusion.counts[1][1] = right;
  confusion.confusion.counts[2][0] = 3;
  return confusion;
}

TEST(SampleConfusions, ComeBackAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  const std::vector<NamedConfusion> written{confusion_of_run("fan", "02", 5), confusion_of_run("fan", "03", 6)};
  write_confusions(folder / "samples.json", written);
  const auto read = read_confusions(folder / "samples.json");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].run, "fan/03");
  EXPECT_EQ(read[1].object, "fan");
  EXPECT_EQ(read[1].confusion, written[1].confusion);
}

TEST(SampleConfusions, OfChosenRunsInTheirOrder) {
  const std::vector<NamedConfusion> all{confusion_of_run("fan", "02", 5), confusion_of_run("fan", "03", 6),
                                        confusion_of_run("usb-hub", "02", 7)};
  const std::vector<std::string> chosen_runs{"usb-hub/02", "fan/03"};
  const auto chosen = confusions_of_runs(all, chosen_runs, 3);
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].object, "usb-hub");
  EXPECT_EQ(chosen[1].confusion.correct(), 6U);
  EXPECT_EQ(chosen[1].run, "03");
  EXPECT_EQ(chosen[1].training, 3U);
  const std::vector<std::string> missing{"fan/04"};
  EXPECT_THROW(confusions_of_runs(all, missing, 0), Error);
}

TEST(SampleConfusions, DamagedFilesAreAnError) {
  const test::TemporaryFolder folder;
  write_whole(folder / "samples.json", R"({"runs": [{"run": "fan/02", "object": "fan"}]})");
  EXPECT_THROW(read_confusions(folder / "samples.json"), Error);
  EXPECT_THROW(read_confusions(folder / "none.json"), Error);
}

}  // namespace
}  // namespace tactile::study
