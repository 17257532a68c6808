#include "tactile/heatmaps/heatmap_renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "heatmaps/dense_reference.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile {
namespace {

constexpr microseconds history = 40ms;
constexpr CameraTime tick{history};

struct Hits {
  int x = 0, y = 0;
  std::uint32_t count = 1;
};

std::vector<Event> events_of(const std::vector<Hits>& pixels) {
  std::vector<Event> events;
  for (const Hits& pixel : pixels) {
    events.insert(events.end(), pixel.count,
                  Event{.t = {}, .x = static_cast<std::int16_t>(pixel.x), .y = static_cast<std::int16_t>(pixel.y)});
  }
  return events;
}

SlidingCounts counted(const std::vector<Event>& events, SensorSize sensor) {
  SlidingCounts counts(sensor, history);
  counts.add(events);
  counts.move_to(tick);
  return counts;
}

template <class T>
std::vector<T> rendered(const SlidingCounts& counts, const HeatmapOptions& options) {
  HeatmapRenderer renderer(counts.size(), options);
  std::vector<T> heatmap(static_cast<std::size_t>(renderer.size().width * renderer.size().height), T{77});
  renderer.render(counts, std::span(heatmap));
  return heatmap;
}

std::vector<HeatmapOptions> every_way(double factor = 0.2) {
  std::vector<HeatmapOptions> ways;
  for (const Denoise denoise : {Denoise::mean, Denoise::literal, Denoise::none}) {
    for (const Resize resize : {Resize::area, Resize::linear}) {
      ways.push_back({.history = history, .denoise = denoise, .resize = resize, .factor = factor});
    }
  }
  return ways;
}

/// Compares with the plain formula in long double: floats closely, bytes exactly but where the true value lies at a rounding
/// boundary.
void expect_true(const std::vector<Event>& events, SensorSize sensor, const HeatmapOptions& options) {
  SCOPED_TRACE(nlohmann::json(options).dump() + " on " + std::to_string(sensor.width) + "x" + std::to_string(sensor.height));
  const SlidingCounts counts = counted(events, sensor);
  const auto expected = test::dense_heatmap(test::dense_counts(events, sensor, tick, history), sensor, options);
  const auto exact = rendered<float>(counts, options);
  const auto bytes = rendered<std::uint8_t>(counts, options);
  ASSERT_EQ(exact.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_TRUE(std::isfinite(exact[i]));
    ASSERT_LE(std::abs(exact[i] - expected[i]), std::max(1e-6L * expected[i], 1e-30L)) << "cell " << i;
    const long double to_boundary = std::abs(expected[i] + 0.5L - std::round(expected[i] + 0.5L));
    if (to_boundary > 1e-3L) {
      ASSERT_EQ(static_cast<int>(bytes[i]), static_cast<int>(std::floor(expected[i] + 0.5L))) << "cell " << i;
    }
  }
}

TEST(Heatmap, OfNoEventIsAllZero) {
  for (const HeatmapOptions& options : every_way()) {
    for (const float value : rendered<float>(counted({}, {20, 10}), options)) EXPECT_EQ(value, 0.0F);
    for (const std::uint8_t value : rendered<std::uint8_t>(counted({}, {20, 10}), options)) EXPECT_EQ(value, 0);
  }
}

TEST(Heatmap, OfOneEventIsATwentyFifthOfItsMaximumInOneCell) {
  const SlidingCounts counts = counted(events_of({{.x = 7, .y = 2}}), {20, 10});
  for (HeatmapOptions options : every_way()) {
    options.resize = Resize::area;
    const auto exact = rendered<float>(counts, options);
    const auto bytes = rendered<std::uint8_t>(counts, options);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      EXPECT_FLOAT_EQ(exact[i], i == 1 ? 10.2F : 0.0F);
      EXPECT_EQ(bytes[i], i == 1 ? 10 : 0);
    }
    options.resize = Resize::linear;
    EXPECT_EQ(rendered<std::uint8_t>(counts, options)[1], 255);
  }
}

