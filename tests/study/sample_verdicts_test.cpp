#include "tactile/study/sample_verdicts.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

RunVerdicts verdicts_of(const std::string& object, const std::string& run, std::uint64_t right) {
  RunVerdicts verdicts{object + "/" + run, object, {}};
  verdicts.confusion.counts[1][1] = right;
  verdicts.confusion.counts[2][0] = 3;
  return verdicts;
}

TEST(SampleVerdicts, ComeBackAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  const std::vector<RunVerdicts> written{verdicts_of("fan", "02", 5), verdicts_of("fan", "03", 6)};
  write_verdicts(folder / "samples.json", written);
  const auto read = read_verdicts(folder / "samples.json");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].run, "fan/03");
  EXPECT_EQ(read[1].object, "fan");
  EXPECT_EQ(read[1].confusion, written[1].confusion);
}

TEST(SampleVerdicts, OfChosenRunsInTheirOrder) {
  const std::vector<RunVerdicts> all{verdicts_of("fan", "02", 5), verdicts_of("fan", "03", 6), verdicts_of("usb-hub", "02", 7)};
  const std::vector<std::string> wanted{"usb-hub/02", "fan/03"};
  const auto chosen = verdicts_on(all, wanted);
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].object, "usb-hub");
  EXPECT_EQ(chosen[1].confusion.correct(), 6U);
  const std::vector<std::string> missing{"fan/04"};
  EXPECT_THROW(verdicts_on(all, missing), Error);
}

TEST(SampleVerdicts, OfSeveralModelsAreCountedTogether) {
  const std::vector<std::vector<RunConfusion>> models{{{"fan", verdicts_of("fan", "02", 5).confusion}},
                                                      {{"fan", verdicts_of("fan", "02", 7).confusion}}};
  const auto sum = together(models);
  ASSERT_EQ(sum.size(), 1U);
  EXPECT_EQ(sum[0].confusion.correct(), 12U);
  EXPECT_EQ(sum[0].confusion.samples(), 18U);
  const std::vector<std::vector<RunConfusion>> different{models[0], {{"usb-hub", {}}}};
  EXPECT_THROW(together(different), Error);
}

TEST(SampleVerdicts, DamagedFilesAreAnError) {
  const test::TemporaryFolder folder;
  write_whole(folder / "samples.json", R"({"runs": [{"run": "fan/02", "object": "fan"}]})");
  EXPECT_THROW(read_verdicts(folder / "samples.json"), Error);
  EXPECT_THROW(read_verdicts(folder / "none.json"), Error);
}

}  // namespace
}  // namespace tactile
