#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tactile/core/clock_pairs.hpp"

namespace cv {
class Mat;
}

namespace tactile::video {

struct VideoCaptureOptions {
  std::string source;      ///< a device's number ("0") or path ("/dev/video0"), a file, or a URL
  double speed = 1;        ///< of a file: 1 by its own times, 0 as fast as it can be encoded, and then no frame is dropped; >= 0
  int quality = 23;        ///< constant rate factor of H.264, 0 to 51
  std::size_t queue = 60;  ///< frames that may wait for the encoder, at most 512 MiB; more are dropped and counted, > 0
  std::function<void(const std::string&)> log;  ///< called from the capture's own threads
};

struct VideoCaptureState {
  bool running = false;          ///< false once a file has ended or a device is gone
  double frames_per_second = 0;  ///< over the last second
  std::uint64_t frames = 0;      ///< written to the present film, or the last
  std::uint64_t dropped = 0;     ///< of the present film, or the last: no room to wait, broken, or without a time
  std::size_t queued = 0;
  std::optional<ClockOffset> clock;  ///< of the frames' own times, in the present film or the last; nothing without such times
  std::string error;                 ///< why the film cannot continue; empty if it can
};

/// Grabs frames on its own thread through OpenCV, and encodes films of them on another. It continues to grab between films; a
/// file waits for the first film. If a file ends or a device is gone, the film ends, and is whole.
///
/// A film is `VideoWriter`'s MP4, written and synced every second, and a CSV file with `index,pts_us,host_time_us` of every
/// frame. A frame's row is written once it is encoded: after a kill every frame in the MP4 has its row, and the last rows, at
/// most a second of them, may lack their frames. Frames have the size of the film's first; odd sides become even. A frame's time
/// is the source's own (a file's, or a device's if it ascends), else its arrival, from the film's first frame on; `host_time_us`
/// is `host_now()` at its arrival.
class VideoCapture {
 public:
  /// A URL may take 5 s to answer, here and for every frame. OpenCV's and libavformat's own messages are silenced in the process.
  /// @throws Error  if an option is out of range, or the source cannot be opened or gives no frame
  explicit VideoCapture(VideoCaptureOptions options);
  ~VideoCapture();
  VideoCapture(const VideoCapture&) = delete;
  VideoCapture& operator=(const VideoCapture&) = delete;

  /// @throws Error  if one exists or cannot be made, another film is being made, or the source has ended
  void start_film(const std::filesystem::path& mp4, const std::filesystem::path& csv);
  void stop_film();  ///< encodes the waiting frames, ends and syncs both files. @throws Error if that or the filming failed

  VideoCaptureState state() const;
  cv::Mat newest_picture() const;  ///< as grabbed, also between films: read only; empty before the first

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::video