TEST(Heatmap, OfTwoCountsIsWhatTheEquationSays) {
  // Pixels with 1 and 3 events: b = 2, D(1) = 1/(1+e^-1) = 0.731, D(3) = 3/(1+e) = 0.807.
  const SlidingCounts counts = counted(events_of({{.x = 2, .y = 2, .count = 1}, {.x = 7, .y = 2, .count = 3}}), {10, 5});
  const auto mean = rendered<float>(counts, {.history = history, .resize = Resize::linear});
  EXPECT_FLOAT_EQ(mean[1], 255.0F);
  EXPECT_FLOAT_EQ(mean[0], static_cast<float>(255.0 * (1 / (1 + std::exp(-1.0))) / (3 / (1 + std::exp(1.0)))));
  // As printed: D(1) = 1/(1+e^3), D(3) = 3/(1+e^5).
  const auto literal = rendered<float>(counts, {.history = history, .denoise = Denoise::literal, .resize = Resize::linear});
  EXPECT_FLOAT_EQ(literal[0], 255.0F);
  EXPECT_FLOAT_EQ(literal[1], static_cast<float>(255.0 * (3 / (1 + std::exp(5.0))) / (1 / (1 + std::exp(3.0)))));
  const auto none = rendered<float>(counts, {.history = history, .denoise = Denoise::none, .resize = Resize::linear});
  EXPECT_FLOAT_EQ(none[0], 85.0F);
}

TEST(Heatmap, RoundsHalvesUp) {
  // 1 and 3 halves of the maximum in one cell: 255 * 2.5 / 25 = 25.5 exactly.
  const SlidingCounts counts =
      counted(events_of({{.x = 0, .count = 2}, {.x = 1, .count = 1}, {.x = 2, .count = 1}, {.x = 3, .count = 1}}), {5, 5});
  EXPECT_EQ(rendered<std::uint8_t>(counts, {.history = history, .denoise = Denoise::none})[0], 26);
}

TEST(Heatmap, OfEveryPixelAlikeIsFull) {
  for (const std::uint32_t count : {1U, 40U, 20'000U}) {
    std::vector<Hits> pixels;
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 10; ++x) pixels.push_back({x, y, count});
    }
    for (const HeatmapOptions& options : every_way()) {
      for (const std::uint8_t value : rendered<std::uint8_t>(counted(events_of(pixels), {10, 10}), options))
        EXPECT_EQ(value, 255);
    }
  }
}

