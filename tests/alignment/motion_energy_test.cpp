#include "tactile/alignment/motion_energy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/video/video_writer.hpp"
#include "video/made_film.hpp"

namespace tactile::alignment {
namespace {

using test::error_of;
using test::TemporaryFolder;

const cv::Size frame_size{160, 120};
constexpr int box = 40;  // [px] each way
constexpr double dark = 60, bright = 160;

struct Scene {
  std::function<double(double)> column = [](double) { return 30.0; };   ///< the box's left edge at a time [s]
  std::function<double(double)> exposure = [](double) { return 1.0; };  ///< factor on all grey levels
  double noise = 1.5;                                                   ///< standard deviation of a pixel
};

/// Cheap: some of a few thousand normal values.
class Noise {
 public:
  Noise() {
    Random random(5);
    for (double& value : values_) value = random.normal();
  }
  double next() {
    word_ = word_ * 6364136223846793005U + 1442695040888963407U;
    return values_[word_ >> 52U];
  }

 private:
  std::array<double, 4096> values_{};
  std::uint64_t word_ = 1;
};

/// A bright box on dark ground, its sides between pixels where they are.
cv::Mat picture(const Scene& scene, double t_s, Noise& noise) {
  const double left = scene.column(t_s), gain = scene.exposure(t_s);
  cv::Mat frame(frame_size, CV_8UC1);
  for (int y = 0; y < frame_size.height; ++y) {
    for (int x = 0; x < frame_size.width; ++x) {
      const double covered =
          y < 40 || y >= 40 + box ? 0.0 : std::clamp(std::min(x + 1.0, left + box) - std::max<double>(x, left), 0.0, 1.0);
      const double grey = gain * (dark + covered * (bright - dark)) + scene.noise * noise.next();
      frame.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(grey);
    }
  }
  return frame;
}

void film(const std::filesystem::path& file, const Scene& scene, std::span<const VideoTime> times) {
  Noise noise;
  video::VideoWriter writer(file, {.width = frame_size.width, .height = frame_size.height, .quality = 18});
  for (const VideoTime t : times) writer.write(picture(scene, 1e-6 * static_cast<double>(us_of(t)), noise), t);
  writer.close();
}

/// Still until 1 s, then 60 px/s to the right until 1.5 s.
double moved_column(double t_s) { return 30 + 60 * std::clamp(t_s - 1.0, 0.0, 0.5); }

// Both sides of the box sweep over `box` pixels each.
constexpr double energy_at_speed = 2.0 * box * 60.0 * (bright - dark) * 219.0 / 255.0 / (160.0 * 120.0);

double largest_between(const MotionEnergy& energy, double from_s, double to_s) {
  double largest = 0;
  for (const MotionStep& step : energy.steps) {
    if (1e-6 * static_cast<double>(us_of(step.begin)) >= from_s && 1e-6 * static_cast<double>(us_of(step.end)) <= to_s)
      largest = std::max(largest, step.energy);
  }
  return largest;
}

TEST(MotionEnergy, IsTheSpeedOfWhatMovesAtItsTrueTimes) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> times = test::uneven_times(75, 33'333us);
  film(folder / "video.mp4", {.column = moved_column}, times);
  const MotionEnergy energy = motion_energy(folder / "video.mp4", times);

  EXPECT_EQ(energy.frames, times.size());
  ASSERT_EQ(energy.steps.size(), times.size() - 1);
  double sum = 0, weighted = 0;
  for (std::size_t i = 0; i < energy.steps.size(); ++i) {
    const MotionStep& step = energy.steps[i];
    EXPECT_EQ(step.begin, times[i]);
    EXPECT_EQ(step.end, times[i + 1]);
    const double begin_s = 1e-6 * static_cast<double>(us_of(step.begin)), end_s = 1e-6 * static_cast<double>(us_of(step.end));
    if (begin_s >= 1.0 && end_s <= 1.5) {
      EXPECT_NEAR(step.energy, energy_at_speed, 0.2 * energy_at_speed) << begin_s;
    }
    if (end_s <= 1.0 || begin_s >= 1.5) {
      EXPECT_LT(step.energy, 0.02 * energy_at_speed) << begin_s;
    }
    sum += step.energy * (end_s - begin_s);
    weighted += step.energy * (end_s - begin_s) * 1e-6 * static_cast<double>(us_of(step.middle()));
  }
  EXPECT_NEAR(weighted / sum, 1.25, 0.004);
  EXPECT_EQ(energy.undecodable + energy.duplicates + energy.without_time + energy.exposure_steps, 0U);
}

TEST(MotionEnergy, DoesNotDependOnTheFrameRate) {
  const TemporaryFolder folder;
  std::vector<VideoTime> times;
  for (microseconds t = 0us; t < 1500ms; t += 16'667us) times.emplace_back(t);
  for (microseconds t = 1500ms; t < 4500ms; t += 70ms) times.emplace_back(t);
  film(folder / "video.mp4", {.column = [](double t) { return 10 + 60 * std::clamp(t - 1.0, 0.0, 1.2); }}, times);
  const MotionEnergy energy = motion_energy(folder / "video.mp4");
  const auto mean = [&](double from_s, double to_s) {
    double sum = 0, n = 0;
    for (const MotionStep& step : energy.steps) {
      if (in_s(step.begin.time_since_epoch()) < from_s || in_s(step.end.time_since_epoch()) > to_s) continue;
      sum += step.energy;
      n += 1;
    }
    return sum / n;
  };
  EXPECT_NEAR(mean(1.05, 1.5) / mean(1.6, 2.15), 1.0, 0.15);
  EXPECT_EQ(energy.longest_gap, 70ms);
}

TEST(MotionEnergy, SeesNothingInAStillFilm) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> times = test::uneven_times(120, 33'333us);
  for (const double noise : {0.0, 1.5, 6.0}) {
    film(folder / "video.mp4", {.noise = noise}, times);
    const MotionEnergy energy = motion_energy(folder / "video.mp4", times);
    EXPECT_EQ(energy.steps.size(), times.size() - 1) << "a film that stands still repeats frames, none of which is a duplicate";
    for (const MotionStep& step : energy.steps)
      EXPECT_LT(step.energy * 1e-6 * static_cast<double>((step.end - step.begin).count()), 10 * energy.noise) << noise;
  }
}

TEST(MotionEnergy, DropsFramesThatOnlyRepeatTheOneBefore) {
  const TemporaryFolder folder;
  std::vector<VideoTime> times;
  for (int i = 0; i < 90; ++i) times.emplace_back(microseconds{i * 33'333});
  // A source of 10 frames a second, each three times.
  const auto of_source = [](double t_s) { return std::floor(t_s * 10 + 0.01) / 10; };
  film(folder / "video.mp4", {.column = [&](double t) { return moved_column(of_source(t)); }, .noise = 0}, times);
  const MotionEnergy energy = motion_energy(folder / "video.mp4", times);
  EXPECT_EQ(energy.duplicates, 10U) << "two before each of the five frames that show motion";
  EXPECT_EQ(energy.frames, 90U);
  EXPECT_NEAR(largest_between(energy, 0.0, 3.0), energy_at_speed, 0.25 * energy_at_speed) << "not three times it";
}

TEST(MotionEnergy, IsNotAffectedByAStepOfTheExposure) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> times = test::uneven_times(75, 33'333us);
  for (const double factor : {0.9, 1.1, 1.4}) {
    film(folder / "video.mp4", {.column = moved_column, .exposure = [&](double t) { return t < 0.6 ? 1.0 : factor; }}, times);
    const MotionEnergy energy = motion_energy(folder / "video.mp4", times);
    EXPECT_EQ(energy.exposure_steps, 1U);
    EXPECT_LT(largest_between(energy, 0.0, 1.0), 0.05 * energy_at_speed) << factor;
    EXPECT_NEAR(largest_between(energy, 1.1, 1.4) / factor, energy_at_speed, 0.25 * energy_at_speed);
    EXPECT_EQ(std::count_if(energy.steps.begin(), energy.steps.end(),
                            [](const MotionStep& step) {
                              return step.doubtful && us_of(step.begin) < 600'000 && us_of(step.end) >= 600'000;
                            }),
              1);
  }
}

TEST(MotionEnergy, UsesTheRegionAlone) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> times = test::uneven_times(75, 33'333us);
  film(folder / "video.mp4", {.column = moved_column}, times);
  const auto seen_in = [&](cv::Rect region) {
    return largest_between(motion_energy(folder / "video.mp4", times, {.region = region}), 0.0, 3.0);
  };
  EXPECT_LT(seen_in({0, 0, 20, 120}), 0.02 * energy_at_speed);
  EXPECT_LT(seen_in({0, 90, 160, 30}), 0.02 * energy_at_speed);
  EXPECT_NEAR(seen_in({0, 40, 160, 40}), 3 * energy_at_speed, 0.6 * energy_at_speed) << "a third of the picture, all that moves";
  for (const auto& [region, name] : {std::pair(cv::Rect{160, 0, 10, 10}, "160,0 10 x 10"),
                                     std::pair(cv::Rect{-1'000'000, 40, 2'000'000'000, 40}, "-1000000,40 2000000000 x 40")}) {
    EXPECT_EQ(error_of([&, &part = region] { seen_in(part); }),
              (folder / "video.mp4").string() + ": the region " + name +
                  " px is not inside its frames; expected a part of 160 x 120 px");
  }
}

TEST(MotionEnergy, ScalesWideFilmsDown) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> times = test::uneven_times(75, 33'333us);
  film(folder / "video.mp4", {.column = moved_column}, times);
  const MotionEnergy small = motion_energy(folder / "video.mp4", times, {.width = 80});
  EXPECT_NEAR(largest_between(small, 1.1, 1.4), energy_at_speed, 0.3 * energy_at_speed);
  EXPECT_LT(largest_between(small, 0.0, 1.0), 0.02 * energy_at_speed);
  EXPECT_THROW(motion_energy(folder / "video.mp4", times, {.width = 0}), Error);
}

TEST(MotionEnergy, TakesTheTimesThatAreGivenForTheFramesInTheirOrder) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> in_file = test::uneven_times(30, 33'333us);
  film(folder / "video.mp4", {}, in_file);
  std::vector<VideoTime> rows;
  for (int i = 0; i < 30; ++i) rows.emplace_back(microseconds{7'000'000 + 40'000 * i});
  const MotionEnergy energy = motion_energy(folder / "video.mp4", rows);
  ASSERT_EQ(energy.steps.size(), 29U);
  EXPECT_EQ(energy.begin(), rows.front());
  EXPECT_EQ(energy.end(), rows.back());
  EXPECT_EQ(energy.median_step, 40ms);
}

TEST(MotionEnergy, FollowsTheFilmWhereRowsAreMissing) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> times = test::uneven_times(40, 33'333us);
  film(folder / "video.mp4", {}, times);
  // The rows are on a clock that began a second earlier.
  std::vector<VideoTime> rows;
  for (int i = 0; i < 25; ++i) rows.push_back(times[static_cast<std::size_t>(i)] + 1s);
  const MotionEnergy energy = motion_energy(folder / "video.mp4", rows);
  EXPECT_EQ(energy.frames_without_row, 15U);
  EXPECT_EQ(energy.rows_without_frame, 0U);
  ASSERT_EQ(energy.steps.size(), 39U);
  EXPECT_EQ(energy.end(), times.back() + 1s);
}

TEST(MotionEnergy, ReportsWhatAFilmLacksThatWasCutOff) {
  const TemporaryFolder folder;
  const std::vector<VideoTime> times = test::uneven_times(150, 33'333us);
  film(folder / "video.mp4", {.column = moved_column}, times);
  const std::string whole = read_text(folder / "video.mp4");
  write_whole(folder / "cut.mp4", whole.substr(0, whole.size() / 2));
  const MotionEnergy energy = motion_energy(folder / "cut.mp4", times);
  EXPECT_GT(energy.frames, 30U);
  EXPECT_LT(energy.frames, 120U);
  EXPECT_EQ(energy.frames + energy.undecodable + energy.rows_without_frame, times.size());
  ASSERT_FALSE(energy.steps.empty());
  EXPECT_EQ(energy.end(), times[energy.frames - 1]);
  EXPECT_GT(largest_between(energy, 0.0, 5.0), 0.5 * energy_at_speed);
}

TEST(MotionEnergy, KeepsTheRowsOfFramesThatCannotBeDecoded) {
  const TemporaryFolder folder;
  const std::string file = folder / "video.avi";
  cv::VideoWriter writer(file, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, frame_size, true);
  ASSERT_TRUE(writer.isOpened());
  Noise noise;
  std::vector<VideoTime> rows;
  for (int i = 0; i < 40; ++i) {
    rows.emplace_back(microseconds{41'000 * i});
    cv::Mat colour;
    cv::cvtColor(picture({.column = moved_column}, 0.04 * i, noise), colour, cv::COLOR_GRAY2BGR);
    writer.write(colour);
  }
  writer.release();
  std::string bytes = read_text(file);
  std::size_t chunk = bytes.find("movi");
  for (int i = 0; i <= 20; ++i) chunk = bytes.find("00dc", chunk + 1);
  ASSERT_NE(chunk, std::string::npos);
  const std::size_t next = bytes.find("00dc", chunk + 1);
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(chunk) + 8, bytes.begin() + static_cast<std::ptrdiff_t>(next), '\0');
  write_whole(folder / "damaged.avi", bytes);

  const MotionEnergy energy = motion_energy(folder / "damaged.avi", rows);
  EXPECT_EQ(energy.undecodable, 1U);
  EXPECT_EQ(energy.frames, 39U);
  EXPECT_EQ(energy.rows_without_frame, 0U);
  ASSERT_EQ(energy.steps.size(), 38U);
  EXPECT_EQ(energy.steps[19].begin, rows[19]);
  EXPECT_EQ(energy.steps[19].end, rows[21]);
  EXPECT_EQ(energy.end(), rows.back());
  EXPECT_EQ(energy.longest_gap, 82ms);
  EXPECT_EQ(energy.gap_begin, rows[19]);
}

TEST(MotionEnergy, ReadsOtherContainers) {
  for (const char* name : {"video.mkv", "video.avi"}) {
    const TemporaryFolder folder;
    cv::VideoWriter writer((folder / name).string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, frame_size,
                           true);
    ASSERT_TRUE(writer.isOpened()) << name;
    Noise noise;
    for (int i = 0; i < 60; ++i) {
      cv::Mat colour;
      cv::cvtColor(picture({.column = moved_column}, 0.04 * i, noise), colour, cv::COLOR_GRAY2BGR);
      writer.write(colour);
    }
    writer.release();
    const MotionEnergy energy = motion_energy(folder / name);
    ASSERT_EQ(energy.steps.size(), 59U) << name;
    EXPECT_EQ(us_of(energy.begin()), 0) << name;
    EXPECT_EQ(us_of(energy.end()), 59 * 40'000) << name;
    EXPECT_LT(largest_between(energy, 0.0, 1.0), 0.03 * energy_at_speed) << name;
    EXPECT_GT(largest_between(energy, 1.0, 1.5), 0.7 * energy_at_speed) << name;
  }
}

TEST(MotionEnergy, GivesNoStepsForLessThanTwoFrames) {
  const TemporaryFolder folder;
  film(folder / "video.mp4", {}, std::vector<VideoTime>{VideoTime{}});
  const MotionEnergy energy = motion_energy(folder / "video.mp4");
  EXPECT_EQ(energy.frames, 1U);
  EXPECT_TRUE(energy.steps.empty());
  EXPECT_GT(energy.noise, 0);
}

TEST(MotionEnergy, RefusesWhatIsNoFilmOfARun) {
  const TemporaryFolder folder;
  const std::string file = folder / "video.mp4";
  EXPECT_EQ(error_of([&] { motion_energy(file); }), file + ": no such file; expected a film");
  write_whole(file, "index,pts_us\n0,0\n");
  EXPECT_EQ(error_of([&] { motion_energy(file); }), file + ": cannot be read; expected a film that libavformat reads");

  write_whole(file, "YUV4MPEG2 W16000 H3000 F30:1 Ip C420\nFRAME\n");
  EXPECT_EQ(error_of([&] { motion_energy(file); }), file + ": frames of 16000 x 3000 px; expected at most 8192 x 4320");

  const std::string too_long = file + ": its frames lie more than 60 min apart; expected the film of a run";
  film(file, {}, std::vector<VideoTime>{VideoTime{0us}, VideoTime{31min}, VideoTime{61min}});
  EXPECT_EQ(error_of([&] { motion_energy(file); }), too_long);
  film(file, {}, std::vector<VideoTime>{VideoTime{0us}, VideoTime{1s}});
  EXPECT_EQ(error_of([&] { motion_energy(file, std::vector<VideoTime>{VideoTime{0us}, VideoTime{2h}}); }), too_long);
  EXPECT_EQ(error_of([&] { motion_energy(file, std::vector<VideoTime>{VideoTime::min(), VideoTime::max()}); }), too_long);
}

}  // namespace
}  // namespace tactile::alignment
