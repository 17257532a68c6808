#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::video {

/// A film's frames, decoded one after the other by the calling thread.
class FilmReader {
 public:
  static constexpr microseconds longest{std::chrono::hours(1)};  ///< of a film

  /// Any file that libavformat reads: MP4, MKV, AVI, of any rate.
  /// @throws Error  if the file holds no video, or its frames are larger than 8192 x 4320 px
  explicit FilmReader(const std::filesystem::path& file);
  ~FilmReader();

  struct Frame {
    cv::Size size;
    std::optional<std::int64_t> us;  ///< from the file's first frame, by the container; nothing where it has no time
    bool is_key = false;             ///< coded by itself
  };

  /// The next frame that can be decoded; nothing at the end. @throws Error  after more than a million frames, or an hour
  std::optional<Frame> next();

  /// The last frame as 8-bit luma, scaled down to `most_width` if it is wider. Luma stays as it is, whether or not it uses the
  /// whole range. @return  false if the frame cannot be converted
  bool grey(int most_width, cv::Mat& picture);

  std::size_t frames() const;                     ///< in the part of the file that was read, decodable or not
  std::vector<std::int64_t> frame_times() const;  ///< when each of them is shown [us], ascending; empty if one has no time
  [[noreturn]] void refuse_length() const;        ///< throws the Error of a film that is too long
  const std::string& file() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::video
