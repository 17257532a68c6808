#include "tactile/video/video_writer.hpp"

#include <fmt/core.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "tactile/core/error.hpp"

namespace tactile::video {
namespace {

constexpr std::size_t readable_beyond = 256;  // [B] after a picture: libswscale reads some there

std::string reason(int error) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(error, text.data(), text.size());
  return text.data();
}

}  // namespace

struct VideoWriter::State {
  std::string file;
  VideoWriterOptions options;
  AVFormatContext* format = nullptr;
  AVCodecContext* codec = nullptr;
  AVFrame* picture = nullptr;
  AVPacket* packet = nullptr;
  AVPacket* waiting = nullptr;   ///< an encoded frame: it lasts until the next one, whose time must be known before it is written
  SwsContext* scaler = nullptr;  ///< from BGR
  std::vector<std::uint8_t> pixels;  ///< of the frame being converted, row on row
  std::int64_t last_us = -1;
  std::int64_t fragment_us = 0;  ///< time of the present fragment's first frame
  std::int64_t last_duration_us = 33'333;
  bool begun = false;

  ~State() {
    sws_freeContext(scaler);
    av_packet_free(&packet);
    av_packet_free(&waiting);
    av_frame_free(&picture);
    avcodec_free_context(&codec);
    if (format != nullptr) avio_closep(&format->pb);
    avformat_free_context(format);
  }

  void check(int result, const char* what) const {
    if (result < 0)
      throw Error(fmt::format("{}: {} failed ({}); expected a writable place with room", file, what, reason(result)));
  }

  void open() {
    // x264 by name where it is there: other encoders of H.264 need hardware that may be missing.
    const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
    if (encoder == nullptr) encoder = avcodec_find_encoder(AV_CODEC_ID_H264);
    if (encoder == nullptr) throw Error(file + ": libavcodec has no encoder for H.264; expected one built with libx264");
    check(avformat_alloc_output_context2(&format, nullptr, "mp4", nullptr), "choosing MP4");
    codec = avcodec_alloc_context3(encoder);
    picture = av_frame_alloc();
    packet = av_packet_alloc();
    waiting = av_packet_alloc();
    if (codec == nullptr || picture == nullptr || packet == nullptr || waiting == nullptr)
      throw Error(file + ": no memory for the encoder; expected some MB");

    codec->width = options.width;
    codec->height = options.height;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->time_base = av_get_time_base_q();
    codec->framerate = {30, 1};  // for the rate control only; each frame has its own time
    codec->gop_size = options.frames_per_fragment;
    codec->max_b_frames = 0;  // else decoding times run ahead of the first frame's, and players shift the whole film
    codec->thread_count = 1;
    codec->log_level_offset = AV_LOG_DEBUG - AV_LOG_INFO;  // the encoder's own messages are for debugging
    codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
    av_opt_set(codec->priv_data, "preset", options.fast ? "ultrafast" : "veryfast", 0);
    av_opt_set(codec->priv_data, "tune", "zerolatency", 0);
    if (options.fast) {
      av_opt_set_int(codec->priv_data, "qp", options.quality, 0);  // then each frame is encoded once
      av_opt_set(codec->priv_data, "coder", "cabac", 0);           // the preset's own needs a long start, and more bytes
    } else {
      av_opt_set_int(codec->priv_data, "crf", options.quality, 0);
    }
    if (options.fragment_span.count() > 0)
      av_opt_set(codec->priv_data, "forced-idr", "1", 0);  // a fragment begins with a key frame
    check(avcodec_open2(codec, encoder, nullptr), "opening the encoder");

    AVStream* stream = avformat_new_stream(format, nullptr);
    if (stream == nullptr) throw Error(file + ": no memory for the stream; expected some MB");
    stream->time_base = av_get_time_base_q();
    check(avcodec_parameters_from_context(stream->codecpar, codec), "describing the stream");
    check(avio_open(&format->pb, file.c_str(), AVIO_FLAG_WRITE), "opening the file");
    format->flags |= AVFMT_FLAG_BITEXACT;
    format->flush_packets = 1;
    AVDictionary* settings = nullptr;
    av_dict_set(&settings, "movflags", "frag_keyframe+empty_moov+default_base_moof", 0);
    av_dict_set_int(&settings, "video_track_timescale", AV_TIME_BASE, 0);
    const int result = avformat_write_header(format, &settings);
    av_dict_free(&settings);
    check(result, "writing the header");
    avio_flush(format->pb);
    begun = true;

    picture->format = codec->pix_fmt;
    picture->width = codec->width;
    picture->height = codec->height;
    check(av_frame_get_buffer(picture, 0), "making room for a frame");
  }

  void convert(const cv::Mat& frame) {
    check(av_frame_make_writable(picture), "making room for a frame");
    if (frame.type() == CV_8UC1) {
      convert_grey(frame);
    } else {
      convert_bgr(frame);
    }
  }

