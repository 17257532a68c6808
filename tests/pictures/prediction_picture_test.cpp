#include "tactile/pictures/prediction_picture.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::pictures {
namespace {

/// A second of ticks: a press from 200 to 400 ms that is seen, and nothing else.
PredictionPicture small_picture() {
  PredictionPicture picture;
  picture.title = "fan/02 as a model sees it";
  for (int i = 0; i < 500; ++i) {
    const bool press = i > 100 && i <= 200;
    picture.ticks.push_back(
        {camera_time(5'000'000 + 2000 * i), press ? 50.0 : 1.0, press ? 1.0 : 0.0, 0.0, press ? Touch::press : Touch::none});
  }
  picture.has_labels = true;
  picture.labels = {{{Touch::press, camera_time(5'200'000), camera_time(5'400'000)}, "2 ms"}};
  return picture;
}

// [px] of the rows predicted, labelled and true, without the words next to them
constexpr int rows_top = 526, rows_bottom = 586, axis_left = 106;

/// Columns in which those rows hold this strong colour somewhere, first to last; {0, -1} without.
std::pair<int, int> columns_of(const cv::Mat& picture, const cv::Vec3b& colour, int bottom = rows_bottom) {
  std::pair<int, int> found{0, -1};
  for (int x = axis_left; x < picture.cols; ++x) {
    for (int y = rows_top; y < bottom; ++y) {
      if (picture.at<cv::Vec3b>(y, x) != colour) continue;
      if (found.second < 0) found.first = x;
      found.second = x;
      break;
    }
  }
  return found;
}

const cv::Vec3b blue(0xC8, 0x5A, 0x00), orange(0x00, 0x5A, 0xE6), grey_line(0xB8, 0xB8, 0xB8);

TEST(PredictionPicture, DrawsPredictionsAtTheirTicks) {
  const test::TemporaryFolder folder;
  draw_prediction(small_picture(), folder / "a.png");
  const cv::Mat picture = cv::imread((folder / "a.png").string());
  ASSERT_EQ(picture.cols, 1100);
  // The axis goes from 104 to 1076 px for 998 ms.
  const auto [first, last] = columns_of(picture, blue);
  EXPECT_NEAR(first, 104 + 972 * 0.200 / 0.998, 3);
  EXPECT_NEAR(last, 104 + 972 * 0.400 / 0.998, 3);
  EXPECT_EQ(columns_of(picture, orange).second, -1);
  EXPECT_EQ(columns_of(picture, grey_line).second, -1);
}

TEST(PredictionPicture, CountsFromTheFirstEventIfThatIsKnown) {
  PredictionPicture since_event = small_picture();
  since_event.first_event = camera_time(4'502'000);
  const test::TemporaryFolder folder;
  draw_prediction(since_event, folder / "a.png");
  // The axis goes from 104 to 1076 px for 1.496 s; the ticks begin at 0.498 s.
  const auto [first, last] = columns_of(cv::imread((folder / "a.png").string()), blue);
  EXPECT_NEAR(first, 104 + 972 * 0.698 / 1.496, 3);
  EXPECT_NEAR(last, 104 + 972 * 0.898 / 1.496, 3);
  EXPECT_NE(prediction_plot(since_event).script.find("time since the first event [s]"), std::string::npos);
  EXPECT_NE(prediction_plot(small_picture()).script.find("time since the first full tick [s]"), std::string::npos);
}

TEST(PredictionPicture, ShowsTheTruthWhereThereIsOne) {
  PredictionPicture with = small_picture();
  with.has_truth = true;
  with.truth = {{{Touch::slip, camera_time(5'600'000), camera_time(5'700'000)}, "4 ms"}};
  with.unlabelled = {{Touch::press, camera_time(5'800'000), camera_time(5'900'000)}};
  const test::TemporaryFolder folder;
  draw_prediction(with, folder / "a.png");
  const cv::Mat picture = cv::imread((folder / "a.png").string());
  EXPECT_NEAR(columns_of(picture, orange, rows_bottom + 34).first, 104 + 972 * 0.600 / 0.998, 3);
  EXPECT_NEAR(columns_of(picture, grey_line, rows_bottom + 34).first, 104 + 972 * 0.800 / 0.998, 3);
  // The labelled press is a thin row of its own: neither a reference nor a detection.
  const std::string script = prediction_plot(with).script;
  EXPECT_NE(script.find("'slip: 4 ms'"), std::string::npos);
  EXPECT_NE(script.find("'true slip'"), std::string::npos);
  EXPECT_EQ(script.find("'press: 2 ms'"), std::string::npos);
  EXPECT_EQ(script.find("'labelled press"), std::string::npos);
  EXPECT_NE(prediction_plot(small_picture()).script.find("'press: 2 ms'"), std::string::npos);
}

TEST(PredictionPicture, ASingleTickOfAClassIsSeen) {
  PredictionPicture lone = small_picture();
  lone.labels.clear();
  lone.ticks.resize(100);
  for (int i = 100; i < 20'000; ++i)
    lone.ticks.push_back({camera_time(5'000'000 + 2000 * i), 1.0, 0.0, 0.0, i == 9000 ? Touch::slip : Touch::none});
  const test::TemporaryFolder folder;
  const auto slips_in = [&folder](const PredictionPicture& drawn) {
    draw_prediction(drawn, folder / "a.svg");
    const std::string svg = read_text(folder / "a.svg"), fill = "fill = 'rgb(230,  90,   0)'";
    std::size_t count = 0;
    for (std::size_t at = svg.find(fill); at != std::string::npos; at = svg.find(fill, at + 1)) ++count;
    return count;
  };
  const std::size_t with = slips_in(lone);
  for (PredictedTick& tick : lone.ticks) tick.verdict = Touch::none;
  EXPECT_EQ(with, slips_in(lone) + 1) << "besides the key";
}

TEST(PredictionPicture, TakesAnyWordsAndNeedsATick) {
  PredictionPicture odd = small_picture();
  odd.title = "it's $x `date` %s \xff";
  odd.labels[0].words = "'; exit";
  const test::TemporaryFolder folder;
  draw_prediction(odd, folder / "a.png");
  EXPECT_FALSE(cv::imread((folder / "a.png").string()).empty());
  odd.ticks.clear();
  EXPECT_THROW(prediction_plot(odd), Error);
}

}  // namespace
}  // namespace tactile::pictures
