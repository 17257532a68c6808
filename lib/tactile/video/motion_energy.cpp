#include "tactile/video/motion_energy.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/log.h>
#include <libswscale/swscale.h>
}

#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile {
namespace {

constexpr std::int64_t most_pixels = std::int64_t{8192} * 4320;
constexpr std::size_t most_frames = 1'000'000;
constexpr microseconds longest_film = 1h;
constexpr AVRational microsecond{1, 1'000'000};

// Of a pixel's change: thresholds a fourth of an octave apart from half a grey level on.
constexpr std::size_t threshold_count = 28;
constexpr double least_threshold = 1.0;  // [grey levels] coders change still pixels by less
constexpr double threshold_per_noise = 1.25;
constexpr microseconds longest_repeat = 150ms;  // a film that repeats a frame for longer has stopped

double threshold_at(std::size_t i) { return 0.5 * std::exp2(0.25 * static_cast<double>(i)); }

// Decoding

struct Close {
  void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

struct Dictionary {
  AVDictionary* entries = nullptr;

  Dictionary() = default;
  Dictionary(const Dictionary&) = delete;
  Dictionary& operator=(const Dictionary&) = delete;
  ~Dictionary() { av_dict_free(&entries); }
};

/// libavformat's own messages would go to stderr, a page for every damaged frame.
void be_quiet() {
  av_log_set_callback([](void*, int, const char*, va_list) {});
}

/// A film's frames, decoded one after the other by this thread alone.
class Film {
 public:
  explicit Film(const std::filesystem::path& path) : file_(path.string()) {
    be_quiet();
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) throw Error(file_ + ": no such file; expected a film");
    AVFormatContext* format = nullptr;
    Dictionary settings;
    av_dict_set(&settings.entries, "protocol_whitelist", "file", 0);  // a file that names others is no film
    const std::string url = "file:" + std::filesystem::absolute(path).string();
    if (avformat_open_input(&format, url.c_str(), nullptr, &settings.entries) < 0) refuse("cannot be read");
    format_.reset(format);
    check_what_the_header_says();
    find_stream();
    const AVCodec* decoder = avcodec_find_decoder(stream().codecpar->codec_id);
    if (decoder == nullptr) refuse(fmt::format("its coding ({}) is unknown", avcodec_get_name(stream().codecpar->codec_id)));
    codec_.reset(avcodec_alloc_context3(decoder));
    packet_.reset(av_packet_alloc());
    frame_.reset(av_frame_alloc());
    if (!codec_ || !packet_ || !frame_) throw Error(file_ + ": no memory for the decoder; expected some MB");
    codec_->pkt_timebase = stream().time_base;
    codec_->thread_count = 1;
    codec_->max_pixels = most_pixels;
    if (avcodec_parameters_to_context(codec_.get(), stream().codecpar) < 0 || avcodec_open2(codec_.get(), decoder, nullptr) < 0)
      refuse("its decoder cannot be opened");
  }

  /// The next frame that can be decoded, valid until the next call; null at the end.
  const AVFrame* next() {
    for (;;) {
      const int result = avcodec_receive_frame(codec_.get(), frame_.get());
      if (result == 0) {
        const bool whole = (frame_->flags & AV_FRAME_FLAG_CORRUPT) == 0 && frame_->decode_error_flags == 0;
        if (whole && frame_->width > 0 && frame_->height > 0) return frame_.get();
        continue;
      }
      if (result == AVERROR_EOF || ended_) return nullptr;
      send_packet();
    }
  }

  /// [us] nothing where the file tells none
  std::optional<std::int64_t> time_of(const AVFrame& frame) const { return us_from(frame.best_effort_timestamp); }

  /// How many frames the file holds, so far as it was read.
  std::size_t frames() const { return packet_times_.size(); }

  /// When each of them is shown [us], ascending; empty if one of them has no time.
  std::vector<std::int64_t> frame_times() const {
    std::vector<std::int64_t> times;
    for (const std::int64_t t : packet_times_) {
      const std::optional<std::int64_t> us = us_from(t);
      if (!us) return {};
      times.push_back(*us);
    }
    std::sort(times.begin(), times.end());
    return times;
  }

  [[noreturn]] void refuse(const std::string& why) const {
    throw Error(fmt::format("{}: {}; expected a film that libavformat reads", file_, why));
  }
  [[noreturn]] void refuse_length() const {
    throw Error(fmt::format("{}: its frames lie more than {} min apart; expected the film of a run", file_,
                            std::chrono::duration_cast<std::chrono::minutes>(longest_film).count()));
  }
  const std::string& file() const { return file_; }

