#include "tactile/video/opencv_part.hpp"

#include <fmt/core.h>

#include <cmath>
#include <cstdarg>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
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

class OpenCvSource : public VideoSource {
 public:
  explicit OpenCvSource(const std::string& source) {
    be_quiet();
    std::error_code ignored;
    const std::optional<int> number = device_number(source);
    const bool is_url = source.find("://") != std::string::npos;
    const char* expected = "";
    if (number || (!is_url && (source.starts_with("/dev/video") || fs::is_character_file(source, ignored)))) {
      expected = "a camera that is plugged in, may be read and is not in use elsewhere";
      const std::string device = number ? fmt::format("/dev/video{}", *number) : source;
      if (!fs::exists(device, ignored)) {
        throw Error(fmt::format("{}{}: no such device; expected {}", source, number ? " (" + device + ")" : "", expected));
      }
      capture_.open(device, cv::CAP_V4L2);
    } else if (is_url) {
      expected = "a URL that answers within 5 s with a video, such as rtsp://… or http://…";
      capture_.open(source, cv::CAP_FFMPEG,
                    {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, patience_ms, cv::CAP_PROP_READ_TIMEOUT_MSEC, patience_ms});
      is_recorded_ = capture_.isOpened() && capture_.get(cv::CAP_PROP_FRAME_COUNT) >= 1;
    } else {
      expected = "a video that libavformat reads";
      if (!fs::is_regular_file(source, ignored))
        throw Error(source + ": no such file; expected a device's number or path, a video's file, or a URL");
      capture_.open("file:" + fs::absolute(source).string(), cv::CAP_FFMPEG);
      is_recorded_ = true;
    }
    if (!capture_.isOpened()) throw Error(fmt::format("{}: cannot be opened; expected {}", source, expected));
  }

  bool grab() override { return capture_.grab(); }
  double time_ms() const override { return capture_.get(cv::CAP_PROP_POS_MSEC); }
  bool decode(cv::Mat& into) override { return capture_.retrieve(into) && !into.empty(); }
  void close() override { capture_.release(); }

  microseconds nominal_step() const override {
    const double rate = capture_.get(cv::CAP_PROP_FPS);
    return microseconds{std::isfinite(rate) && rate >= 1 && rate <= 1000 ? std::llround(1e6 / rate) : 40'000};
  }

  bool is_recorded() const override { return is_recorded_; }

 private:
  cv::VideoCapture capture_;
  bool is_recorded_ = false;
};

std::unique_ptr<VideoSource> open_source(const std::string& source) { return std::make_unique<OpenCvSource>(source); }

std::vector<unsigned char> encode(const char* extension, const cv::Mat& picture, const std::vector<int>& options) {
  try {
    std::vector<unsigned char> bytes;
    if (cv::imencode(extension, picture, bytes, options)) return bytes;
  } catch (const cv::Exception&) {
    // as where it returns false
  }
  return {};
}

cv::Mat decode(std::span<const std::byte> file) {
  try {
    return cv::imdecode(cv::Mat(1, static_cast<int>(file.size()), CV_8UC1, const_cast<std::byte*>(file.data())),
                        cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    return {};
  }
}

}  // namespace
}  // namespace tactile::video

extern "C" const tactile::video::OpenCvPart tactile_opencv_part{tactile::video::open_source, tactile::video::encode,
                                                                tactile::video::decode};
