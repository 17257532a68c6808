#include "tactile/heatmaps/heatmap_renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "heatmaps/rendered_heatmap.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::heatmaps {
namespace {

using test::every_method;
using test::Hits;
using test::is_true;
using test::rendered;

constexpr microseconds history = 40ms;

TEST(Heatmap, OfNoEventIsAllZero) {
  for (const HeatmapOptions& options : every_method()) {
    for (const float value : rendered<float>({}, {20, 10}, options)) EXPECT_EQ(value, 0.0F);
    for (const std::uint8_t value : rendered<std::uint8_t>({}, {20, 10}, options)) EXPECT_EQ(value, 0);
  }
}

TEST(Heatmap, OfOneEventIsATwentyFifthOfItsMaximumInOneCell) {
  const std::vector<Hits> one{{.x = 7, .y = 2}};
  for (HeatmapOptions options : every_method()) {
    options.resize = Resize::area;
    const auto exact = rendered<float>(one, {20, 10}, options);
    const auto bytes = rendered<std::uint8_t>(one, {20, 10}, options);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      EXPECT_FLOAT_EQ(exact[i], i == 1 ? 10.2F : 0.0F);
      EXPECT_EQ(bytes[i], i == 1 ? 10 : 0);
    }
    options.resize = Resize::linear;
    EXPECT_EQ(rendered<std::uint8_t>(one, {20, 10}, options)[1], 255);
  }
}

TEST(Heatmap, DoesNotCountMaskedPixels) {
  const std::vector<Hits> both{{.x = 2, .y = 2, .count = 4}, {.x = 7, .y = 2, .count = 900}}, first{both.front()};
  for (HeatmapOptions options : every_method()) {
    const auto expected = rendered<float>(first, {20, 10}, options);
    options.mask = {{7, 2}};
    EXPECT_EQ(rendered<float>(both, {20, 10}, options), expected);
  }
}

TEST(HeatmapOptions, HaveAMaskInTheirSettingsOnlyIfThereIsOne) {
  HeatmapOptions options;
  EXPECT_FALSE(nlohmann::json(options).contains("mask"));
  EXPECT_EQ(stored_name(options), "th_040");
  options.mask = {{7, 2}, {1, 5}};
  const nlohmann::json settings = options;
  EXPECT_EQ(settings.at("mask"), nlohmann::json({{7, 2}, {1, 5}}));
  EXPECT_EQ(settings.get<HeatmapOptions>(), options);
  EXPECT_EQ(stored_name(options).size(), std::string("th_040-12345678").size());
  HeatmapOptions other = options;
  other.mask = {{7, 2}};
  EXPECT_NE(stored_name(other), stored_name(options)) << "heatmaps with different masks are not mixed";
  EXPECT_THROW(HeatmapRenderer({7, 10}, options), Error) << "a masked pixel lies outside the sensor";
}

TEST(Heatmap, OfTwoCountsFollowsTheEquation) {
  // Pixels with 1 and 3 events: b = 2, D(1) = 1/(1+e^-1) = 0.731, D(3) = 3/(1+e) = 0.807.
  const std::vector<Hits> two{{.x = 2, .y = 2, .count = 1}, {.x = 7, .y = 2, .count = 3}};
  const auto by = [&](Denoise denoise) {
    return rendered<float>(two, {10, 5}, {.history = history, .denoise = denoise, .resize = Resize::linear});
  };
  const auto mean = by(Denoise::mean);
  EXPECT_FLOAT_EQ(mean[1], 255.0F);
  EXPECT_FLOAT_EQ(mean[0], static_cast<float>(255.0 * (1 / (1 + std::exp(-1.0))) / (3 / (1 + std::exp(1.0)))));
  // As printed: D(1) = 1/(1+e^3), D(3) = 3/(1+e^5).
  const auto literal = by(Denoise::literal);
  EXPECT_FLOAT_EQ(literal[0], 255.0F);
  EXPECT_FLOAT_EQ(literal[1], static_cast<float>(255.0 * (3 / (1 + std::exp(5.0))) / (1 / (1 + std::exp(3.0)))));
  EXPECT_FLOAT_EQ(by(Denoise::none)[0], 85.0F);
}

