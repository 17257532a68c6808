#pragma once

#include <filesystem>
#include <memory>
#include <string>

extern "C" {
#include <libavformat/avformat.h>
}

#include "tactile/core/time.hpp"

namespace tactile::video {

inline constexpr std::int64_t most_film_pixels = std::int64_t{8192} * 4320;  ///< of a frame

/// A film that is open for reading, and its video stream. For the files of this stage only: it needs libav's headers.
struct FilmInput {
  /// @param longest  of the film, as its header has it
  /// @throws Error  if the file holds no video, its frames are larger than 8192 x 4320 px, or it is longer
  FilmInput(const std::filesystem::path& path, microseconds longest);

  [[noreturn]] void refuse(const std::string& why) const;
  [[noreturn]] void refuse_length() const;
  const AVStream& stream() const { return *format->streams[stream_index]; }

  struct CloseInput {
    void operator()(AVFormatContext* opened) const { avformat_close_input(&opened); }
  };
  std::string file;
  microseconds longest;
  std::unique_ptr<AVFormatContext, CloseInput> format;
  int stream_index = -1;

 private:
  void check_header() const;
  void find_stream();
};

}  // namespace tactile::video