 private:
  const AVStream& stream() const { return *format_->streams[stream_index_]; }

  void check_size(const AVCodecParameters& parameters) const {
    if (parameters.codec_type != AVMEDIA_TYPE_VIDEO) return;
    if (std::int64_t{parameters.width} * parameters.height > most_pixels) {
      throw Error(
          fmt::format("{}: frames of {} x {} px; expected at most 8192 x 4320", file_, parameters.width, parameters.height));
    }
  }

  void check_what_the_header_says() const {
    for (unsigned i = 0; i < format_->nb_streams; ++i) check_size(*format_->streams[i]->codecpar);
    if (format_->duration != AV_NOPTS_VALUE && format_->duration > longest_film.count()) refuse_length();
  }

  void find_stream() {
    std::vector<AVDictionary*> settings(format_->nb_streams, nullptr);
    for (AVDictionary*& of_stream : settings) {
      av_dict_set(&of_stream, "threads", "1", 0);
      av_dict_set_int(&of_stream, "max_pixels", most_pixels, 0);
    }
    const int result = avformat_find_stream_info(format_.get(), settings.data());
    for (AVDictionary*& of_stream : settings) av_dict_free(&of_stream);
    if (result < 0) refuse("cannot be read");
    stream_index_ = av_find_best_stream(format_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (stream_index_ < 0) refuse("holds no video");
    check_what_the_header_says();
  }

  void send_packet() {
    const int result = av_read_frame(format_.get(), packet_.get());
    if (result < 0) {
      ended_ = true;
      avcodec_send_packet(codec_.get(), nullptr);
      return;
    }
    // A file's edit list may say that a frame is only there to decode others.
    if (packet_->stream_index == stream_index_ && (packet_->flags & AV_PKT_FLAG_DISCARD) == 0) {
      note_time(packet_->pts != AV_NOPTS_VALUE ? packet_->pts : packet_->dts);
    }
    if (packet_->stream_index == stream_index_) avcodec_send_packet(codec_.get(), packet_.get());  // what it refuses is missing
    av_packet_unref(packet_.get());
  }

  void note_time(std::int64_t t) {
    if (packet_times_.size() == most_frames)
      throw Error(fmt::format("{}: more than {} frames; expected the film of a run", file_, most_frames));
    packet_times_.push_back(t);
    if (t == AV_NOPTS_VALUE) return;
    if (first_ == AV_NOPTS_VALUE) first_ = t;
    const std::int64_t apart = saturating_subtract(t, first_);
    const double us = 1e6 * static_cast<double>(apart) * av_q2d(stream().time_base);
    if (!(std::abs(us) <= static_cast<double>(longest_film.count()))) refuse_length();
  }

  /// Counted from the file's first frame.
  std::optional<std::int64_t> us_from(std::int64_t t) const {
    if (t == AV_NOPTS_VALUE || first_ == AV_NOPTS_VALUE) return std::nullopt;
    return av_rescale_q(saturating_subtract(t, first_), stream().time_base, microsecond);
  }

  std::string file_;
  std::unique_ptr<AVFormatContext, Close> format_;
  std::unique_ptr<AVCodecContext, Close> codec_;
  std::unique_ptr<AVPacket, Close> packet_;
  std::unique_ptr<AVFrame, Close> frame_;
  int stream_index_ = -1;
  bool ended_ = false;
  std::int64_t first_ = AV_NOPTS_VALUE;     ///< of the first packet, in the stream's units
  std::vector<std::int64_t> packet_times_;  ///< likewise, as they lie in the file
};

// Pictures

/// Grey and smoothed, in 1/256 grey levels.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint16_t> pixels;

  const std::uint16_t* row(int y) const { return pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width); }
};

/// Scales frames down and smooths them.
class Smoother {
 public:
  explicit Smoother(int width) : most_width_(width) {}
  Smoother(const Smoother&) = delete;
  Smoother& operator=(const Smoother&) = delete;
  ~Smoother() { sws_freeContext(scaler_); }

