#include "tactile/pictures/label_picture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::pictures {
namespace {

constexpr std::int64_t labels_begin_us = 1'700'000'000'000'000;

CameraTime label_at_ms(double ms) { return camera_time(labels_begin_us + static_cast<std::int64_t>(1000 * ms)); }

labels::LabelledInterval touch(Touch kind, const std::string& id, double start_ms, double end_ms) {
  labels::LabelledInterval interval;
  interval.id = id;
  interval.touch = kind;
  interval.start = {label_at_ms(start_ms), label_at_ms(start_ms - 0.8), label_at_ms(start_ms + 0.4)};
  interval.end = {label_at_ms(end_ms), label_at_ms(end_ms - 10), label_at_ms(end_ms + 20)};
  interval.source = "events";
  interval.evidence.events = label_at_ms(start_ms);
  return interval;
}

Trace trace_of(TraceKind kind, const std::string& name, double step_ms, double (*value)(double ms)) {
  Trace trace{.kind = kind, .name = name};
  for (int i = 0; - 20 + i * step_ms < 4'020; ++i) {
    const double ms = -20 + i * step_ms;
    trace.t.push_back(label_at_ms(ms));
    trace.values.push_back(value(ms));
  }
  return trace;
}

double lifted(double ms) { return ms < 2'000 ? 0.0 : ms < 2'500 ? (ms - 2'000) / 5 : 100.0; }

/// Four seconds with a press at 1 s and a slip at 2 s, each with all sources.
LabelPicture whole_picture() {
  LabelPicture picture;
  picture.title = "fan/01 (made up)";
  picture.begin = label_at_ms(0);
  picture.end = label_at_ms(4'000);
  picture.rate.begin = label_at_ms(0);
  picture.rate.bin = microseconds(200);
  for (int i = 0; i < 20'000; ++i) {
    const double ms = 0.2 * i;
    const bool moves = (ms >= 1'000 && ms < 1'200) || (ms >= 2'000 && ms < 2'500);
    picture.rate.counts.push_back((i % 3 == 0 ? 4U : 2U) + (moves ? 60U + static_cast<std::uint32_t>(i % 40) : 0U));
  }
  picture.labels.intervals = {touch(Touch::press, "press-1", 1'000, 1'200), touch(Touch::slip, "slip-1", 2'000, 2'500)};
  labels::Evidence& slip = picture.labels.intervals[1].evidence;
  slip.robot = label_at_ms(1'996);
  slip.video = label_at_ms(2'021);
  slip.imu = label_at_ms(1'999);
  picture.labels.intervals[0].evidence.robot = label_at_ms(700);
  picture.labels.intervals[0].evidence.video = label_at_ms(1'012);
  alignment::FittedClock clock;
  clock.relation = {.offset_us = 1'000, .drift_ppm = 0, .reference_us = 0};
  clock.offset_low_us = -4'000;
  clock.offset_high_us = 7'000;
  clock.anchors = 3;
  clock.method = "IMU against the arm's acceleration";
  picture.labels.robot_clocks = {clock};
  clock.method = "motion in the film";
  clock.offset_high_us = 30'000;
  picture.labels.video_clock = clock;
  picture.labels.flags = {
      {.interval_index = 1, .reason = "events and video differ by 21 ms; expected at most 20", .confirmed = false},
      {.interval_index = {}, .reason = "the robot log has a gap", .confirmed = true}};
  picture.traces = {
      trace_of(TraceKind::tcp_speed, "speed", 8, [](double ms) { return ms > 2'000 && ms < 2'500 ? 200.0 : 0.0; }),
      trace_of(TraceKind::tcp_height, "height", 8, lifted),
      trace_of(TraceKind::stage_output, "digital output 0", 8, [](double ms) { return ms > 700 ? 1.0 : 0.0; }),
      trace_of(TraceKind::stage_output, "output_int_register_4", 8, [](double ms) { return ms > 3'000 ? 7.0 : -2.0; }),
      trace_of(TraceKind::acceleration, "x", 1.25, [](double ms) { return 0.01 * std::sin(ms); }),
      trace_of(TraceKind::acceleration, "y", 1.25, [](double ms) { return ms > 2'000 && ms < 2'080 ? 0.2 : 0.0; }),
      trace_of(TraceKind::video_energy, "energy", 33, [](double ms) { return ms > 2'000 && ms < 2'500 ? 3.0 : 0.1; })};
  return picture;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

bool says(const LabelPicture& picture, const std::string& words) {
  return label_plot(picture).script.find(words) != std::string::npos;
}

TEST(LabelPicture, HasAPanelForEachSourceAndAnEnlargedOnsetForEachInterval) {
  const Plot plot = label_plot(whole_picture());
  EXPECT_EQ(plot.width_px, 1600);
  // Events, robot, outputs, IMU, film; two onsets.
  EXPECT_EQ(count_of(plot.script, "\nplot "), 7U);
  EXPECT_EQ(plot.script.find("Not shown"), std::string::npos);
}

TEST(LabelPicture, IsDrawnWithTheColoursOfItsIntervals) {
  const test::TemporaryFolder folder;
  draw_label_picture(whole_picture(), folder / "labels.png");
  const cv::Mat picture = cv::imread((folder / "labels.png").string());
  ASSERT_EQ(picture.cols, 1600);
  int press = 0, slip = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      press += pixel == cv::Vec3b(0xF8, 0xE8, 0xDC) ? 1 : 0;
      slip += pixel == cv::Vec3b(0xD6, 0xE6, 0xFC) ? 1 : 0;
    }
  }
  // 200 and 500 of 4000 ms, over five panels of some 700 pixels together.
  EXPECT_GT(press, 20'000);
  EXPECT_GT(slip, 50'000);
  draw_label_picture(whole_picture(), folder / "again.png");
  EXPECT_EQ(read_text(folder / "again.png"), read_text(folder / "labels.png"));
}

TEST(LabelPicture, NamesWhatItLeavesOut) {
  LabelPicture picture = whole_picture();
  picture.traces.clear();
  EXPECT_TRUE(says(picture, "clock is not fitted: robot, stage output, IMU, video."));
  EXPECT_EQ(count_of(label_plot(picture).script, "\nplot "), 3U);
  picture.traces = {trace_of(TraceKind::acceleration, "x", 1, [](double) { return 0.0; })};
  EXPECT_TRUE(says(picture, "clock is not fitted: robot, stage output, video."));
}

TEST(LabelPicture, ShowsFlagsClocksAndTheTimesOfSources) {
  const LabelPicture picture = whole_picture();
  EXPECT_TRUE(says(picture, "Flagged: slip-1: events and video differ by 21 ms; expected at most 20"));
  EXPECT_TRUE(says(picture, "Flag lifted by a person: the robot log has a gap"));
  EXPECT_TRUE(says(picture, "Robot clock: IMU against the arm’s acceleration; offset −5.0 to +6.0 ms (95 %)"));
  EXPECT_TRUE(says(picture, "slip-1 at 2.0000 s, 95 %: −0.8 to +0.4 ms, flagged"));
  EXPECT_TRUE(says(picture, "press-1 at 1.0000 s, 95 %: −0.8 to +0.4 ms'"));
  EXPECT_TRUE(says(picture, "lift start −4.0 ms"));
  EXPECT_TRUE(says(picture, "video +21.0 ms"));
  EXPECT_TRUE(says(picture, "IMU −1.0 ms"));
  EXPECT_TRUE(says(picture, "← command −300.0 ms")) << "beyond the enlarged onset's edge";
  EXPECT_FALSE(says(picture, "Nothing is flagged"));
}

TEST(LabelPicture, WrapsAndCutsWhatIsLong) {
  LabelPicture picture = whole_picture();
  const int height = label_plot(picture).height_px;
  std::string reason;
  for (int i = 0; i < 100; ++i) reason += "sentence ";
  picture.labels.flags[0].reason = reason + std::string(1'000, 'x') + std::string(600, '\'');
  EXPECT_GT(label_plot(picture).height_px, height + 100);
  picture.labels.flags.assign(1'000, picture.labels.flags[1]);
  EXPECT_LT(label_plot(picture).height_px, height + 1'000);
  EXPECT_TRUE(says(picture, "more lines, as labels.json has them"));
  const test::TemporaryFolder folder;
  draw_label_picture(picture, folder / "labels.png");
}

TEST(LabelPicture, WritesTimesAsItsAxisDoes) {
  LabelPicture picture = whole_picture();
  picture.remarks = {"the press at 1700000001000000 us: its end is doubtful",
                     "a gap of 21000 us from 1.2 s after its first event on (1700000001200000 us)"};
  picture.labels.flags[0].reason = "something at 1700000002500100 us and at -5 us";
  EXPECT_TRUE(says(picture, "the press at 1.0000 s: its end is doubtful"));
  EXPECT_TRUE(says(picture, "a gap of 21000 us from 1.2 s after its first event on (1.2000 s)"));
  EXPECT_TRUE(says(picture, "something at 2.5001 s and at -1700000000.0000 s"));
}

/// The values of the table that the plot with this tick name draws, by x.
std::vector<std::pair<double, double>> table_drawn_in(const Plot& plot, const std::string& panel) {
  const std::size_t at = plot.script.find("plot $", plot.script.find(panel));
  const std::string name = plot.script.substr(at + 6, plot.script.find(' ', at + 6) - at - 6);
  std::vector<std::pair<double, double>> rows;
  for (const PlotTable& table : plot.tables) {
    for (std::size_t i = 0; table.name == name && i < table.values.size(); i += 2)
      rows.emplace_back(table.values[i], table.values[i + 1]);
  }
  return rows;
}

TEST(LabelPicture, EndsAnOutputWhereItsLogEnds) {
  LabelPicture picture = whole_picture();
  picture.traces = {{.kind = TraceKind::stage_output,
                     .name = "digital output 0",
                     .t = {label_at_ms(0), label_at_ms(700), label_at_ms(2'500)},
                     .values = {0, 1, 1}}};
  const auto rows = table_drawn_in(label_plot(picture), "set ytics ('output 0'");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_NEAR(rows.back().first, 2.5, 1e-9);
}

TEST(LabelPicture, HasOneRowForAnOutputWhoseLogIsInPieces) {
  LabelPicture picture = whole_picture();
  picture.traces.clear();
  const int height = label_plot(picture).height_px;
  picture.traces = {{.kind = TraceKind::stage_output, .name = "out", .t = {label_at_ms(0), label_at_ms(700)}, .values = {0, 1}}};
  const int with_one = label_plot(picture).height_px;
  picture.traces.push_back(
      {.kind = TraceKind::stage_output, .name = "out", .t = {label_at_ms(2'000), label_at_ms(2'700)}, .values = {1, 0}});
  EXPECT_EQ(label_plot(picture).height_px, with_one);
  EXPECT_EQ(count_of(label_plot(picture).script, "with steps"), 2U);
  EXPECT_TRUE(says(picture, "set yrange [0:1]\nset ytics ('out' 0.5)"));
  picture.traces.back().name = "other";
  EXPECT_TRUE(says(picture, "set yrange [0:2]\nset ytics ('out' 1.5, 'other' 0.5)"));
  EXPECT_GE(with_one, height);
}

TEST(LabelPicture, WritesWordsWhereNoLineCrossesThem) {
  LabelPicture picture = whole_picture();
  const std::string script = label_plot(picture).script;
  EXPECT_NE(script.find("set style textbox opaque"), std::string::npos);
  EXPECT_EQ(count_of(script, "front boxed textcolor"), 5U) << "what sources say of two onsets";
  // A word 33 ms wide and more that stands 30 ms before the onset does not reach over the left edge.
  picture.labels.intervals[1].evidence.robot = label_at_ms(1'970);
  EXPECT_TRUE(says(picture, "set label 'lift start −30.0 ms' at first -28.8,")) << "to the right of its line";
  picture.labels.intervals[1].evidence.robot = label_at_ms(1'990);
  EXPECT_TRUE(says(picture, "set label 'lift start −10.0 ms' at first -11.2,")) << "to the left of its line";
}

TEST(LabelPicture, EnlargesFourOnsetsWithTheSlipsAndReportsIt) {
  LabelPicture picture = whole_picture();
  picture.labels.intervals.clear();
  for (int i = 0; i < 9; ++i)
    picture.labels.intervals.push_back(touch(Touch::press, "press-" + std::to_string(i + 1), 100 + 30 * i, 120 + 30 * i));
  picture.labels.intervals.push_back(touch(Touch::slip, "slip-1", 2'000, 2'500));
  picture.labels.flags = {{.interval_index = 7, .reason = "weak", .confirmed = false}};
  EXPECT_EQ(count_of(label_plot(picture).script, "\nplot "), 5U + 4U);
  EXPECT_TRUE(says(picture, "6 onsets are not shown enlarged"));
  for (const char* shown : {"press-1 at", "press-2 at", "press-8 at", "slip-1 at"}) EXPECT_TRUE(says(picture, shown)) << shown;
  EXPECT_FALSE(says(picture, "press-3 at"));
  const test::TemporaryFolder folder;
  draw_label_picture(picture, folder / "labels.png");
}

TEST(LabelPicture, IsDrawnOfRunsThatLackAlmostEverything) {
  const test::TemporaryFolder folder;
  LabelPicture picture;
  picture.title = "one event, at the end of time";
  picture.begin = picture.end = CameraTime::max();
  picture.rate = {
      .begin = CameraTime::max(), .bin = microseconds(200), .counts = {1}, .hot_pixels = 0, .last = CameraTime::max(), .hot = {}};
  draw_label_picture(picture, folder / "one.png");
  picture.rate.counts.assign(3, 0);
  picture.begin = picture.rate.begin = CameraTime::min();
  picture.end = after(CameraTime::min(), 600us);
  draw_label_picture(picture, folder / "none.png");
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto nothing = [](double) { return std::numeric_limits<double>::quiet_NaN(); };
  picture = whole_picture();
  picture.traces = {trace_of(TraceKind::tcp_speed, "", 8, nothing), trace_of(TraceKind::stage_output, "x", 8, nothing),
                    trace_of(TraceKind::acceleration, "", 8, nothing), trace_of(TraceKind::video_energy, "", 8, nothing)};
  picture.traces.push_back({.kind = TraceKind::tcp_height, .name = "", .t = {label_at_ms(9'000)}, .values = {none}});
  draw_label_picture(picture, folder / "gaps.png");
  EXPECT_TRUE(says(whole_picture(), "set multiplot"));
  EXPECT_EQ(cv::imread((folder / "gaps.png").string()).cols, 1600);
}

}  // namespace
}  // namespace tactile::pictures
