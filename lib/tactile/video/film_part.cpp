#include "tactile/video/film_part.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/video/film_input.hpp"

namespace tactile::video {
namespace fs = std::filesystem;
namespace {

constexpr microseconds any_length = microseconds::max();

struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
using Packet = std::unique_ptr<AVPacket, FreePacket>;

Packet new_packet() {
  Packet packet(av_packet_alloc());
  if (!packet) throw Error("a film: no memory for a frame; expected some MB");
  return packet;
}

/// An MP4 that takes packets as another file has them.
class PartWriter {
 public:
  PartWriter(const fs::path& file, const AVStream& from) : name_(file.string()), from_(from.time_base) {
    AVFormatContext* format = nullptr;
    check(avformat_alloc_output_context2(&format, nullptr, "mp4", name_.c_str()));
    format_.reset(format);
    AVStream* stream = avformat_new_stream(format, nullptr);
    if (stream == nullptr) throw Error(name_ + ": no memory for the film; expected some MB");
    check(avcodec_parameters_copy(stream->codecpar, from.codecpar));
    stream->codecpar->codec_tag = 0;  // that of another container may not be one of MP4
    stream->time_base = from_;
    check(avio_open(&format->pb, name_.c_str(), AVIO_FLAG_WRITE));
    format->flags |= AVFMT_FLAG_BITEXACT;
    AVDictionary* settings = nullptr;
    av_dict_set(&settings, "movflags", "frag_keyframe+empty_moov+default_base_moof", 0);
    if (from_.num == 1) av_dict_set_int(&settings, "video_track_timescale", from_.den, 0);
    const int result = avformat_write_header(format, &settings);
    av_dict_free(&settings);
    check(result);
  }

  void write(AVPacket& packet) {
    if (first_ == AV_NOPTS_VALUE) first_ = packet.pts;
    packet.pts -= first_;
    packet.dts = packet.dts == AV_NOPTS_VALUE ? packet.pts : packet.dts - first_;
    packet.stream_index = 0;
    packet.pos = -1;
    av_packet_rescale_ts(&packet, from_, format_->streams[0]->time_base);
    check(av_write_frame(format_.get(), &packet));
  }

  void close() {
    check(av_write_trailer(format_.get()));
    check(avio_closep(&format_->pb));
  }

 private:
  void check(int result) const {
    if (result >= 0) return;
    throw Error(name_ + ": the part of the film cannot be written as MP4; expected a coding that MP4 has, and a disk with room");
  }

  struct Free {
    void operator()(AVFormatContext* format) const {
      if (format->pb != nullptr) avio_closep(&format->pb);
      avformat_free_context(format);
    }
  };
  std::string name_;
  AVRational from_;
  std::unique_ptr<AVFormatContext, Free> format_;
  std::int64_t first_ = AV_NOPTS_VALUE;
};

/// Hands each packet of the video that is shown to `use`, in the order of the file, until it returns false.
template <class Use>
void for_packets(FilmInput& film, const Use& use) {
  const Packet packet = new_packet();
  for (bool wants_more = true; wants_more && av_read_frame(film.format.get(), packet.get()) >= 0;) {
    const bool is_shown = packet->stream_index == film.stream_index && (packet->flags & AV_PKT_FLAG_DISCARD) == 0;
    if (is_shown) wants_more = use(*packet);
    av_packet_unref(packet.get());
  }
}

}  // namespace

std::size_t FilmFrames::key_before(std::size_t frame) const {
  while (frame > 0 && !is_key[frame]) --frame;
  return frame;
}

FilmFrames film_frames(const fs::path& path) {
  FilmInput film(path, any_length);
  std::vector<std::pair<std::int64_t, bool>> found;  // time, and whether it is a key frame
  for_packets(film, [&](const AVPacket& packet) {
    if (packet.pts == AV_NOPTS_VALUE) film.refuse("a frame has no time of its own");
    found.emplace_back(packet.pts, (packet.flags & AV_PKT_FLAG_KEY) != 0);
    return true;
  });
  if (found.empty()) film.refuse("holds no frame");
  const auto by_time = [](const auto& a, const auto& b) { return a.first < b.first; };
  FilmFrames frames;
  frames.is_in_order = std::is_sorted(found.begin(), found.end(), by_time);
  std::stable_sort(found.begin(), found.end(), by_time);
  for (const auto& [stamp, is_key] : found) {
    if (!frames.stamps.empty() && stamp == frames.stamps.back()) film.refuse("two frames have one time");
    const std::int64_t since_first = saturating_subtract(stamp, found.front().first);
    frames.times_us.push_back(av_rescale_q(since_first, film.stream().time_base, AVRational{1, 1'000'000}));
    frames.is_key.push_back(is_key);
    frames.stamps.push_back(stamp);
  }
  return frames;
}

FilmPart copy_film_part(const fs::path& path, const FilmFrames& frames, FilmPart part, const fs::path& to) {
  const std::size_t count = frames.stamps.size();
  if (part.begin >= part.end || part.end > count)
    throw Error(fmt::format("{}: has no frames from {} to {}, only {}; expected a part of the film", path.string(), part.begin,
                            part.end, count));
  part.begin = frames.key_before(part.begin);
  while (!frames.is_in_order && part.end < count && !frames.is_key[part.end]) ++part.end;
  auto film = std::make_unique<FilmInput>(path, any_length);
  if (av_seek_frame(film->format.get(), film->stream_index, frames.stamps[part.begin], AVSEEK_FLAG_BACKWARD) < 0)
    film = std::make_unique<FilmInput>(path, any_length);
  PartWriter writer(to, film->stream());
  std::size_t written = 0;
  for_packets(*film, [&](AVPacket& packet) {
    const auto place = static_cast<std::size_t>(std::lower_bound(frames.stamps.begin(), frames.stamps.end(), packet.pts) -
                                                frames.stamps.begin());
    const bool is_key = (packet.flags & AV_PKT_FLAG_KEY) != 0;
    if (place >= part.end) return !(frames.is_in_order || is_key);
    if (place < part.begin) return true;
    writer.write(packet);
    ++written;
    return true;
  });
  writer.close();
  if (written != part.end - part.begin)
    throw Error(fmt::format("{}: {} of {} frames could be copied; expected a film that can be read from any key frame",
                            path.string(), written, part.end - part.begin));
  return part;
}

}  // namespace tactile::video