  /// @return  false if there is no way to make the frame grey
  bool smooth(const AVFrame& frame, Picture& picture) {
    const int width = std::min(frame.width, most_width_);
    const int height = std::max(1, static_cast<int>((std::int64_t{frame.height} * width + frame.width / 2) / frame.width));
    if (!prepare(frame, width, height)) return false;
    constexpr int aligned = 64, readable_beyond = 64;  // swscale may write in whole vectors
    const int stride = (width + aligned - 1) / aligned * aligned;
    grey_.resize(static_cast<std::size_t>(stride) * static_cast<std::size_t>(height) + readable_beyond);
    const std::array<std::uint8_t*, 4> rows{grey_.data(), nullptr, nullptr, nullptr};
    const std::array<int, 4> strides{stride, 0, 0, 0};
    if (sws_scale(scaler_, frame.data, frame.linesize, 0, frame.height, rows.data(), strides.data()) != height) return false;

    picture.width = width;
    picture.height = height;
    picture.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    // 1 4 6 4 1 both ways; the edge goes on as it is.
    constexpr int reach = 2;
    const auto sides = static_cast<std::size_t>(width);
    column_.resize(sides + std::size_t{2} * reach);
    const auto row_at = [&](int y) {
      return grey_.data() + static_cast<std::size_t>(std::clamp(y, 0, height - 1)) * static_cast<std::size_t>(stride);
    };
    for (int y = 0; y < height; ++y) {
      const std::uint8_t *a = row_at(y - 2), *b = row_at(y - 1), *c = row_at(y), *d = row_at(y + 1), *e = row_at(y + 2);
      std::uint16_t* column = column_.data() + reach;
      for (std::size_t x = 0; x < sides; ++x) column[x] = static_cast<std::uint16_t>(a[x] + 4 * (b[x] + d[x]) + 6 * c[x] + e[x]);
      for (int i = 1; i <= reach; ++i) {
        *(column - i) = column[0];
        column[static_cast<std::ptrdiff_t>(sides) - 1 + i] = column[sides - 1];
      }
      const std::uint16_t* from = column_.data();
      std::uint16_t* to = picture.pixels.data() + static_cast<std::size_t>(y) * sides;
      for (std::size_t x = 0; x < sides; ++x) {
        to[x] = static_cast<std::uint16_t>(from[x] + 4 * (from[x + 1] + from[x + 3]) + 6 * from[x + 2] + from[x + 4]);
      }
    }
    return true;
  }

 private:
  /// All films alike: luma stays as it is, whether or not it uses the whole range.
  bool prepare(const AVFrame& frame, int width, int height) {
    const std::array<int, 3> from{frame.width, frame.height, frame.format};
    if (scaler_ != nullptr && from == from_) return true;
    sws_freeContext(scaler_);
    scaler_ = sws_getContext(frame.width, frame.height, static_cast<AVPixelFormat>(frame.format), width, height, AV_PIX_FMT_GRAY8,
                             SWS_AREA, nullptr, nullptr, nullptr);
    if (scaler_ == nullptr) return false;
    from_ = from;
    const int* coefficients = sws_getCoefficients(SWS_CS_DEFAULT);
    constexpr int one = 1 << 16;
    sws_setColorspaceDetails(scaler_, coefficients, 1, coefficients, 1, 0, one, one);
    return true;
  }

  int most_width_;
  SwsContext* scaler_ = nullptr;
  std::array<int, 3> from_{};  ///< what it scales: width, height, pixel format
  std::vector<std::uint8_t> grey_;
  std::vector<std::uint16_t> column_;
};

/// How bright a frame is beside the one before it: gain * I + offset, in 1/256 grey levels.
struct Brightness {
  float gain = 1, offset = 0;
  bool changed = false;  ///< by more than a hundredth
};

