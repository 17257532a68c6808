#include "tactile/pictures/event_film.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tactile/pictures/drawing.hpp"

namespace tactile::pictures {
namespace {

constexpr std::int64_t begin_us = 1'700'000'000'000'000;
CameraTime at_ms(std::int64_t ms) { return camera_time(begin_us + 1000 * ms); }

EventFilmOptions options_of(events::SensorSize sensor = {640, 480}) {
  return {.title = "fan/01",
          .remark = "10 times slower, t_h 40 ms",
          .sensor = sensor,
          .rendering = {},
          .brightness = {.counts = 9, .heatmap = 200},
          .begin = at_ms(0),
          .end = at_ms(1000),
          .zero = at_ms(0),
          .intervals = {{Touch::press, at_ms(200), at_ms(400)}, {Touch::slip, at_ms(600), at_ms(900)}},
          .is_labelled = true};
}

EventCurve some_curve() {
  EventCurve curve(at_ms(0));
  std::vector<events::Event> events(4000);
  for (std::size_t i = 0; i < events.size(); ++i) events[i].t = after(at_ms(0), microseconds(250 * static_cast<int>(i)));
  curve.add(events);
  return curve;
}

Moment moment_at(CameraTime t, const EventFilmOptions& options, int value = 0) {
  const events::SensorSize size = heatmaps::heatmap_size(options.sensor, options.rendering.factor);
  return {.t = t,
          .events = 12'345,
          .counts = cv::Mat(options.sensor.height, options.sensor.width, CV_16UC1, cv::Scalar(value)),
          .denoised = {},
          .heatmap = cv::Mat(size.height, size.width, CV_8UC1, cv::Scalar(value))};
}

int pixels_of(const cv::Mat& picture, const cv::Scalar& colour) {
  cv::Mat found;
  cv::inRange(picture, colour, colour, found);
  return cv::countNonZero(found);
}

/// Where the cursor stands: the column with the most black, of the strip.
int cursor_column(const cv::Mat& picture) {
  cv::Mat black;
  cv::inRange(picture.rowRange(picture.rows - 20 - RateStrip::height, picture.rows), cv::Scalar(0, 0, 0), cv::Scalar(0, 0, 0),
              black);
  int column = -1, most = 0;
  for (int x = 0; x < black.cols; ++x) {
    const int count = cv::countNonZero(black.col(x));
    if (count > most) {
      most = count;
      column = x;
    }
  }
  return most > RateStrip::height / 2 ? column : -1;
}

TEST(EventFilm, FramesBothPicturesInTheColourOfTheLabel) {
  const EventFilmOptions options = options_of();
  const EventFilm film(options, some_curve());
  const std::vector<std::pair<std::int64_t, Touch>> times{
      {200, Touch::none}, {201, Touch::press}, {400, Touch::press}, {402, Touch::none}, {700, Touch::slip}};
  for (const auto& [ms, touch] : times) {
    EXPECT_EQ(film.touch_at(at_ms(ms)), touch) << ms;
    const cv::Mat picture = film.picture_of(moment_at(at_ms(ms), options));
    // Two frames of 512 x 384 px inside, 6 px wide.
    EXPECT_GT(pixels_of(picture, touch_colour(touch)), 2 * 6 * 2 * (512 + 384)) << ms;
    for (const Touch other : all_touches) {
      if (other != touch) {
        EXPECT_LT(pixels_of(picture, touch_colour(other)), 4'000) << ms;
      }
    }
  }
}

TEST(EventFilm, MovesItsCursorWithTheTime) {
  const EventFilmOptions options = options_of();
  const EventFilm film(options, some_curve());
  int before = -1;
  for (const std::int64_t ms : {0, 100, 500, 900, 1000}) {
    const int column = cursor_column(film.picture_of(moment_at(at_ms(ms), options)));
    EXPECT_GT(column, before) << ms;
    // The axis begins 78 px from the left and ends 36 px from the right.
    EXPECT_NEAR(column, 78 + (film.size().width - 114) * static_cast<double>(ms) / 1000, 3) << ms;
    before = column;
  }
}

TEST(EventFilm, ShowsCountsLeftAndHeatmapRight) {
  const EventFilmOptions options = options_of();
  const EventFilm film(options, some_curve());
  const auto bright_in = [&](const Moment& moment, const cv::Range& columns) {
    return pixels_of(film.picture_of(moment).colRange(columns), {164, 255, 252});
  };
  const cv::Range left(0, film.size().width / 2), right(film.size().width / 2, film.size().width);
  Moment moment = moment_at(at_ms(100), options);
  const int in_left = bright_in(moment, left), in_right = bright_in(moment, right);
  moment.counts.at<std::uint16_t>(100, 100) = 9;
  EXPECT_GE(bright_in(moment, left), in_left + 1);
  EXPECT_EQ(bright_in(moment, right), in_right);
  moment.heatmap.at<std::uint8_t>(40, 50) = 200;
  EXPECT_EQ(bright_in(moment, right), in_right + 16) << "a heatmap pixel is 4 x 4";
}

TEST(EventFilm, HasEvenSidesAndClipsNothingForAnySensor) {
  for (const events::SensorSize sensor :
       {events::SensorSize{640, 480}, {346, 260}, {160, 121}, {1280, 720}, {40, 30}, {5, 500}, {3000, 10}}) {
    EventFilmOptions options = options_of(sensor);
    options.title = std::string(300, 'W');
    const EventFilm film(options, some_curve());
    EXPECT_EQ(film.size().width % 2, 0);
    EXPECT_EQ(film.size().height % 2, 0);
    EXPECT_LT(film.size().width, 2000);
    Moment moment = moment_at(at_ms(300), options, 3);
    moment.events = 1'000'000'000;
    cv::Mat picture = film.picture_of(moment);
    EXPECT_EQ(picture.size(), film.size());
    picture(cv::Rect(10, 10, picture.cols - 20, picture.rows - 20)).setTo(paper);
    EXPECT_EQ(cv::norm(picture, cv::Mat(picture.size(), CV_8UC3, paper)), 0) << sensor.width << 'x' << sensor.height;
  }
}

TEST(EventFilm, ShowsNoLabelForWhatIsNotLabelled) {
  EventFilmOptions options = options_of();
  options.intervals.clear();
  options.is_labelled = false;
  const EventFilm film(options, some_curve());
  EXPECT_FALSE(film.touch_at(at_ms(300)));
  const cv::Mat picture = film.picture_of(moment_at(at_ms(300), options));
  EXPECT_EQ(pixels_of(picture, touch_colour(Touch::press)) + pixels_of(picture, touch_colour(Touch::slip)), 0);
}

}  // namespace
}  // namespace tactile::pictures
