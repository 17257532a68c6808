#include "tactile/video/video_source.hpp"

#include <fmt/core.h>

#include <cmath>
#include <cstdarg>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <optional>
#include <system_error>

extern "C" {
#include <libavutil/log.h>
}

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::video {
namespace fs = std::filesystem;
namespace {

constexpr int patience_ms = 5'000;  // with a URL that does not answer, or stops sending

std::optional<int> device_number(const std::string& source) {
  const std::optional<std::int64_t> number = whole_number_in(source);
  return number && *number >= 0 && *number < 1000 ? std::optional(static_cast<int>(*number)) : std::nullopt;
}

/// An Error is one sentence; OpenCV and libavformat would print a page.
void be_quiet() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  av_log_set_callback([](void*, int, const char*, va_list) {});
}

}  // namespace

VideoSource open_video_source(const std::string& source) {
  be_quiet();
  VideoSource opened;
  std::error_code ignored;
  const std::optional<int> number = device_number(source);
  const bool is_url = source.find("://") != std::string::npos;
  const char* expected = "";
  if (number || (!is_url && (source.starts_with("/dev/video") || fs::is_character_file(source, ignored)))) {
    opened.kind = VideoSource::Kind::device;
    expected = "a camera that is plugged in, may be read and is not in use elsewhere";
    const std::string device = number ? fmt::format("/dev/video{}", *number) : source;
    if (!fs::exists(device, ignored)) {
      throw Error(fmt::format("{}{}: no such device; expected {}", source, number ? " (" + device + ")" : "", expected));
    }
    opened.capture.open(device, cv::CAP_V4L2);
  } else if (is_url) {
    opened.kind = VideoSource::Kind::url;
    expected = "a URL that answers within 5 s with a video, such as rtsp://… or http://…";
    opened.capture.open(source, cv::CAP_FFMPEG,
                        {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, patience_ms, cv::CAP_PROP_READ_TIMEOUT_MSEC, patience_ms});
  } else {
    expected = "a video that libavformat reads";
    if (!fs::is_regular_file(source, ignored))
      throw Error(source + ": no such file; expected a device's number or path, a video's file, or a URL");
    opened.capture.open("file:" + fs::absolute(source).string(), cv::CAP_FFMPEG);
  }
  if (!opened.capture.isOpened()) throw Error(fmt::format("{}: cannot be opened; expected {}", source, expected));
  opened.recorded = opened.kind == VideoSource::Kind::file ||
                    (opened.kind == VideoSource::Kind::url && opened.capture.get(cv::CAP_PROP_FRAME_COUNT) >= 1);
  return opened;
}

microseconds nominal_step(const cv::VideoCapture& capture) {
  const double rate = capture.get(cv::CAP_PROP_FPS);
  return microseconds{std::isfinite(rate) && rate >= 1 && rate <= 1000 ? std::llround(1e6 / rate) : 40'000};
}

}  // namespace tactile::video