/// From about a thousand pixels on a grid. The line whose slope is the ratio of the standard deviations: noise, of which both
/// frames have as much, does not make it flatter, as it does a line of least squares.
Brightness fit_brightness(const Picture& before, const Picture& now, std::vector<std::array<float, 2>>& pairs,
                          std::vector<float>& residuals) {
  constexpr int rounds = 3;
  constexpr double pixels_wanted = 1200;
  const int grid = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(now.width) * now.height / pixels_wanted)));
  constexpr float outlier = 3 * static_cast<float>(sigma_per_median), least_outlier = 128;
  constexpr double changed_by = 0.01;
  pairs.clear();
  for (int y = grid / 2; y < now.height; y += grid) {
    for (int x = grid / 2; x < now.width; x += grid)
      pairs.push_back({static_cast<float>(before.row(y)[x]), static_cast<float>(now.row(y)[x])});
  }
  Brightness found;
  float limit = std::numeric_limits<float>::infinity();
  double mean_before = 0, mean_now = 0;
  for (int round = 0; round < rounds; ++round) {
    double n = 0, x = 0, y = 0, xx = 0, yy = 0;
    for (const auto& [p, q] : pairs) {
      if (std::abs(q - found.gain * p - found.offset) > limit) continue;
      n += 1;
      x += p;
      y += q;
      xx += double{p} * p;
      yy += double{q} * q;
    }
    if (n < 3) break;
    const double x_spread = xx - x * x / n, y_spread = yy - y * y / n;
    const double gain = x_spread > n && y_spread > 0 ? std::clamp(std::sqrt(y_spread / x_spread), 0.5, 2.0) : 1.0;
    found.gain = static_cast<float>(gain);
    found.offset = static_cast<float>((y - gain * x) / n);
    mean_before = x / n;
    mean_now = y / n;
    if (round + 1 == rounds) break;
    residuals.clear();
    for (const auto& [p, q] : pairs) residuals.push_back(std::abs(q - found.gain * p - found.offset));
    limit = outlier * upper_median<float>(residuals) + least_outlier;
  }
  found.changed = std::abs(mean_now - mean_before) > changed_by * std::max(mean_before, 256.0);
  return found;
}

/// How a frame differs from the one before it.
struct Difference {
  bool same = false;                           ///< to the last bit
  bool brightness = false;                     ///< changed
  float noise = 0;                             ///< the change that `share_of_noise` of the pixels stay below [grey levels]
  std::array<float, threshold_count> above{};  ///< mean of what is above each threshold [grey levels]
};

class Differences {
 public:
  Difference between_frames(const Picture& before, const Picture& now, const cv::Rect& region) {
    Difference result;
    result.same = before.pixels == now.pixels;
    if (result.same) return result;
    const Brightness line = fit_brightness(before, now, pairs_, residuals_);
    result.brightness = line.changed;
    count(before, now, region, line);
    result.noise = static_cast<float>(upper_median<std::uint16_t>(largest_)) / 256;

    // From the greatest change down.
    const double pixels = static_cast<double>(region.width) * region.height;
    double sum_above = 0;
    std::size_t level = threshold_count;
    for (std::size_t bin = bins; bin-- > least_bin;) {
      double counted = 0;
      for (const auto& table : tables_) counted += table[bin];
      sum_above += counted * (static_cast<double>(bin) + 0.5) / bins_per_grey;
      while (level > 0 && threshold_at(level - 1) * bins_per_grey >= static_cast<double>(bin))
        result.above[--level] = static_cast<float>(sum_above / pixels);
    }
    return result;
  }

 private:
  static constexpr std::size_t bins_per_grey = 8, bins = 256 * bins_per_grey, table_count = 4;
  static constexpr std::size_t least_bin = bins_per_grey / 2;  // smaller changes, which most pixels have, are not counted
  static constexpr float saturated = 230 * 256;
  static constexpr int most_parts = 8, least_part = 16;  // [px] of the picture, each way: what moves is in less than half of them

  void count(const Picture& before, const Picture& now, const cv::Rect& region, const Brightness& line) {
    for (auto& table : tables_) table.fill(0);
    const auto parts_of = [](int side) { return static_cast<std::size_t>(std::clamp(side / least_part, 1, most_parts)); };
    const std::size_t columns = parts_of(region.width), rows = parts_of(region.height);
    largest_.assign(columns * rows, 0);
    const auto width = static_cast<std::size_t>(region.width);
    changes_.assign((width + table_count - 1) / table_count * table_count, 0);
    for (int y = region.y; y < region.y + region.height; ++y) {
      const std::uint16_t *p = before.row(y) + region.x, *q = now.row(y) + region.x;
      for (std::size_t x = 0; x < width; ++x) {
        const float change = static_cast<float>(q[x]) - line.gain * static_cast<float>(p[x]) - line.offset;
        changes_[x] = static_cast<std::uint16_t>(std::min(std::abs(change), 65535.0F));
      }
      if (line.changed) {  // what was white cannot become whiter
        for (std::size_t x = 0; x < width; ++x)
          if (static_cast<float>(std::max(p[x], q[x])) >= saturated) changes_[x] = 0;
      }
      const std::size_t row = static_cast<std::size_t>(y - region.y) * rows / static_cast<std::size_t>(region.height);
      for (std::size_t column = 0; column < columns; ++column) {
        std::uint16_t largest = 0;
        for (std::size_t x = column * width / columns; x < (column + 1) * width / columns; ++x)
          largest = std::max(largest, changes_[x]);
        std::uint16_t& of_part = largest_[row * columns + column];
        of_part = std::max(of_part, largest);
      }
      constexpr std::uint64_t any_counted = 0xff80'ff80'ff80'ff80;  // of four changes, half a grey level or more
      constexpr unsigned shift = 5;                                 // 256 / bins_per_grey
      for (std::size_t x = 0; x < changes_.size(); x += table_count) {
        std::uint64_t four = 0;
        std::memcpy(&four, changes_.data() + x, sizeof(four));
        if ((four & any_counted) == 0) continue;
        for (std::size_t i = 0; i < table_count; ++i) ++tables_[i][changes_[x + i] >> shift];
      }
    }
  }

