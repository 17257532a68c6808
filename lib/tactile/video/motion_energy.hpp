#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/time.hpp"

namespace tactile {

struct MotionEnergyOptions {
  int width = 320;                      ///< [px] wider films are looked at in this width, > 0
  std::optional<cv::Rect> region = {};  ///< of the film's own pixels: only what moves there counts; nothing: the whole picture
};

/// A region was asked for that the film's frames do not hold.
class OutsideFilm : public Error {
 public:
  using Error::Error;
};

/// From one frame to the next that differs from it.
struct MotionStep {
  VideoTime begin{}, end{};  ///< the two frames' times, begin < end
  double energy = 0;         ///< mean change of the pixels by motion, per time, above the film's own noise [grey levels/s], >= 0
  double strongest = 0;      ///< the pixels that changed by more than this make a tenth of it [grey levels]
  bool doubtful = false;  ///< the camera set its exposure anew, of which a little energy may be left: no sign of motion by itself

  VideoTime middle() const { return begin + (end - begin) / 2; }  ///< what `energy` is stamped with
};

/// How much moves in a film, and what the film is like.
struct MotionEnergy {
  std::vector<MotionStep> steps;  ///< by time; where frames are missing a step is longer
  double noise = 0;               ///< standard deviation of `energy * (end - begin)` where nothing moves [grey levels], > 0
  double threshold = 0;           ///< a pixel that changes by less than this has not moved [grey levels]
  std::size_t frames = 0;         ///< decoded
  std::size_t undecodable = 0;    ///< frames in the file that cannot be decoded
  std::size_t duplicates = 0;     ///< frames like the one before amid motion, dropped: of a film that was made to a constant rate
  std::size_t without_time = 0;   ///< frames whose time is missing or does not ascend, dropped
  std::size_t exposure_steps = 0;      ///< frames with another brightness than the one before, by more than a hundredth
  std::size_t rows_without_frame = 0;  ///< times given whose frames the file lacks
  std::size_t frames_without_row = 0;  ///< decoded frames for which no time was given: they follow the container's own
  microseconds median_step{0};         ///< from frame to frame
  microseconds longest_gap{0};         ///< likewise
  std::optional<VideoTime> gap_begin;  ///< where that begins; nothing with less than two frames

  VideoTime begin() const { return steps.empty() ? VideoTime{} : steps.front().begin; }
  VideoTime end() const { return steps.empty() ? VideoTime{} : steps.back().end; }
};

/// How much moves in a film from each frame to the next. With I_k the grey frame k, scaled down and smoothed (Gaussian, 5 x 5),
/// and a I + b the brightness that fits best from frame to frame (the camera sets its exposure anew; what moves is left out of
/// the fit),
///
///   s_k = mean over pixels of |d_k| where |d_k| > T, else 0,   d_k = I_k - (a I_(k-1) + b),
///   energy_k = max(0, s_k - floor) / (t_k - t_(k-1))
///
/// T is 1.25 times a quiet step's noise, a step to a key frame being taken if that is louder. A step's noise is the median over
/// up to 8 x 8 parts of the picture of the largest change in each: noise and coding change every part a little, what moves
/// changes a few of them much. `floor` is the median of s over quiet steps. For motions of less than an object's size s is
/// proportional to the way that it has gone. One thread, all frames in their order; memory follows the frames' count, 150 B for
/// each.
///
/// @param film   any file that libavformat reads: MP4, MKV, AVI, of any rate
/// @param times  of the film's frames, by `video.csv`: they are the video's clock, and the frame of row i is the file's i-th,
///               whether or not it can be decoded. If there are fewer rows than frames the last frames follow the container's own
///               times, shifted. Empty: the container's own times, the first decoded frame being at 0
/// @return       no steps if fewer than two frames can be decoded
/// @throws Error if the file holds no video, its frames are larger than 8192 x 4320 px, there are more than a million of them,
///               they lie more than an hour apart, of an OutsideFilm if the region is not inside the picture
///
/// Source: frame differencing; times as FFmpeg's demuxers give them.
MotionEnergy motion_energy(const std::filesystem::path& film, std::span<const VideoTime> times = {},
                           const MotionEnergyOptions& options = {});

}  // namespace tactile
