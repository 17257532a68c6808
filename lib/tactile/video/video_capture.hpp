#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace tactile {

struct VideoCaptureOptions {
  std::string source;      ///< a device's number ("0") or path ("/dev/video0"), a file, or a URL
  double speed = 1;        ///< of a file: 1 by its own times, 0 as fast as it goes
  int quality = 23;        ///< constant rate factor of H.264, 0 to 51
  std::size_t queue = 60;  ///< frames that may wait for the encoder; further ones are dropped and counted, > 0
  std::function<void(const std::string&)> log;  ///< told from the capture's own threads
};

struct VideoCaptureState {
  bool running = false;          ///< false once a file has ended or a device is gone
  double frames_per_second = 0;  ///< over the last second
  std::uint64_t frames = 0;      ///< written to the present film
  std::uint64_t dropped = 0;     ///< of the present film
  std::size_t queued = 0;
  std::string error;  ///< why the film cannot go on; empty where it can
};

/// Grabs frames on a thread of its own through OpenCV, and encodes films of them on another. It goes on grabbing between films.
///
/// A film is `VideoWriter`'s MP4, on the disk every second, and beside it `index,pts_us,host_time_us` of every frame in it,
/// written as they are encoded. A frame's time is the source's own (a file's, a device's where it tells one that ascends), else
/// when it came.
class VideoCapture {
 public:
  explicit VideoCapture(VideoCaptureOptions options);  ///< @throws Error if the source cannot be opened or gives no frame
  ~VideoCapture();
  VideoCapture(const VideoCapture&) = delete;
  VideoCapture& operator=(const VideoCapture&) = delete;

  void start_film(const std::filesystem::path& mp4,
                  const std::filesystem::path& csv);  ///< @throws Error if one exists or cannot be made
  void stop_film();  ///< encodes what waits, ends and syncs both files. @throws Error if that failed

  VideoCaptureState state() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