TEST(Heatmap, IsRightWhereTheExponentialsAreBeyondFloatAndDouble) {
  const SensorSize sensor{20, 15};
  const std::vector<std::vector<Hits>> extremes{
      {{.x = 3, .y = 3, .count = 1'000'000}},                                // one hot pixel
      {{.x = 2, .y = 2, .count = 1'000'000}, {.x = 7, .y = 7, .count = 1}},  // and a quiet one
      {{.x = 2, .y = 2, .count = 1'000'000},
       {.x = 7, .y = 7, .count = 999'999},
       {.x = 12, .y = 12, .count = 999'990}},  // nearly alike
      {{.x = 2, .y = 2, .count = 2'000}, {.x = 7, .y = 2, .count = 2'050}, {.x = 3, .y = 2, .count = 1'900}},
      {{.x = 2, .y = 2, .count = 1'023}, {.x = 7, .y = 2, .count = 1'024}, {.x = 12, .y = 2, .count = 1'025}},
      {{.x = 2, .y = 2, .count = 800}, {.x = 7, .y = 2, .count = 1}, {.x = 12, .y = 7, .count = 2}},
  };
  for (const auto& pixels : extremes) {
    for (const HeatmapOptions& options : every_way()) expect_true(events_of(pixels), sensor, options);
  }
}

TEST(Heatmap, IsThatOfThePlainFormulaForRandomEvents) {
  Random random(7);
  for (const SensorSize sensor :
       {SensorSize{640, 480}, {346, 260}, {320, 240}, {641, 479}, {643, 482}, {644, 13}, {5, 5}, {3, 4}, {23, 8}}) {
    for (const double density : {0.001, 0.1, 3.0}) {
      std::vector<Hits> pixels;
      const auto count = static_cast<std::size_t>(density * sensor.width * sensor.height) + 1;
      for (std::size_t i = 0; i < count; ++i) {
        pixels.push_back({static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.width))),
                          static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.height))),
                          static_cast<std::uint32_t>(random.below(100) == 0 ? random.below(60) + 1 : 1)});
      }
      const std::vector<Event> events = events_of(pixels);
      for (const HeatmapOptions& options : every_way()) expect_true(events, sensor, options);
    }
  }
}

TEST(Heatmap, IsResizedAsOpenCvDoes) {
  Random random(11);
  for (const SensorSize sensor : {SensorSize{640, 480},
                                  {346, 260},
                                  {320, 240},
                                  {641, 479},
                                  {642, 478},
                                  {643, 477},
                                  {644, 476},
                                  {645, 475},
                                  {655, 465},
                                  {656, 466},
                                  {31, 18}}) {
    // Random counts are a random float32 frame once they are scaled to their maximum.
    std::vector<Hits> pixels;
    cv::Mat frame(sensor.height, sensor.width, CV_32F);
    double largest = 0;
    for (int y = 0; y < sensor.height; ++y) {
      for (int x = 0; x < sensor.width; ++x) {
        const auto count = static_cast<std::uint32_t>(random.below(6));
        pixels.push_back({x, y, count});
        frame.at<float>(y, x) = static_cast<float>(count);
        largest = std::max<double>(largest, count);
      }
    }
    frame *= 255.0 / largest;
    const SlidingCounts counts = counted(events_of(pixels), sensor);
    for (const double factor : {0.2, 0.1, 0.25, 0.5, 1.0}) {
      for (const Resize resize : {Resize::area, Resize::linear}) {
        const HeatmapOptions options{.history = history, .denoise = Denoise::none, .resize = resize, .factor = factor};
        cv::Mat expected;
        cv::resize(frame, expected, {}, factor, factor, resize == Resize::area ? cv::INTER_AREA : cv::INTER_LINEAR);
        const HeatmapRenderer renderer(sensor, options);
        ASSERT_EQ(renderer.size(), (SensorSize{expected.cols, expected.rows}))
            << sensor.width << 'x' << sensor.height << " by " << factor;
        const auto heatmap = rendered<float>(counts, options);
        for (int y = 0; y < expected.rows; ++y) {
          for (int x = 0; x < expected.cols; ++x) {
            ASSERT_NEAR(heatmap[static_cast<std::size_t>(y * expected.cols + x)], expected.at<float>(y, x), 1e-4)
                << sensor.width << 'x' << sensor.height << " by " << factor << " at " << x << ", " << y;
          }
        }
      }
    }
  }
}

TEST(Heatmap, DependsOnTheCountsAndNotOnHowTheyCameAbout) {
  Random random(3);
  std::vector<Event> events;
  for (int i = 0; i < 20'000; ++i) {
    events.push_back({.t = camera_time(i * 5),
                      .x = static_cast<std::int16_t>(random.below(64)),
                      .y = static_cast<std::int16_t>(random.below(48))});
  }
  HeatmapRenderer renderer({64, 48}, {.history = history});
  SlidingCounts slid({64, 48}, history);
  slid.add(events);
  std::vector<float> from_slid(13 * 10), from_fresh(13 * 10);
  for (std::int64_t t = 0; t <= 100'000; t += 2'000) {
    slid.move_to(camera_time(t));
    SlidingCounts fresh({64, 48}, history);
    fresh.add(events);
    fresh.move_to(camera_time(t));
    renderer.render(slid, std::span(from_slid));
    renderer.render(fresh, std::span(from_fresh));
    ASSERT_EQ(from_slid, from_fresh) << t;
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
    EXPECT_STREQ(e.what(), "history of 41000 us; expected a whole number of ticks of 2000 us, at least one");
  }
}

TEST(HeatmapOptions, RefuseAFactorThatIsNoWholePart) {
  for (const double factor : {1.0, 0.5, 1.0 / 3, 0.25, 0.2, 0.1, 1.0 / 49}) EXPECT_NO_THROW(check({.factor = factor})) << factor;
  for (const double factor : {0.0, -0.2, 1.5, 0.3, 0.199, 1e-9, std::nan("")})
    EXPECT_THROW(check({.factor = factor}), Error) << factor;
  EXPECT_THROW(HeatmapRenderer({2, 2}, {.factor = 0.2}), Error);
}

TEST(HeatmapOptions, ComeBackFromJson) {
  for (const HeatmapOptions& options : every_way(0.1)) EXPECT_EQ(nlohmann::json(options).get<HeatmapOptions>(), options);
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
  EXPECT_EQ(heatmap_size({640, 480}, 0.2), (SensorSize{128, 96}));
  EXPECT_EQ(heatmap_size({346, 260}, 0.2), (SensorSize{69, 52}));
  EXPECT_EQ(heatmap_size({643, 642}, 0.2), (SensorSize{129, 128}));
  EXPECT_EQ(heatmap_size({645, 655}, 0.1), (SensorSize{64, 66}));
}

}  // namespace
}  // namespace tactile
