#include "tactile/alignment/motion_energy.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "tactile/alignment/frame_differences.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/video/film_reader.hpp"
#include "tactile/video/shown_times.hpp"

namespace tactile::alignment {
namespace {

constexpr double least_threshold = 1.0;  // [grey levels] coders change still pixels by less
constexpr double threshold_per_noise = 1.25;
constexpr microseconds longest_repeat = 150ms;  // a film that repeats a frame for longer has stopped

/// The region in a picture scaled down; the whole of it where there is none.
cv::Rect scaled_region(const std::optional<cv::Rect>& region, cv::Size frame, cv::Size picture, const std::string& file) {
  if (!region) return {{}, picture};
  const std::int64_t left = region->x, top = region->y, right = left + region->width, bottom = top + region->height;
  if (left < 0 || top < 0 || left >= right || top >= bottom || right > frame.width || bottom > frame.height) {
    throw OutsideFilm(fmt::format("{}: the region {},{} {} x {} px is not inside its frames; expected a part of {} x {} px", file,
                                  region->x, region->y, region->width, region->height, frame.width, frame.height));
  }
  const auto scaled = [](std::int64_t at, int from, int to, bool up) {
    return static_cast<int>((at * to + (up ? from - 1 : 0)) / from);
  };
  const cv::Point begin(scaled(left, frame.width, picture.width, false), scaled(top, frame.height, picture.height, false));
  const cv::Point end(scaled(right, frame.width, picture.width, true), scaled(bottom, frame.height, picture.height, true));
  return {begin, end};
}

/// A decoded frame and its difference from the one before it.
struct FilmFrame {
  std::size_t index = 0;           ///< in the order they are shown; in the file's order where it has no times
  std::optional<std::int64_t> us;  ///< by the container
  bool compared = false;           ///< false for the first of its size
  FrameDifference difference;
  bool key = false;  ///< coded by itself
};

struct ReadFrames {
  std::vector<FilmFrame> frames;
  std::size_t in_file = 0;                    ///< decodable or not
  std::vector<std::int64_t> container_times;  ///< of those in the file, ascending; empty if one has none
  double region_pixels = 1;
};

std::vector<std::optional<std::int64_t>> times_by_container(const std::vector<FilmFrame>& frames) {
  std::vector<std::optional<std::int64_t>> times;
  times.reserve(frames.size());
  for (const FilmFrame& frame : frames) times.push_back(frame.us);
  return times;
}

ReadFrames read_frames(video::FilmReader& film, const MotionEnergyOptions& options, const std::function<void()>& advance) {
  ReadFrames read;
  FrameComparison comparison;
  cv::Mat1f before;
  while (const std::optional<video::FilmReader::Frame> frame = film.next()) {
    if (advance) advance();
    cv::Mat grey;
    if (!film.grey(options.width, grey)) continue;
    const cv::Mat1f now = smoothed(grey);
    const cv::Rect region = scaled_region(options.region, frame->size, now.size(), film.file());
    read.region_pixels = static_cast<double>(region.width) * region.height;
    FilmFrame& added = read.frames.emplace_back();
    added.index = read.frames.size() - 1;
    added.us = frame->us;
    added.key = frame->is_key;
    added.compared = before.size() == now.size();
    if (added.compared) added.difference = comparison.compare(before, now, region);
    before = now;
  }
  read.in_file = film.frames();
  read.container_times = film.frame_times();
  const std::vector<std::size_t> indices = video::frame_indices(times_by_container(read.frames), read.container_times);
  for (std::size_t i = 0; i < indices.size(); ++i) read.frames[i].index = indices[i];
  return read;
}

/// The index of the threshold for the film's noise. Steps to a key frame have a noise of their own, and may be all there are.
std::size_t threshold_level(const std::vector<FilmFrame>& frames) {
  std::vector<double> noises, key_noises;
  for (const FilmFrame& frame : frames) {
    if (frame.compared && !frame.difference.same) (frame.key ? key_noises : noises).push_back(frame.difference.noise);
  }
  const auto lower_quartile = [](const std::vector<double>& values) {
    return values.empty() ? 0.0 : value_of_rank(values, (values.size() - 1) / 4);
  };
  const double noise = std::max(lower_quartile(noises), lower_quartile(key_noises));
  const double wanted = std::max(least_threshold, threshold_per_noise * noise);
  std::size_t level = 0;
  while (level + 1 < threshold_count && threshold_at(level) < wanted) ++level;
  return level;
}

/// The highest threshold above which a tenth of the change lies.
double strongest_of(const FrameDifference& difference, std::size_t level) {
  constexpr float share = 0.1F;
  std::size_t i = level;
  while (i + 1 < threshold_count && difference.above[i + 1] > share * difference.above[level]) ++i;
  return difference.above[level] > 0 ? threshold_at(i) : 0.0;
}

struct QuietSteps {
  double median = 0, deviation = 0;
};

/// Of the lower values, however many high ones there are.
QuietSteps quiet_steps(const std::vector<double>& values) {
  constexpr int rounds = 8;
  constexpr double outlier = 4;
  QuietSteps quiet;
  double limit = lower_median(values);
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> lower;
    std::copy_if(values.begin(), values.end(), std::back_inserter(lower), [&](double value) { return value <= limit; });
    quiet.median = lower_median(lower);
    quiet.deviation = sigma_per_median * lower_median(distances_from(quiet.median, lower));
    limit = quiet.median + outlier * quiet.deviation;
  }
  return quiet;
}

/// The change of a film's quiet steps.
struct NoiseFloor {
  double of_step = 0, of_key_step = 0;  ///< taken off each step
  double deviation = 0;
};

NoiseFloor noise_floor(const std::vector<FilmFrame>& frames, std::size_t level) {
  std::vector<double> changes, key_changes;
  for (const FilmFrame& frame : frames) {
    if (frame.compared) (frame.key ? key_changes : changes).push_back(frame.difference.above[level]);
  }
  if (changes.empty()) changes.swap(key_changes);
  const QuietSteps quiet = quiet_steps(changes);
  NoiseFloor floor{.of_step = quiet.median, .of_key_step = quiet.median, .deviation = quiet.deviation};
  // The change by a key frame itself is taken off with its tail: it is no noise of the other steps.
  constexpr std::size_t enough = 3;
  constexpr double tail = 4;
  if (key_changes.size() >= enough) {
    const QuietSteps of_key = quiet_steps(key_changes);
    floor.of_key_step = std::max(floor.of_key_step, of_key.median + tail * of_key.deviation);
  }
  return floor;
}

/// Which frames only repeat the one before, as in a film made to a constant rate. They interrupt motion. Where nothing moves,
/// coders repeat frames too, and that is no gap.
std::vector<bool> duplicates_among(const std::vector<FilmFrame>& frames, std::size_t level, double moving) {
  std::vector<bool> duplicates(frames.size(), false);
  const auto same = [&](std::size_t i) { return frames[i].compared && frames[i].difference.same; };
  const auto moves = [&](std::size_t i) { return frames[i].compared && frames[i].difference.above[level] > moving; };
  const auto drop = [&](std::size_t begin, std::size_t end) {
    std::fill(duplicates.begin() + static_cast<std::ptrdiff_t>(begin), duplicates.begin() + static_cast<std::ptrdiff_t>(end),
              true);
  };
  std::vector<double> repeats;                               // amid motion
  std::vector<std::pair<std::size_t, std::size_t>> leading;  // repeats before motion: part of them may be the film's own
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (!same(i)) continue;
    const std::size_t begin = i;
    while (i < frames.size() && same(i)) ++i;
    if (i == frames.size() || !moves(i)) continue;
    const auto from = frames[begin - 1].us, to = frames[i - 1].us;
    if (moves(begin - 1) && from && to && *to - *from <= longest_repeat.count()) {
      drop(begin, i);
      repeats.push_back(static_cast<double>(i - begin));
    } else {
      leading.emplace_back(begin, i);
    }
  }
  constexpr std::size_t enough = 3;
  if (repeats.size() >= enough) {
    const auto usual = static_cast<std::size_t>(lower_median(repeats));
    for (const auto& [begin, end] : leading) drop(end - std::min(usual, end - begin), end);
  }
  return duplicates;
}

