#include "tactile/report/prediction_file.hpp"

#include <gtest/gtest.h>

#include "report/plot_rows.hpp"
#include "report/prediction_text.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::report {
namespace {

using test::contains;
using test::error_of;
using test::TemporaryFolder;

TEST(PredictionFile, GivesTicksAndTheIntervalsTheyLieIn) {
  const TemporaryFolder folder;
  write_whole(folder / "run.csv", test::prediction_text);
  const pictures::PredictionPicture picture = read_prediction(folder / "run.csv", 40);
  ASSERT_EQ(picture.ticks.size(), 4U);
  EXPECT_EQ(picture.ticks[1].verdict, Touch::press);
  EXPECT_EQ(picture.ticks[1].events_per_ms, 10);
  EXPECT_EQ(picture.ticks[1].press, 0.8);
  EXPECT_TRUE(picture.has_labels && picture.has_truth);
  ASSERT_EQ(picture.labels.size(), 1U);
  EXPECT_EQ(picture.labels[0].interval.start, camera_time(1000));  // a tick is in it if it lies after the start
  EXPECT_EQ(picture.labels[0].interval.end, camera_time(5000));
  ASSERT_EQ(picture.truth.size(), 1U);
  EXPECT_EQ(picture.truth[0].interval.start, camera_time(3000));
  ASSERT_EQ(picture.unlabelled.size(), 1U);

  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {"", "line 1: has no column 't_us'"},
           {"t_us,p_none,p_press,p_slip,verdict,label,truth,events\n", "has no tick"},
           {"a,b\n", "line 1: has no column 't_us'"},
           {test::prediction_text + "9000,x,y,z,none,none,none,80,\n", "line 6: has a field that is not a number"},
           {test::prediction_text + "9000,0.9,0.1,0,twist,none,none,80,\n", "line 6: has an unknown class"},
           {test::prediction_text + "7000,0.9,0.1,0,none,none,none,80,\n", "line 6: is not later than the line before"},
           {test::prediction_text + "9000,0.9\n", "line 6: has too few columns"}}) {
    write_whole(folder / "run.csv", text);
    EXPECT_TRUE(contains(error_of([&] { read_prediction(folder / "run.csv", 40); }), words)) << words;
  }
}

}  // namespace
}  // namespace tactile::report
