#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <future>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/start_beside.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/pictures/event_film.hpp"
#include "tactile/pictures/picture_folder.hpp"
#include "tactile/video/video_writer.hpp"
#include "view_outputs.hpp"

namespace tactile::cli {
namespace {

constexpr microseconds around_labels = 250ms;  ///< shown before the first onset and after the last end
constexpr microseconds default_length = 10s;   ///< of a recording without labels
constexpr std::size_t most_pictures = 1'000'000, metered_moments = 200;
constexpr int quality = 20;

/// The default range: all touches, or the recording's start.
TickRange range_for(const ViewedRecording& recording, const ViewRequest& request) {
  std::optional<double> from_ms = request.from_ms, to_ms = request.to_ms;
  if (!recording.intervals().empty() && !from_ms && !to_ms) {
    CameraTime end = recording.first();
    for (const TouchInterval& interval : recording.intervals()) end = std::max(end, interval.end);
    from_ms = recording.ms_from_first(before(recording.intervals().front().start, around_labels));
    to_ms = recording.ms_from_first(after(end, around_labels));
  }
  TickRange range = recording.ticks_between(request.options, from_ms, to_ms);
  if (!to_ms) range.count = std::min(range.count, default_length / range.tick + 1);
  return range;
}

/// The tick of each picture: the last one at its time.
std::vector<CameraTime> picture_times(const TickRange& range, const ViewRequest& request, FilmForm form) {
  const double step_us = 1e6 * request.speed / request.fps,
               length_us = static_cast<double>((range.count - 1) * range.tick.count());
  const double count = std::floor(length_us / step_us + 1e-9) + 1;
  if (count > static_cast<double>(most_pictures)) {
    throw Error(fmt::format("{:.0f} pictures; expected at most {}: choose a shorter part, a larger --speed or a smaller --fps",
                            count, most_pictures));
  }
  std::vector<CameraTime> times;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(count); ++i) {
    const std::int64_t index = std::llround(static_cast<double>(i) * step_us) / range.tick.count();
    const CameraTime t = range.at(std::min(index, range.count - 1));
    // Where ticks are further apart than pictures, a film repeats a picture; a folder has one for each tick.
    if (form == FilmForm::mp4 || times.empty() || times.back() < t) times.push_back(t);
  }
  return times;
}

pictures::Brightness brightness_of(ViewedRecording& recording, const heatmaps::HeatmapOptions& options,
                                   const std::vector<CameraTime>& times, const ProgressCallback& progress) {
  std::vector<CameraTime> some;
  const std::size_t count = std::min(times.size(), metered_moments);
  for (std::size_t i = 0; i < count; ++i) some.push_back(times[i * times.size() / count]);
  pictures::BrightnessMeter meter;
  std::uint64_t done = 0;
  pictures::for_moments(recording.reader(), recording.stream_id(), options, some, pictures::MomentDetail::heatmap,
                        [&](const pictures::Moment& moment) {
                          meter.add(moment);
                          report_progress(progress, ++done, some.size(), "brightness");
                        });
  return meter.result();
}

/// The whole recording's curve where it is fine enough, else a new one of this part.
pictures::EventCurve curve_of(ViewedRecording& recording, CameraTime begin, CameraTime end) {
  constexpr std::int64_t fine = 500;  // bins
  if (recording.curve().bin() * fine <= between(begin, end)) return recording.curve();
  pictures::EventCurve curve(begin);
  events::for_events_between(recording.reader(), recording.stream_id(), begin, end, [&](std::span<const events::Event> events) {
    stop_if_interrupted();
    curve.add(events);
  });
  return curve;
}

std::string speed_text(double speed) {
  if (speed == 1) return "real time";
  return speed < 1 ? fmt::format("{:.6g} times slower", 1 / speed) : fmt::format("{:.6g} times faster", speed);
}

/// The pictures of a film.
struct FilmPlan {
  FilmForm form;
  std::vector<CameraTime> times;  ///< a tick for each picture
  pictures::Brightness brightness;
};

pictures::EventFilm film_of(ViewedRecording& recording, const ViewRequest& request, const FilmPlan& plan) {
  const CameraTime begin = before(plan.times.front(), request.options.history);
  const CameraTime end = std::max(plan.times.back(), after(begin, microseconds{1}));
  const std::string speed = plan.form == FilmForm::mp4 ? speed_text(request.speed) + ", " : "";
  return pictures::EventFilm({.title = recording.title(),
                              .remark = fmt::format("{}t_h {:g} ms", speed, in_ms(request.options.history)),
                              .sensor = recording.sensor(),
                              .rendering = request.options,
                              .brightness = plan.brightness,
                              .begin = begin,
                              .end = end,
                              .zero = recording.first(),
                              .intervals = recording.intervals(),
                              .is_labelled = recording.labelled()},
                             curve_of(recording, begin, end));
}

/// Draws every picture and passes it on. @param write  takes the picture's index, its moment and the picture
template <class Write>
void draw_pictures(ViewedRecording& recording, const ViewRequest& request, const FilmPlan& plan, const pictures::EventFilm& film,
                   const ProgressCallback& progress, Write write) {
  std::uint64_t drawn = 0;
  pictures::for_moments(recording.reader(), recording.stream_id(), request.options, plan.times, pictures::MomentDetail::heatmap,
                        [&](const pictures::Moment& moment) {
                          report_progress(progress, drawn, plan.times.size(),
                                          fmt::format("{:.1f} ms", recording.ms_from_first(moment.t)));
                          write(drawn, moment, film.picture_of(moment));
                          ++drawn;
                        });
}

void write_mp4(ViewedRecording& recording, const ViewRequest& request, const FilmPlan& plan, const pictures::EventFilm& film,
               unsigned threads, const ProgressCallback& progress) {
  WholeFile whole(request.out, IfThere::replace);
  video::VideoWriter writer(whole.path(), {.width = film.size().width,
                                           .height = film.size().height,
                                           .quality = quality,
                                           .frames_per_fragment = 50,
                                           .fast = true,
                                           .fragment_span = microseconds{0}});
  // One picture is encoded while the next one is drawn: both take about as long.
  std::future<void> encoding;
  draw_pictures(recording, request, plan, film, progress,
                [&](std::uint64_t index, const pictures::Moment&, const cv::Mat& picture) {
                  const VideoTime t{microseconds{std::llround(1e6 * static_cast<double>(index) / request.fps)}};
                  if (encoding.valid()) encoding.get();
                  encoding = start_beside(threads, [&writer, picture, t] { writer.write(picture, t); });
                });
  if (encoding.valid()) encoding.get();
  writer.close();
  stop_if_interrupted();
  whole.commit();
}

void write_folder(ViewedRecording& recording, const ViewRequest& request, const FilmPlan& plan, const pictures::EventFilm& film,
                  const ProgressCallback& progress) {
  pictures::PictureFolder folder(request.out, "t_us,since_first_event_ms,events,label");
  draw_pictures(recording, request, plan, film, progress,
                [&](std::uint64_t index, const pictures::Moment& moment, const cv::Mat& picture) {
                  const std::string name = fmt::format("picture-{:06}.png", index);
                  const std::optional<Touch> touch = film.touch_at(moment.t);
                  folder.write(name, picture);
                  folder.list(name, us_of(moment.t), fmt::format("{:.3f}", recording.ms_from_first(moment.t)), moment.events,
                              touch ? name_of(*touch) : std::string_view());
                });
  stop_if_interrupted();
  folder.commit();
}

void print_film(const ViewedRecording& recording, const ViewRequest& request, const FilmPlan& plan,
                const pictures::EventFilm& film, const CommonArguments& common) {
  const std::size_t drawn = plan.times.size();
  const double from_ms = recording.ms_from_first(plan.times.front()), to_ms = recording.ms_from_first(plan.times.back());
  const events::SensorSize size = heatmaps::heatmap_size(recording.sensor(), request.options.factor);
  nlohmann::json result = recording.json();
  result.update({{"out", request.out.string()},
                 {"form", plan.form == FilmForm::mp4 ? "film" : "folder"},
                 {"heatmap", {{"width", size.width}, {"height", size.height}}},
                 {"settings", request.options},
                 {"brightest", {{"events_per_pixel", plan.brightness.counts}, {"heatmap", plan.brightness.heatmap}}},
                 {"width", film.size().width},
                 {"height", film.size().height},
                 {"pictures", drawn},
                 {"from_ms", from_ms},
                 {"to_ms", to_ms}});
  std::string text = fmt::format("{}: {} picture{}", request.out.string(), drawn, drawn == 1 ? "" : "s");
  if (plan.form == FilmForm::mp4) {
    const double seconds = static_cast<double>(drawn) / request.fps;
    result.update({{"fps", request.fps}, {"speed", request.speed}, {"seconds", seconds}});
    text += fmt::format(", {:.1f} s at {:g} per second, {}", seconds, request.fps, speed_text(request.speed));
  }
  text += fmt::format("; {:.1f} to {:.1f} of {:.1f} ms of {}\n", from_ms, to_ms, recording.ms_from_first(recording.last()),
                      recording.name());
  print_result(common, result, text);
}

}  // namespace

void view_as_film(ViewedRecording& recording, const ViewRequest& request, FilmForm form, const CommonArguments& common) {
  FilmPlan plan{.form = form, .times = picture_times(range_for(recording, request), request, form), .brightness = {}};
  if (form == FilmForm::folder) pictures::check_picture_folder(request.out);
  const ProgressCallback progress = progress_line(common);
  plan.brightness = brightness_of(recording, request.options, plan.times, progress);
  const pictures::EventFilm film = film_of(recording, request, plan);
  if (form == FilmForm::mp4)
    write_mp4(recording, request, plan, film, common.threads, progress);
  else
    write_folder(recording, request, plan, film, progress);
  print_film(recording, request, plan, film, common);
}

}  // namespace tactile::cli
