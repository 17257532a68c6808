#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "tactile/core/time.hpp"

namespace tactile::video {

struct VideoWriterOptions {
  int width = 320;               ///< [px], even, > 0
  int height = 240;              ///< [px], even, > 0
  int quality = 28;              ///< constant rate factor of H.264: 0 loses nothing, 51 the most
  int frames_per_fragment = 30;  ///< a fragment begins with a key frame; it is in the file once the next has begun; > 0
  bool fast = false;             ///< in a third of the time; `quality` is then the quantiser of every frame
  microseconds fragment_span{
      0};  ///< a frame this long after a fragment's first begins the next; 0: by `frames_per_fragment` only, >= 0
};

/// Writes H.264 in fragmented MP4 with every frame's own time, in microseconds, at any frame rate: a reader of the file gets
/// these times back. Whole fragments survive a kill. With a `fragment_span`, the frame that begins a fragment puts the fragment
/// before it into the file, so that a kill loses no more than the span and a frame. Encodes in the calling thread, so the same
/// frames always give the same bytes.
class VideoWriter {
 public:
  /// @throws Error  if the options are out of range, the file cannot be made, or libavcodec has no encoder for H.264
  VideoWriter(const std::filesystem::path& file, const VideoWriterOptions& options);
  ~VideoWriter();  ///< closes; only `close` reports a failure
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  /// @param frame  [height, width] 8-bit grey or BGR
  /// @param t      0 for the first frame (players take its time for zero), ascending after it
  /// @throws Error if the frame has another shape or type, its time does not ascend, or it cannot be written
  void write(const cv::Mat& frame, VideoTime t);

  void close();  ///< encodes the waiting frames and ends the file. @throws Error if it cannot be written

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::video