/// Counts what film and rows lack of each other.
void count_frames(MotionEnergy& energy, const ReadFrames& read, std::size_t rows) {
  energy.frames = read.frames.size();
  energy.undecodable = read.in_file - std::min(read.in_file, read.frames.size());
  for (std::size_t i = 1; i < read.frames.size(); ++i) energy.exposure_steps += read.frames[i].difference.brightness ? 1 : 0;
  if (rows == 0) return;
  energy.rows_without_frame = rows - std::min(rows, read.in_file);
  energy.frames_without_row = static_cast<std::size_t>(
      std::count_if(read.frames.begin(), read.frames.end(), [&](const FilmFrame& frame) { return frame.index >= rows; }));
}

/// Adds the steps from frame to frame. A step over frames that are dropped has their changes too.
void add_steps(MotionEnergy& energy, const ReadFrames& read, std::span<const VideoTime> rows, std::size_t level,
               const NoiseFloor& floor, const video::FilmReader& film) {
  constexpr double beyond_noise = 10;
  const std::vector<bool> duplicates = duplicates_among(read.frames, level, floor.of_step + beyond_noise * energy.noise);
  const std::vector<std::optional<VideoTime>> times =
      video::shown_times(times_by_container(read.frames), read.container_times, rows);
  std::optional<VideoTime> last;
  double change = 0, strongest = 0;
  bool joined = true, doubtful = false;
  std::vector<double> lengths;
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    const FilmFrame& frame = read.frames[i];
    change += std::max(0.0, frame.difference.above[level] - (frame.key ? floor.of_key_step : floor.of_step));
    strongest = std::max(strongest, strongest_of(frame.difference, level));
    joined = joined && frame.compared;
    doubtful = doubtful || frame.difference.brightness;
    if (duplicates[i]) {
      ++energy.duplicates;
      continue;
    }
    if (!times[i] || (last && *times[i] <= *last)) {
      ++energy.without_time;
      continue;
    }
    if (last) {
      const microseconds length = *times[i] - *last;
      if (length > video::FilmReader::longest) film.refuse_length();
      if (joined)
        energy.steps.push_back({*last, *times[i], 1e6 * change / static_cast<double>(length.count()), strongest, doubtful});
      lengths.push_back(static_cast<double>(length.count()));
      if (length > energy.longest_gap) {
        energy.longest_gap = length;
        energy.gap_begin = *last;
      }
    }
    last = times[i];
    change = strongest = 0;
    joined = true;
    doubtful = false;
  }
  energy.median_step = microseconds{std::llround(lower_median(lengths))};
}

}  // namespace

MotionEnergy motion_energy(const std::filesystem::path& path, std::span<const VideoTime> rows, const MotionEnergyOptions& options,
                           const std::function<void()>& advance) {
  if (options.width < 1) throw Error(fmt::format("{}: a width of {} px; expected more than 0", path.string(), options.width));
  video::FilmReader film(path);
  if (!rows.empty() && saturating_subtract(us_of(rows.back()), us_of(rows.front())) > video::FilmReader::longest.count())
    film.refuse_length();
  const ReadFrames read = read_frames(film, options, advance);
  MotionEnergy energy;
  count_frames(energy, read, rows.size());
  const std::size_t level = threshold_level(read.frames);
  energy.threshold = threshold_at(level);
  const NoiseFloor floor = noise_floor(read.frames, level);
  constexpr double least_pixels = 5;  // fewer moving pixels cannot be distinguished from noise
  energy.noise = std::max(floor.deviation, least_pixels * energy.threshold / read.region_pixels);
  add_steps(energy, read, rows, level, floor, film);
  return energy;
}

}  // namespace tactile::alignment