  std::vector<std::array<float, 2>> pairs_;
  std::vector<float> residuals_;
  std::vector<std::uint16_t> changes_;
  std::vector<std::uint16_t> largest_;  ///< change in each part
  std::array<std::array<std::uint32_t, bins>, table_count>
      tables_{};  // several, so that equal neighbours do not wait for each other
};

/// The region in a picture scaled down; the whole of it where there is none.
cv::Rect scaled_region(const std::optional<cv::Rect>& region, const AVFrame& frame, const Picture& picture,
                       const std::string& file) {
  if (!region) return {0, 0, picture.width, picture.height};
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

/// A decoded frame and how it differs from the one before it.
struct FilmFrame {
  std::size_t index = 0;           ///< in the order they are shown; the order they came in where the file has no times
  std::optional<std::int64_t> us;  ///< by the container
  bool compared = false;           ///< the first of its size has nothing to be compared with
  Difference difference;
  bool key = false;  ///< it was coded by itself
};

// From differences to energy

/// The highest threshold above which a tenth of the change lies.
double strongest_of(const Difference& difference, std::size_t level) {
  constexpr float share = 0.1F;
  std::size_t i = level;
  while (i + 1 < threshold_count && difference.above[i + 1] > share * difference.above[level]) ++i;
  return difference.above[level] > 0 ? threshold_at(i) : 0.0;
}

struct QuietSteps {
  double median = 0, deviation = 0;
};

/// Of the lower values, whatever few or many high ones there are.
QuietSteps quiet_steps(const std::vector<double>& values) {
  constexpr int rounds = 8;
  constexpr double outlier = 4;
  QuietSteps quiet;
  double limit = lower_median(values);
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> lower;
    for (const double value : values)
      if (value <= limit) lower.push_back(value);
    quiet.median = lower_median(lower);
    quiet.deviation = sigma_per_median * lower_median(distances_from(quiet.median, lower));
    limit = quiet.median + outlier * quiet.deviation;
  }
  return quiet;
}

/// Which frames only repeat the one before: of a film made to a constant rate. Known by motion that they interrupt; where nothing
/// moves, coders repeat frames too, and that is no gap.
std::vector<bool> duplicates_among(const std::vector<FilmFrame>& frames, std::size_t level, double moving) {
  std::vector<bool> duplicates(frames.size(), false);
  const auto same = [&](std::size_t i) { return frames[i].compared && frames[i].difference.same; };
  const auto moves = [&](std::size_t i) { return frames[i].compared && frames[i].difference.above[level] > moving; };
  const auto drop = [&](std::size_t begin, std::size_t end) {
    std::fill(duplicates.begin() + static_cast<std::ptrdiff_t>(begin), duplicates.begin() + static_cast<std::ptrdiff_t>(end),
              true);
  };
  std::vector<double> repeats;                               // in the midst of motion
  std::vector<std::pair<std::size_t, std::size_t>> leading;  // repeats before motion: how many of them the film itself has made?
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

/// Each frame's time on the video's clock, by its row where there is one.
std::vector<std::optional<VideoTime>> times_of(const std::vector<FilmFrame>& frames, std::span<const VideoTime> rows,
                                               const std::vector<std::int64_t>& container_times) {
  std::vector<std::optional<VideoTime>> times;
  for (const FilmFrame& frame : frames) {
    std::optional<VideoTime> t;
    if (rows.empty()) {
      if (frame.us && frames.front().us) t = VideoTime{microseconds{*frame.us - *frames.front().us}};
    } else if (frame.index < rows.size()) {
      t = rows[frame.index];
    } else if (frame.us && !container_times.empty()) {
      const std::int64_t behind_last_row = *frame.us - container_times[rows.size() - 1];
      t = VideoTime{microseconds{saturating_add(us_of(rows.back()), behind_last_row)}};
    }
    times.push_back(t);
  }
  return times;
}

}  // namespace

