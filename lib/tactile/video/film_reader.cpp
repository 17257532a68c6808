#include "tactile/video/film_reader.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libswscale/swscale.h>
}

#include "tactile/core/error.hpp"
#include "tactile/video/film_input.hpp"

namespace tactile::video {
namespace {

constexpr std::size_t most_frames = 1'000'000;

struct Close {
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

}  // namespace

struct FilmReader::State : FilmInput {
  explicit State(const std::filesystem::path& path) : FilmInput(path, FilmReader::longest) { open_decoder(); }

  void open_decoder() {
    const AVCodec* decoder = avcodec_find_decoder(stream().codecpar->codec_id);
    if (decoder == nullptr) refuse(fmt::format("its coding ({}) is unknown", avcodec_get_name(stream().codecpar->codec_id)));
    codec.reset(avcodec_alloc_context3(decoder));
    packet.reset(av_packet_alloc());
    frame.reset(av_frame_alloc());
    if (!codec || !packet || !frame) throw Error(file + ": no memory for the decoder; expected some MB");
    codec->pkt_timebase = stream().time_base;
    codec->thread_count = 1;
    codec->max_pixels = most_film_pixels;
    if (avcodec_parameters_to_context(codec.get(), stream().codecpar) < 0 || avcodec_open2(codec.get(), decoder, nullptr) < 0)
      refuse("its decoder cannot be opened");
  }

  void send_packet() {
    if (av_read_frame(format.get(), packet.get()) < 0) {
      ended = true;
      avcodec_send_packet(codec.get(), nullptr);
      return;
    }
    if (packet->stream_index == stream_index) {
      // A file's edit list may say that a frame is only there to decode others.
      if ((packet->flags & AV_PKT_FLAG_DISCARD) == 0) note_time(packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts);
      avcodec_send_packet(codec.get(), packet.get());  // what it refuses is missing
    }
    av_packet_unref(packet.get());
  }

  void note_time(std::int64_t t) {
    if (packet_times.size() == most_frames)
      throw Error(fmt::format("{}: more than {} frames; expected the film of a run", file, most_frames));
    packet_times.push_back(t);
    if (t == AV_NOPTS_VALUE) return;
    if (first == AV_NOPTS_VALUE) first = t;
    const double us = 1e6 * static_cast<double>(saturating_subtract(t, first)) * av_q2d(stream().time_base);
    if (!(std::abs(us) <= static_cast<double>(longest.count()))) refuse_length();
  }

  std::optional<std::int64_t> us_from(std::int64_t t) const {
    if (t == AV_NOPTS_VALUE || first == AV_NOPTS_VALUE) return std::nullopt;
    return av_rescale_q(saturating_subtract(t, first), stream().time_base, av_get_time_base_q());
  }

  /// Sets the scaler for the last frame. @return false if there is none
  bool prepare_scaler(int width, int height) {
    const std::array<int, 3> from{frame->width, frame->height, frame->format};
    if (scaler && from == scaled_from) return true;
    scaler.reset(sws_getContext(frame->width, frame->height, static_cast<AVPixelFormat>(frame->format), width, height,
                                AV_PIX_FMT_GRAY8, SWS_AREA, nullptr, nullptr, nullptr));
    if (!scaler) return false;
    scaled_from = from;
    const int* coefficients = sws_getCoefficients(SWS_CS_DEFAULT);
    constexpr int one = 1 << 16;
    sws_setColorspaceDetails(scaler.get(), coefficients, 1, coefficients, 1, 0, one, one);
    return true;
  }

  std::unique_ptr<AVCodecContext, Close> codec;
  std::unique_ptr<AVPacket, Close> packet;
  std::unique_ptr<AVFrame, Close> frame;
  std::unique_ptr<SwsContext, Close> scaler;
  std::array<int, 3> scaled_from{};  ///< width, height, pixel format
  bool ended = false;
  std::int64_t first = AV_NOPTS_VALUE;     ///< of the first packet, in the stream's units
  std::vector<std::int64_t> packet_times;  ///< of all packets, in the stream's units and the file's order
};

FilmReader::FilmReader(const std::filesystem::path& file) : state_(std::make_unique<State>(file)) {}
FilmReader::~FilmReader() = default;

std::optional<FilmReader::Frame> FilmReader::next() {
  for (;;) {
    const AVFrame& frame = *state_->frame;
    const int result = avcodec_receive_frame(state_->codec.get(), state_->frame.get());
    if (result == 0) {
      const bool is_whole = (frame.flags & AV_FRAME_FLAG_CORRUPT) == 0 && frame.decode_error_flags == 0;
      if (!is_whole || frame.width <= 0 || frame.height <= 0) continue;
      return Frame{.size = {frame.width, frame.height},
                   .us = state_->us_from(frame.best_effort_timestamp),
                   .is_key = frame.pict_type == AV_PICTURE_TYPE_I};
    }
    if (result == AVERROR_EOF || state_->ended) return std::nullopt;
    state_->send_packet();
  }
}

bool FilmReader::grey(int most_width, cv::Mat& picture) {
  const AVFrame& frame = *state_->frame;
  const int width = std::min(frame.width, most_width);
  const int height = std::max(1, static_cast<int>((std::int64_t{frame.height} * width + frame.width / 2) / frame.width));
  if (!state_->prepare_scaler(width, height)) return false;
  constexpr int aligned = 64;  // swscale may write whole vectors, and one row further
  cv::Mat padded(height + 1, (width + aligned - 1) / aligned * aligned, CV_8U);
  const std::array<std::uint8_t*, 4> rows{padded.data, nullptr, nullptr, nullptr};
  const std::array<int, 4> strides{padded.cols, 0, 0, 0};
  if (sws_scale(state_->scaler.get(), frame.data, frame.linesize, 0, frame.height, rows.data(), strides.data()) != height)
    return false;
  picture = padded(cv::Rect(0, 0, width, height));
  return true;
}

std::size_t FilmReader::frames() const { return state_->packet_times.size(); }

std::vector<std::int64_t> FilmReader::frame_times() const {
  std::vector<std::int64_t> times;
  for (const std::int64_t t : state_->packet_times) {
    const std::optional<std::int64_t> us = state_->us_from(t);
    if (!us) return {};
    times.push_back(*us);
  }
  std::sort(times.begin(), times.end());
  return times;
}

void FilmReader::refuse_length() const { state_->refuse_length(); }
const std::string& FilmReader::file() const { return state_->file; }

}  // namespace tactile::video
