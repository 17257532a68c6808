#include "tactile/pictures/moments.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "windows/made_runs.hpp"

namespace tactile::pictures {
namespace {

struct MadeRecording {
  explicit MadeRecording(const test::LabelledRun& made = {})
      : run(made), events(test::random_events(made)), reader(test::make_run(folder / "data", made).events()) {}

  CameraTime at_ms(double ms) const { return camera_time(run.begin_us + static_cast<std::int64_t>(1000 * ms)); }

  test::TemporaryFolder folder;
  test::LabelledRun run;
  std::vector<events::Event> events;
  events::RecordingReader reader;
};

TEST(ForMoments, CountsTheEventsOfEachWindowAtTheirPixels) {
  MadeRecording made;
  // Close together, twice the same, far apart, no tick, and one at the time of an event, which belongs to the next window.
  std::vector<CameraTime> times{made.at_ms(60),    made.at_ms(61.234), made.at_ms(61.234),  made.at_ms(90),
                                made.at_ms(800.5), made.at_ms(1200),   made.events[9000].t, made.at_ms(1499)};
  std::sort(times.begin(), times.end());
  std::vector<CameraTime> seen;
  for_moments(made.reader, 0, {.history = 40ms}, times, MomentDetail::heatmap, [&](const Moment& moment) {
    seen.push_back(moment.t);
    cv::Mat expected(30, 40, CV_16UC1, cv::Scalar(0));
    for (const events::Event& event : made.events) {
      if (event.t >= moment.t - 40ms && event.t < moment.t) ++expected.at<std::uint16_t>(event.y, event.x);
    }
    EXPECT_EQ(cv::norm(moment.counts, expected, cv::NORM_L1), 0) << us_of(moment.t);
    EXPECT_EQ(moment.events, static_cast<std::uint64_t>(cv::sum(expected)[0]));
    EXPECT_TRUE(moment.denoised.empty());
  });
  EXPECT_EQ(seen, times);
}

TEST(ForMoments, RendersWhatTheDatasetHolds) {
  MadeRecording made;
  const heatmaps::HeatmapOptions options{.history = 20ms};
  std::map<CameraTime, std::vector<std::uint8_t>> expected;
  heatmaps::for_every_tick(made.events, made.run.sensor, options,
                           [&](CameraTime t, std::span<const std::uint8_t> heatmap, std::uint64_t) {
                             expected[t] = {heatmap.begin(), heatmap.end()};
                           });
  std::vector<CameraTime> times;
  for (const auto& [t, heatmap] : expected) times.push_back(t);
  std::size_t count = 0;
  for_moments(made.reader, 0, options, times, MomentDetail::all, [&](const Moment& moment) {
    ++count;
    ASSERT_EQ(moment.heatmap.total(), expected.at(moment.t).size());
    EXPECT_TRUE(std::equal(moment.heatmap.data, moment.heatmap.data + moment.heatmap.total(), expected.at(moment.t).begin()));
  });
  EXPECT_EQ(count, expected.size());
}

TEST(ForMoments, DenoisesByTheEquations) {
  MadeRecording made({.sensor = {20, 15}, .mean_gap_us = 60});
  const std::vector<CameraTime> times{made.at_ms(300), made.at_ms(700)};
  for_moments(made.reader, 0, {.history = 40ms}, times, MomentDetail::all, [&](const Moment& moment) {
    double pixels = 0, most = 0;
    for (int i = 0; i < 300; ++i) pixels += moment.counts.at<std::uint16_t>(i / 20, i % 20) > 0 ? 1 : 0;
    const double mean = static_cast<double>(moment.events) / pixels;
    const auto denoised = [&](int i) {
      const double count = moment.counts.at<std::uint16_t>(i / 20, i % 20);
      return count / (1 + std::exp(count - mean));
    };
    for (int i = 0; i < 300; ++i) most = std::max(most, denoised(i));
    for (int i = 0; i < 300; ++i) {
      // Rounded half up, but for what the last digits of either way decide.
      EXPECT_NEAR(moment.denoised.at<std::uint8_t>(i / 20, i % 20), 255 * denoised(i) / most, 0.5 + 1e-6);
    }
  });
}

TEST(ForMoments, NamesTheFileWhoseEventsGoBackInTime) {
  const MadeRecording made;
  const std::filesystem::path file = made.folder / "back.aedat4";
  {
    events::RecordingWriter writer(file, {events::event_stream_declaration(made.run.sensor, "DVXplorer_TEST")},
                                   {.compression = events::Compression::none});
    writer.write_events(0, made.events);
    writer.close();
  }
  std::string bytes = read_text(file);
  const auto bytes_of = [](std::int64_t t) { return std::string(reinterpret_cast<const char*>(&t), sizeof t); };
  const std::size_t place = bytes.find(bytes_of(us_of(made.events[20].t)));
  ASSERT_NE(place, std::string::npos);
  bytes.replace(place, 8, bytes_of(us_of(made.events[19].t) - 1));
  write_whole(file, bytes);
  events::RecordingReader reader(file);
  const std::vector<CameraTime> times{made.at_ms(40)};
  const std::string error =
      test::error_of([&] { for_moments(reader, 0, {}, times, MomentDetail::heatmap, [](const Moment&) {}); });
  EXPECT_NE(error.find("back.aedat4: events go back in time"), std::string::npos) << error;
}

TEST(BrightnessMeter, LeavesAFewHotPixelsAside) {
  Moment moment;
  moment.counts = cv::Mat(20, 50, CV_16UC1, cv::Scalar(4));
  moment.heatmap = cv::Mat(10, 20, CV_8UC1, cv::Scalar(60));
  moment.counts.rowRange(0, 10).setTo(0);  // what saw nothing does not count
  moment.counts.at<std::uint16_t>(15, 3) = 9000;
  moment.heatmap.at<std::uint8_t>(0, 0) = 250;
  BrightnessMeter meter;
  EXPECT_EQ(meter.result().counts, 1);
  EXPECT_EQ(meter.result().heatmap, 255);
  meter.add(moment);
  EXPECT_EQ(meter.result().counts, 4);
  EXPECT_EQ(meter.result().heatmap, 60);
  moment.counts.rowRange(15, 20).setTo(70);
  meter.add(moment);
  EXPECT_EQ(meter.result().counts, 70);
}

}  // namespace
}  // namespace tactile::pictures
