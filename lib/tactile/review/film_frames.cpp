#include "tactile/review/film_frames.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/video/film_reader.hpp"
#include "tactile/video/picture_codec.hpp"
#include "tactile/video/shown_times.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::review {

FilmFrames::FilmFrames(const RunFolder& run, const std::function<void()>& advance) : pictures_(std::tmpfile(), std::fclose) {
  if (!pictures_)
    throw Error(run.name() + ": no temporary file for the film's pictures can be made; expected a folder for them with room");
  video::FilmReader film(run.video());
  std::vector<std::optional<std::int64_t>> by_container;
  std::vector<Place> places;
  std::int64_t offset = 0;
  while (const std::optional<video::FilmReader::Frame> frame = film.next()) {
    if (advance) advance();
    cv::Mat grey;
    if (!film.grey(video::widest_page_picture, grey)) continue;
    const std::vector<unsigned char> jpeg = video::page_jpeg_of(grey, run.video().string());
    if (std::fwrite(jpeg.data(), 1, jpeg.size(), pictures_.get()) != jpeg.size())
      throw Error(run.name() + ": the film's pictures do not fit into the folder of temporary files; expected room there");
    by_container.push_back(frame->us);
    places.push_back({offset, jpeg.size()});
    offset += static_cast<std::int64_t>(jpeg.size());
    width_ = grey.cols;
    height_ = grey.rows;
  }
  std::fflush(pictures_.get());
  const std::vector<VideoTime> rows =
      std::filesystem::exists(run.video_times()) ? video::read_video_times(run.video_times()) : std::vector<VideoTime>();
  const auto times = video::shown_times(by_container, film.frame_times(), rows);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!times[i] || (!times_.empty() && *times[i] <= times_.back())) continue;
    times_.push_back(*times[i]);
    places_.push_back(places[i]);
  }
  if (times_.empty()) throw Error(run.video().string() + ": has no frame with a time; expected a film");
}

FilmFrames::~FilmFrames() = default;

std::string FilmFrames::jpeg(std::size_t index) const {
  const Place& place = places_.at(index);
  std::string bytes(place.size, '\0');
  if (::pread(fileno(pictures_.get()), bytes.data(), bytes.size(), place.offset) != static_cast<ssize_t>(bytes.size()))
    throw Error("a picture of the film cannot be read back; expected the folder of temporary files to stay");
  return bytes;
}

}  // namespace tactile::review
