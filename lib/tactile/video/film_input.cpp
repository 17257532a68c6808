#include "tactile/video/film_input.hpp"

#include <fmt/core.h>

#include <cstdarg>
#include <system_error>
#include <vector>

extern "C" {
#include <libavutil/log.h>
}

#include "tactile/core/error.hpp"

namespace tactile::video {
namespace {

struct Dictionary {
  AVDictionary* entries = nullptr;

  Dictionary() = default;
  Dictionary(const Dictionary&) = delete;
  Dictionary& operator=(const Dictionary&) = delete;
  ~Dictionary() { av_dict_free(&entries); }
};

}  // namespace

FilmInput::FilmInput(const std::filesystem::path& path, microseconds longest_film) : file(path.string()), longest(longest_film) {
  // Its own messages would go to stderr, a page for every damaged frame.
  av_log_set_callback([](void*, int, const char*, va_list) {});
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw Error(file + ": no such file; expected a film");
  AVFormatContext* opened = nullptr;
  Dictionary settings;
  av_dict_set(&settings.entries, "protocol_whitelist", "file", 0);  // a file that names others is no film
  const std::string url = "file:" + std::filesystem::absolute(path).string();
  if (avformat_open_input(&opened, url.c_str(), nullptr, &settings.entries) < 0) refuse("cannot be read");
  format.reset(opened);
  check_header();
  find_stream();
}

void FilmInput::refuse(const std::string& why) const {
  throw Error(fmt::format("{}: {}; expected a film that libavformat reads", file, why));
}

void FilmInput::refuse_length() const {
  throw Error(fmt::format("{}: its frames lie more than {} min apart; expected the film of a run", file,
                          std::chrono::duration_cast<std::chrono::minutes>(longest).count()));
}

void FilmInput::check_header() const {
  for (unsigned i = 0; i < format->nb_streams; ++i) {
    const AVCodecParameters& parameters = *format->streams[i]->codecpar;
    if (parameters.codec_type != AVMEDIA_TYPE_VIDEO) continue;
    if (std::int64_t{parameters.width} * parameters.height > most_film_pixels) {
      throw Error(
          fmt::format("{}: frames of {} x {} px; expected at most 8192 x 4320", file, parameters.width, parameters.height));
    }
  }
  if (format->duration != AV_NOPTS_VALUE && format->duration > longest.count()) refuse_length();
}

void FilmInput::find_stream() {
  std::vector<AVDictionary*> settings(format->nb_streams, nullptr);
  for (AVDictionary*& of_stream : settings) {
    av_dict_set(&of_stream, "threads", "1", 0);
    av_dict_set_int(&of_stream, "max_pixels", most_film_pixels, 0);
  }
  const int result = avformat_find_stream_info(format.get(), settings.data());
  for (AVDictionary*& of_stream : settings) av_dict_free(&of_stream);
  if (result < 0) refuse("cannot be read");
  stream_index = av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (stream_index < 0) refuse("holds no video");
  check_header();
}

}  // namespace tactile::video