TEST(Heatmap, RoundsHalvesUp) {
  // 1 and 3 halves of the maximum in one cell: 255 * 2.5 / 25 = 25.5 exactly.
  EXPECT_EQ(rendered<std::uint8_t>({{.x = 0, .count = 2}, {.x = 1}, {.x = 2}, {.x = 3}}, {5, 5},
                                   {.history = history, .denoise = Denoise::none})[0],
            26);
  // 255 * 1 / 510 and 255 * 3 / 510, which rounding to the even number would take to 0 and 2.
  const auto bytes = rendered<std::uint8_t>({{.x = 0, .count = 510}, {.x = 1, .count = 1}, {.x = 2, .count = 3}}, {3, 1},
                                            {.history = history, .denoise = Denoise::none, .factor = 1});
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{255, 1, 2}));
  // Of pixels alike, 10 in cells of 10 x 10: 25.5; and of a third and its double, whose weights no binary fraction gives: 42.5,
  // 127.5.
  std::vector<Hits> tenth;
  for (int x = 0; x < 10; ++x) tenth.push_back({.x = x});
  EXPECT_EQ(rendered<std::uint8_t>(tenth, {10, 10}, {.history = history, .factor = 0.1})[0], 26);
  EXPECT_EQ(rendered<std::uint8_t>({{.x = 0, .count = 1}, {.x = 1, .count = 1}, {.x = 2, .count = 3}}, {4, 2},
                                   {.history = history, .denoise = Denoise::none, .factor = 0.5})[0],
            43);
}

TEST(Heatmap, IsThatOfThePlainFormulaForRandomEvents) {
  Random random(7);
  for (const events::SensorSize sensor :
       {events::SensorSize{640, 480}, {346, 260}, {320, 240}, {641, 479}, {643, 482}, {644, 13}, {5, 5}, {3, 4}, {23, 8}}) {
    for (const double density : {0.001, 0.1, 3.0}) {
      std::vector<Hits> pixels;
      const auto count = static_cast<std::size_t>(density * sensor.width * sensor.height) + 1;
      for (std::size_t i = 0; i < count; ++i) {
        pixels.push_back({static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.width))),
                          static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.height))),
                          static_cast<std::uint32_t>(random.below(100) == 0 ? random.below(60) + 1 : 1)});
      }
      for (const HeatmapOptions& options : every_method()) ASSERT_TRUE(is_true(pixels, sensor, options));
    }
  }
}

/// Random counts up to `most` are a random float32 frame once they are scaled to their maximum. OpenCV adds up in float32.
void expect_resized_as_opencv_does(events::SensorSize sensor, double factor, std::uint64_t most, Random& random) {
  std::vector<Hits> pixels;
  cv::Mat frame(sensor.height, sensor.width, CV_32F);
  double largest = 1;
  for (int y = 0; y < sensor.height; ++y) {
    for (int x = 0; x < sensor.width; ++x) {
      const auto count = static_cast<std::uint32_t>(random.below(most + 1));
      pixels.push_back({x, y, count});
      frame.at<float>(y, x) = static_cast<float>(count);
      largest = std::max<double>(largest, count);
    }
  }
  frame *= 255.0 / largest;
  for (const Resize resize : {Resize::area, Resize::linear}) {
    const std::string where =
        std::to_string(sensor.width) + "x" + std::to_string(sensor.height) + " by " + std::to_string(factor);
    const HeatmapOptions options{.history = history, .denoise = Denoise::none, .resize = resize, .factor = factor};
    const events::SensorSize size = heatmap_size(sensor, factor);
    if (size.width == 0 || size.height == 0) {
      EXPECT_THROW(HeatmapRenderer(sensor, options), Error) << where;
      continue;
    }
    cv::Mat expected;
    cv::resize(frame, expected, {}, factor, factor, resize == Resize::area ? cv::INTER_AREA : cv::INTER_LINEAR);
    ASSERT_EQ(size, (events::SensorSize{expected.cols, expected.rows})) << where;
    const auto floats = rendered<float>(pixels, sensor, options);
    const auto bytes = rendered<std::uint8_t>(pixels, sensor, options);
    for (int y = 0; y < expected.rows; ++y) {
      for (int x = 0; x < expected.cols; ++x) {
        const auto cell = static_cast<std::size_t>(y * expected.cols + x);
        ASSERT_NEAR(floats[cell], expected.at<float>(y, x), 3e-4) << where << " at " << x << ", " << y;
        ASSERT_NEAR(bytes[cell], expected.at<float>(y, x), 0.5006) << where << " at " << x << ", " << y;
      }
    }
  }
}