  /// Full range to 16..235, and no colour.
  void convert_grey(const cv::Mat& frame) {
    const auto width = static_cast<std::size_t>(options.width);
    for (int y = 0; y < options.height; ++y) {
      const auto* from = frame.ptr<std::uint8_t>(y);
      std::uint8_t* to = picture->data[0] + static_cast<std::ptrdiff_t>(y) * picture->linesize[0];
      for (std::size_t x = 0; x < width; ++x) to[x] = static_cast<std::uint8_t>(16 + (219 * from[x] + 127) / 255);
    }
    for (const int plane : {1, 2}) {
      for (int y = 0; y < options.height / 2; ++y)
        std::memset(picture->data[plane] + static_cast<std::ptrdiff_t>(y) * picture->linesize[plane], 128, width / 2);
    }
  }

  void convert_bgr(const cv::Mat& frame) {
    if (scaler == nullptr) {
      scaler = sws_getContext(options.width, options.height, AV_PIX_FMT_BGR24, options.width, options.height, codec->pix_fmt,
                              SWS_BILINEAR | SWS_BITEXACT | SWS_ACCURATE_RND, nullptr, nullptr, nullptr);
      if (scaler == nullptr) throw Error(file + ": frames cannot be converted for the encoder; expected libswscale to know BGR");
    }
    const std::size_t stride = static_cast<std::size_t>(frame.cols) * frame.elemSize();
    pixels.resize(stride * static_cast<std::size_t>(frame.rows) + readable_beyond);
    frame.copyTo(cv::Mat(frame.size(), frame.type(), pixels.data(), stride));
    const std::array<const std::uint8_t*, 1> rows{pixels.data()};
    const std::array<int, 1> strides{static_cast<int>(stride)};
    sws_scale(scaler, rows.data(), strides.data(), 0, options.height, picture->data, picture->linesize);
  }

  void encode(const AVFrame* frame) {
    check(avcodec_send_frame(codec, frame), "encoding a frame");
    for (;;) {
      const int result = avcodec_receive_packet(codec, packet);
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
      check(result, "encoding a frame");
      write_waiting(packet->pts);
      if ((packet->flags & AV_PKT_FLAG_KEY) != 0) begin_fragment(packet->pts);
      av_packet_move_ref(waiting, packet);
    }
  }

  void begin_fragment(std::int64_t us) {
    // Otherwise the fragment before this one is written only with the frame after this one.
    if (options.fragment_span.count() > 0 && us > 0) check(av_write_frame(format, nullptr), "writing a fragment");
    fragment_us = us;
  }

  void write_waiting(std::int64_t until_us) {
    if (waiting->data == nullptr) return;
    waiting->stream_index = 0;
    waiting->duration = until_us - waiting->pts;
    last_duration_us = waiting->duration;
    av_packet_rescale_ts(waiting, codec->time_base, format->streams[0]->time_base);
    const int result = av_write_frame(format, waiting);
    av_packet_unref(waiting);
    check(result, "writing a frame");
  }
};

VideoWriter::VideoWriter(const std::filesystem::path& file, const VideoWriterOptions& options)
    : state_(std::make_unique<State>()) {
  state_->file = file.string();
  state_->options = options;
  const auto is_side = [](int side) { return side > 0 && side <= 16384 && side % 2 == 0; };
  if (!is_side(options.width) || !is_side(options.height)) {
    throw Error(fmt::format("{}: {} x {} px is not a size for H.264; expected even sides from 2 to 16384", state_->file,
                            options.width, options.height));
  }
  if (options.quality < 0 || options.quality > 51) {
    throw Error(fmt::format("{}: quality {} is out of range; expected 0 to 51", state_->file, options.quality));
  }
  if (options.frames_per_fragment < 1) {
    throw Error(fmt::format("{}: {} frames per fragment; expected at least 1", state_->file, options.frames_per_fragment));
  }
  if (options.fragment_span.count() < 0) {
    throw Error(fmt::format("{}: fragments of {} us; expected at least 0", state_->file, options.fragment_span.count()));
  }
  state_->open();
}

VideoWriter::~VideoWriter() {
  try {
    close();
  } catch (const Error&) {  // only `close` reports a failure
  }
}

VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

void VideoWriter::write(const cv::Mat& frame, VideoTime t) {
  const VideoWriterOptions& options = state_->options;
  if (frame.cols != options.width || frame.rows != options.height || (frame.type() != CV_8UC1 && frame.type() != CV_8UC3)) {
    throw Error(fmt::format("{}: a frame of {} x {} px, {} bytes a pixel; expected {} x {} px, grey or BGR of 8 bits",
                            state_->file, frame.cols, frame.rows, frame.elemSize(), options.width, options.height));
  }
  const std::int64_t us = us_of(t);
  if (state_->last_us < 0 ? us != 0 : us <= state_->last_us) {
    throw Error(fmt::format("{}: a frame at {} us; expected 0 for the first, then ascending times", state_->file, us));
  }
  state_->convert(frame);
  state_->picture->pts = us;
  const bool begins_fragment = options.fragment_span.count() > 0 && us - state_->fragment_us >= options.fragment_span.count();
  state_->picture->pict_type = begins_fragment ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
  state_->encode(state_->picture);
  state_->last_us = us;
}

void VideoWriter::close() {
  if (!state_ || !state_->begun) return;
  state_->begun = false;
  state_->encode(nullptr);
  state_->write_waiting(state_->last_us + state_->last_duration_us);  // the length of the last frame is not known
  state_->check(av_write_trailer(state_->format), "ending the file");
  state_->check(avio_closep(&state_->format->pb), "closing the file");
}

}  // namespace tactile::video
