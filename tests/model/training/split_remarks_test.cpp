#include "tactile/model/training/split_remarks.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/without_samples.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::model {
namespace {

using Names = std::vector<std::string>;

const std::vector<labels::LabelFlag> on_slip{{1, "it slides", false}}, on_run{{std::nullopt, "two sessions mixed", false}};

class RemarksOnASplit : public testing::Test {
 protected:
  void make(const std::string& object, const std::string& run, const std::vector<labels::LabelFlag>& flags = {}) {
    test::make_run(data.path(), {.object = object, .run = run, .seed = ++seed, .flags = flags});
  }
  windows::Dataset dataset() const {
    windows::write_dataset(data.path(), data / "dataset.h5", {}, 1);
    return windows::Dataset(data / "dataset.h5");
  }
  static SplitRemarks remarks(const windows::Dataset& dataset, const windows::SplitOptions& options = {}) {
    return remarks_on(dataset, options, split_of(dataset, options));
  }

  test::TemporaryFolder data;
  std::uint64_t seed = 0;
};

TEST_F(RemarksOnASplit, AreNoneForTheRequestedSplit) {
  for (const char* run : {"01", "02"}) make("mug", run);
  const SplitRemarks none = remarks(dataset());
  EXPECT_TRUE(none.substitutes.empty());
  EXPECT_TRUE(none.left_out.empty());
  EXPECT_TRUE(none.untested.empty());
  EXPECT_FALSE(none.flagged);
}

TEST_F(RemarksOnASplit, NameTheRunThatIsTrainedOnAndWhatIsWrongWithTheOther) {
  make("fan", "01");
  make("fan", "02");
  make("jar", "01", on_run);  // not in the dataset at all
  make("jar", "02");
  make("jar", "03");
  make("mug", "01", on_slip);
  make("mug", "02");
  make("pot", "02");
  make("pot", "03");
  const windows::Dataset made = dataset();
  const SplitRemarks found = remarks(made);
  EXPECT_EQ(found.substitutes, (Names{"jar: trained on run 02 in place of 01, which is flagged",
                                      "mug: trained on run 02 in place of 01, whose slip-1 is flagged",
                                      "pot: trained on run 02 in place of 01, which is not there"}));
  EXPECT_EQ(found.untested, (Names{"mug: not tested, none of its runs but 02 has samples"}));
  ASSERT_TRUE(found.flagged);
  EXPECT_TRUE(std::filesystem::exists(found.flagged->labels())) << found.flagged->folder;
  EXPECT_EQ(split_of(made, {}).train_runs.size(), 4U);

  const windows::SplitOptions unseen{.kind = windows::SplitKind::unseen, .held_out = {"mug", "jar"}};
  EXPECT_EQ(remarks(made, unseen).substitutes, (Names{"pot: trained on run 02 in place of 01, which is not there"}));
  EXPECT_TRUE(remarks(made, unseen).untested.empty());
}

TEST_F(RemarksOnASplit, NameObjectsWithoutAnyWholeRunInTheDatasetOrItsFolder) {
  for (const char* run : {"01", "02"}) {
    make("fan", run);
    make("jar", run, on_run);
    make("mug", run, on_slip);
  }
  const windows::Dataset made = dataset();
  test::make_run(data.path(), {.object = "pot", .seed = 9});  // recorded since
  // Damaged since.
  make("tin", "01");
  write_whole(data / "tin/01/labels.json", "{}");
  const Names expected{"jar: left out, none of its runs has samples: the whole run is flagged in jar/01, jar/02",
                       "mug: left out, none of its runs has samples: slip-1 is flagged in mug/01, mug/02",
                       "tin: left out, none of its runs has samples: labels cannot be read in tin/01"};
  const SplitRemarks found = remarks(made);
  EXPECT_EQ(found.left_out, expected);
  EXPECT_TRUE(found.substitutes.empty());
  EXPECT_EQ(test::error_of([&] { windows::refuse_objects_left_out(found.left_out); }),
            expected[0] + "; " + expected[1] + "; " + expected[2] +
                "; expected a run with samples of every object, as --strict asks for");
}

TEST_F(RemarksOnASplit, WithoutTheRunFoldersStillNameTheRuns) {
  make("mug", "01", on_slip);
  make("mug", "02");
  make("mug", "03");
  const windows::Dataset made = dataset();
  std::filesystem::remove_all(data / "mug");
  EXPECT_EQ(remarks(made).substitutes, (Names{"mug: trained on run 02 in place of 01, which has no samples"}));
}

}  // namespace
}  // namespace tactile::model