MotionEnergy motion_energy(const std::filesystem::path& path, std::span<const VideoTime> rows,
                           const MotionEnergyOptions& options) {
  if (options.width < 1) throw Error(fmt::format("{}: a width of {} px; expected more than 0", path.string(), options.width));
  Film film(path);
  if (!rows.empty() && saturating_subtract(us_of(rows.back()), us_of(rows.front())) > longest_film.count()) film.refuse_length();

  std::vector<FilmFrame> frames;
  double region_pixels = 1;
  {
    Smoother smoother(options.width);
    const auto differences = std::make_unique<Differences>();
    Picture before, now;
    while (const AVFrame* frame = film.next()) {
      if (!smoother.smooth(*frame, now)) continue;
      const cv::Rect region = scaled_region(options.region, *frame, now, film.file());
      region_pixels = static_cast<double>(region.width) * region.height;
      FilmFrame& added = frames.emplace_back();
      added.index = frames.size() - 1;
      added.us = film.time_of(*frame);
      added.key = frame->pict_type == AV_PICTURE_TYPE_I;
      added.compared = before.width == now.width && before.height == now.height;
      if (added.compared) added.difference = differences->between_frames(before, now, region);
      std::swap(before, now);
    }
  }
  const std::vector<std::int64_t> container_times = film.frame_times();
  if (!container_times.empty()) {
    for (FilmFrame& frame : frames) {
      if (!frame.us) continue;
      const auto place = std::lower_bound(container_times.begin(), container_times.end(), *frame.us);
      frame.index = static_cast<std::size_t>(place - container_times.begin());
    }
  }

  MotionEnergy energy;
  energy.frames = frames.size();
  energy.undecodable = film.frames() - std::min(film.frames(), frames.size());
  if (!rows.empty()) {
    energy.rows_without_frame = rows.size() - std::min(rows.size(), film.frames());
    energy.frames_without_row = static_cast<std::size_t>(
        std::count_if(frames.begin(), frames.end(), [&](const FilmFrame& frame) { return frame.index >= rows.size(); }));
  }

  // Steps to a key frame have a noise of their own, and may be all there are.
  std::vector<double> noises, key_noises;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const FilmFrame& frame = frames[i];
    energy.exposure_steps += frame.difference.brightness ? 1 : 0;
    if (frame.compared && !frame.difference.same) (frame.key ? key_noises : noises).push_back(frame.difference.noise);
  }
  const auto lower_quartile = [](const std::vector<double>& values) {
    return values.empty() ? 0.0 : value_of_rank(values, (values.size() - 1) / 4);
  };
  const double noise = std::max(lower_quartile(noises), lower_quartile(key_noises));
  const double wanted = std::max(least_threshold, threshold_per_noise * noise);
  std::size_t level = 0;
  while (level + 1 < threshold_count && threshold_at(level) < wanted) ++level;
  energy.threshold = threshold_at(level);

  std::vector<double> changes, key_changes;
  for (const FilmFrame& frame : frames) {
    if (frame.compared) (frame.key ? key_changes : changes).push_back(frame.difference.above[level]);
  }
  if (changes.empty()) changes.swap(key_changes);
  const QuietSteps quiet = quiet_steps(changes);
  // What a key frame changes by itself is taken off with its tail: it is no noise of the other steps.
  constexpr std::size_t enough = 3;
  constexpr double tail = 4;
  double key_floor = quiet.median;
  if (key_changes.size() >= enough) {
    const QuietSteps of_key = quiet_steps(key_changes);
    key_floor = std::max(key_floor, of_key.median + tail * of_key.deviation);
  }
  constexpr double least_pixels = 5;  // so few moving ones cannot be told from noise
  energy.noise = std::max(quiet.deviation, least_pixels * energy.threshold / region_pixels);

  constexpr double beyond_noise = 10;
  const std::vector<bool> duplicates = duplicates_among(frames, level, quiet.median + beyond_noise * energy.noise);
  const std::vector<std::optional<VideoTime>> times = times_of(frames, rows, container_times);
  std::optional<VideoTime> last;
  double change = 0, strongest = 0;
  bool joined = true, doubtful = false;
  std::vector<double> lengths;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FilmFrame& frame = frames[i];
    change += std::max(0.0, frame.difference.above[level] - (frame.key ? key_floor : quiet.median));
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
      if (length > longest_film) film.refuse_length();
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
  return energy;
}

}  // namespace tactile
