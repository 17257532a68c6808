#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/time.hpp"

namespace tactile::alignment {

struct MotionEnergyOptions {
  int width = 320;                      ///< [px] wider films are scaled down to this width, > 0
  std::optional<cv::Rect> region = {};  ///< in the film's own pixels: only motion there counts; nothing: the whole picture
};

/// The region is not inside the film's frames.
class OutsideFilm : public Error {
 public:
  using Error::Error;
};

/// From one frame to the next different one.
struct MotionStep {
  VideoTime begin{}, end{};  ///< the two frames' times, begin < end
  double energy = 0;         ///< mean change of the pixels by motion, per time, above the film's own noise [grey levels/s], >= 0
  double strongest = 0;      ///< a tenth of it comes from pixels that changed by more than this [grey levels]
  bool doubtful = false;     ///< the exposure changed, which may leave a little energy: no sign of motion by itself

  VideoTime middle() const { return begin + (end - begin) / 2; }  ///< what `energy` is stamped with
};

/// The motion in a film, and properties of the film.
struct MotionEnergy {
  std::vector<MotionStep> steps;   ///< by time; where frames are missing a step is longer
  double noise = 0;                ///< standard deviation of `energy * (end - begin)` where nothing moves [grey levels], > 0
  double threshold = 0;            ///< a pixel that changes by less than this has not moved [grey levels]
  std::size_t frames = 0;          ///< decoded
  std::size_t undecodable = 0;     ///< frames in the file that cannot be decoded
  std::size_t duplicates = 0;      ///< frames equal to the one before, amid motion, dropped: the film was made to a constant rate
  std::size_t without_time = 0;    ///< frames whose time is missing or does not ascend, dropped
  std::size_t exposure_steps = 0;  ///< frames whose brightness differs by more than a hundredth from the one before
  std::size_t rows_without_frame = 0;  ///< given times whose frames the file lacks
  std::size_t frames_without_row = 0;  ///< decoded frames without a given time: they follow the container's own
  microseconds median_step{0};         ///< from frame to frame
  microseconds longest_gap{0};         ///< from frame to frame
  std::optional<VideoTime> gap_begin;  ///< where that begins; nothing with fewer than two frames

  VideoTime begin() const { return steps.empty() ? VideoTime{} : steps.front().begin; }
  VideoTime end() const { return steps.empty() ? VideoTime{} : steps.back().end; }
};

/// The motion in a film from each frame to the next. With I_k the grey frame k, scaled down and smoothed (binomial, 5 x 5), and
/// a I + b the brightness that fits best from frame to frame (the camera may change its exposure; moving pixels are left out of
/// the fit),
///
///   s_k = mean over pixels of |d_k| where |d_k| > T, else 0,   d_k = I_k - (a I_(k-1) + b),
///   energy_k = max(0, s_k - floor) / (t_k - t_(k-1))
///
/// T is 1.25 times the noise of a quiet step, or of a quiet step to a key frame if that is greater. A step's noise is the median
/// over up to 8 x 8 parts of the picture of the largest change in each: noise and coding change every part a little, motion
/// changes a few of them much. `floor` is the median of s over quiet steps. For motions of less than an object's size, s is
/// proportional to the displacement. One thread decodes all frames in order; memory is 150 B per frame.
///
/// @param film   any file that `FilmReader` reads
/// @param times  of the film's frames, by `video.csv`: they are the video's clock, and the frame of row i is the file's i-th,
///               whether or not it can be decoded. If there are fewer rows than frames the last frames follow the container's own
///               times, shifted. Empty: the container's own times, the first decoded frame being at 0
/// @param advance  called before each frame; may throw to end the reading
/// @return       no steps if fewer than two frames can be decoded
/// @throws Error if the file holds no video, its frames are larger than 8192 x 4320 px, there are more than a million of them,
///               they lie more than an hour apart
/// @throws OutsideFilm if the region is not inside the picture
/// Source: frame differencing; times as FFmpeg's demuxers give them.
MotionEnergy motion_energy(const std::filesystem::path& film, std::span<const VideoTime> times = {},
                           const MotionEnergyOptions& options = {}, const std::function<void()>& advance = {});

}  // namespace tactile::alignment