TEST(Heatmap, IsResizedAsOpenCvDoesAtEverySmallSize) {
  Random random(11);
  for (const double factor : {0.2, 0.1, 0.25, 0.5, 1.0 / 3, 1.0 / 7, 1.0}) {
    for (int width = 1; width <= 36; ++width) {
      for (int height = 1; height <= 12; ++height) expect_resized_as_opencv_does({width, height}, factor, 19, random);
    }
  }
}

TEST(Heatmap, IsResizedAsOpenCvDoesAtSizesOfSensors) {
  Random random(12);
  for (const events::SensorSize sensor : {events::SensorSize{640, 480},
                                          {346, 260},
                                          {240, 180},
                                          {128, 128},
                                          {641, 479},
                                          {642, 478},
                                          {643, 477},
                                          {644, 476},
                                          {645, 475},
                                          {655, 465},
                                          {656, 466},
                                          {1280, 720}}) {
    for (const double factor : {0.2, 0.1, 0.25, 0.5, 1.0 / 20}) expect_resized_as_opencv_does(sensor, factor, 3, random);
  }
}

TEST(HeatmapOptions, RefuseAHistoryThatIsNoWholeNumberOfTicks) {
  EXPECT_NO_THROW(check({.history = 2ms, .tick = 2ms}));
  EXPECT_NO_THROW(check({.history = 2500us, .tick = 500us}));
  EXPECT_THROW(check({.history = 2500us, .tick = 2ms}), Error);
  EXPECT_THROW(check({.history = 1ms, .tick = 2ms}), Error);
  EXPECT_THROW(check({.history = 0ms, .tick = 2ms}), Error);
  EXPECT_THROW(check({.history = 40ms, .tick = 0ms}), Error);
  EXPECT_THROW(HeatmapRenderer({640, 480}, {.history = 41ms}), Error);
  try {
    check({.history = 41ms});
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "history t_h of 41 ms; expected a whole number of ticks of 2 ms, at least one");
  }
}

TEST(HeatmapOptions, RefuseAFactorThatIsNoWholePart) {
  for (const double factor : {1.0, 0.5, 1.0 / 3, 0.25, 0.2, 0.1, 1.0 / 49}) EXPECT_NO_THROW(check({.factor = factor})) << factor;
  for (const double factor : {0.0, -0.2, 1.5, 0.3, 0.199, 1e-9, std::nan("")})
    EXPECT_THROW(check({.factor = factor}), Error) << factor;
  EXPECT_THROW(HeatmapRenderer({2, 2}, {.factor = 0.2}), Error);
}

TEST(HeatmapOptions, ComeBackFromJson) {
  for (const HeatmapOptions& options : every_method(0.1)) EXPECT_EQ(nlohmann::json(options).get<HeatmapOptions>(), options);
  EXPECT_THROW(nlohmann::json({{"history_us", 1}}).get<HeatmapOptions>(), Error);
  nlohmann::json json = HeatmapOptions{};
  json["denoise"] = "mild";
  EXPECT_THROW(json.get<HeatmapOptions>(), Error);
}

TEST(StoredName, IsThePlainOneForTheDefaultRenderingOnly) {
  EXPECT_EQ(stored_name({.history = 40ms}), "th_040");
  EXPECT_EQ(stored_name({.history = 2ms}), "th_002");
  EXPECT_EQ(stored_name({.history = 1000ms}), "th_1000");
  const std::string linear = stored_name({.history = 40ms, .resize = Resize::linear});
  EXPECT_EQ(linear.size(), std::string("th_040-12345678").size());
  EXPECT_EQ(linear.substr(0, 7), "th_040-");
  EXPECT_NE(linear, stored_name({.history = 40ms, .denoise = Denoise::none}));
  EXPECT_EQ(stored_name({.history = 2500us, .tick = 500us}).substr(0, 7), "th_002-");
}

TEST(HeatmapSize, IsRoundedAsOpenCvRounds) {
  EXPECT_EQ(heatmap_size({640, 480}, 0.2), (events::SensorSize{128, 96}));
  EXPECT_EQ(heatmap_size({346, 260}, 0.2), (events::SensorSize{69, 52}));
  EXPECT_EQ(heatmap_size({643, 642}, 0.2), (events::SensorSize{129, 128}));
  EXPECT_EQ(heatmap_size({645, 655}, 0.1), (events::SensorSize{64, 66}));
}

}  // namespace
}  // namespace tactile::heatmaps
