#include "tactile/video/video_capture.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/video/film_picture.hpp"
#include "tactile/video/filmed_times.hpp"
#include "tactile/video/frame_clock.hpp"
#include "tactile/video/video_source.hpp"
#include "tactile/video/video_writer.hpp"

namespace tactile::video {
namespace fs = std::filesystem;
namespace {

using Steady = std::chrono::steady_clock;

constexpr int broken_in_a_row = 100;                           // frames that cannot be decoded, before a source counts as gone
constexpr microseconds kept_per_kill = 1s;                     // film between two syncs: a power cut takes no more
constexpr std::size_t waiting_bytes = std::size_t{512} << 20;  // frames that wait: a 4K camera's would take gigabytes

struct TimedFrame {
  cv::Mat picture;
  microseconds t{0};  ///< on the source's line of time
  HostTime came{};
  bool is_own = false;  ///< the time is the source's, and not its arrival

  std::size_t bytes() const { return picture.total() * picture.elemSize(); }
};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// Makes an empty file, which must not be there yet.
std::unique_ptr<std::FILE, CloseFile> new_file(const fs::path& path) {
  std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "wbxe"));
  if (file == nullptr) {
    const int error = errno;
    throw Error(
        fmt::format("{}: {}; expected {}", path.string(),
                    error == EEXIST ? "the file exists already" : std::string("cannot be made (") + std::strerror(error) + ")",
                    error == EEXIST ? "a new name" : "a writable place with room"));
  }
  return file;
}

/// One film: an MP4, and the times of its frames.
class Film {
 public:
  Film(const fs::path& mp4, fs::path csv, cv::Size size, int quality) : mp4_(mp4), csv_(std::move(csv)), size_(size) {
    new_file(mp4_);
    try {
      rows_ = new_file(csv_);
      VideoWriterOptions options;
      options.width = film_size(size).width;
      options.height = film_size(size).height;
      options.quality = quality;
      options.fragment_span = kept_per_kill;
      writer_.emplace(mp4_, options);
      write_row(std::string(filmed_columns) + "\n");
      sync();
      sync_to_disk(csv_.has_parent_path() ? csv_.parent_path() : fs::path("."));
    } catch (...) {
      std::error_code ignored;
      writer_.reset();
      fs::remove(mp4_, ignored);
      if (rows_ != nullptr) fs::remove(csv_, ignored);
      throw;
    }
  }

  /// @return false if the frame's pixels cannot be filmed. @throws Error if it cannot be written
  bool write(const TimedFrame& frame) {
    const cv::Mat picture = film_picture(frame.picture, size_);
    if (picture.empty()) return false;
    if (index_ == 0) begin_ = frame.t;
    const VideoTime t{frame.t - begin_};
    writer_->write(picture, t);
    write_row(filmed_row(index_++, t, frame.came));
    if (Steady::now() - synced_ >= kept_per_kill) sync();
    return true;
  }

  cv::Size size() const { return size_; }

  void end() {
    writer_->close();
    sync();
    if (std::fclose(rows_.release()) != 0)
      throw Error(fmt::format("{}: cannot be closed ({}); expected a disk with room", csv_.string(), std::strerror(errno)));
  }

 private:
  void write_row(const std::string& row) {
    if (std::fwrite(row.data(), 1, row.size(), rows_.get()) != row.size() || std::fflush(rows_.get()) != 0)
      throw Error(fmt::format("{}: cannot be written ({}); expected a place with room", csv_.string(), std::strerror(errno)));
  }

  void sync() {
    sync_to_disk(mp4_);
    sync_to_disk(csv_);
    synced_ = Steady::now();
  }

  fs::path mp4_, csv_;
  cv::Size size_;
  std::optional<VideoWriter> writer_;
  std::unique_ptr<std::FILE, CloseFile> rows_;
  std::uint64_t index_ = 0;
  microseconds begin_{0};
  Steady::time_point synced_ = Steady::now();
};

}  // namespace

struct VideoCapture::State {
  VideoCaptureOptions options;
  std::unique_ptr<VideoSource> source;  // used by the grabbing thread only, once it runs
  std::optional<FrameClock> clock;      // used by the grabbing thread only, once it runs

  mutable std::mutex guard;  // of all that follows
  std::condition_variable work, room, changed;
  std::deque<TimedFrame> queue;
  std::size_t queued_bytes = 0;
  std::unique_ptr<Film> film;
  bool film_ending = false;
  bool film_closed = false;
  bool filmed_before = false;
  bool running = true;
  bool stopping = false;
  cv::Size size;   ///< of the last frame
  cv::Mat newest;  ///< its picture
  std::deque<Steady::time_point> last_second;
  std::uint64_t frames = 0, dropped = 0;
  ClockPairs<VideoClock> times;  ///< of the film's frames, by the source and by the host
  std::string error;

  std::thread grabber, encoder;

  ~State() {
    {
      const std::scoped_lock lock(guard);
      stopping = true;
      film_ending = true;
    }
    room.notify_all();
    work.notify_all();
    if (grabber.joinable()) grabber.join();
    work.notify_all();
    if (encoder.joinable()) encoder.join();
  }

  void log(const std::string& text) const {
    if (options.log) options.log("video " + options.source + ": " + text);
  }

  /// The next frame that can be decoded and has its own time; nothing once the source has ended.
  std::optional<TimedFrame> next_frame() {
    for (int broken = 0; broken < broken_in_a_row;) {
      if (!source->grab()) return std::nullopt;
      TimedFrame frame;
      frame.came = host_now();
      const double source_ms = source->time_ms();
      if (!source->decode(frame.picture)) {
        ++broken;
        drop(1);
        continue;
      }
      if (const std::optional<microseconds> t = clock->time_of(source_ms, frame.came)) {
        frame.t = *t;
        frame.is_own = clock->is_own();
        return frame;
      }
      drop(1);
      const std::scoped_lock lock(guard);
      if (stopping) return std::nullopt;
    }
    return std::nullopt;
  }

  void drop(std::uint64_t count) {
    const std::scoped_lock lock(guard);
    if (film != nullptr && !film_ending) dropped += count;
  }

  // Grabbing

  void grab_frames(TimedFrame frame) {
    std::string why = source->is_recorded() ? "has ended" : "gives no more frames";
    try {
      if (source->is_recorded()) wait_for_a_film();
      const Steady::time_point begun = Steady::now();
      const microseconds begin = frame.t;
      bool stopped = false;
      while (!stopped) {
        if (source->is_recorded()) {
          if (options.speed > 0) wait_until(begun, frame.t - begin);
          frame.came = host_now();
        }
        hand_over(std::move(frame));
        std::optional<TimedFrame> next = next_frame();
        if (!next) break;
        frame = std::move(*next);
        const std::scoped_lock lock(guard);
        stopped = stopping;
      }
    } catch (const std::exception& e) {
      why = fmt::format("gives no more frames ({})", e.what());
    }
    source->close();
    std::unique_lock lock(guard);
    const bool asked = stopping;
    lock.unlock();
    if (!asked) log(why);
    lock.lock();
    running = false;
    lock.unlock();
    work.notify_all();
  }

  /// A recorded source can wait: its first frame is the first film's.
  void wait_for_a_film() {
    std::unique_lock lock(guard);
    room.wait(lock, [&] { return stopping || filmed_before; });
  }

  void wait_until(Steady::time_point begun, microseconds t) {
    const std::chrono::duration<double, std::micro> after(static_cast<double>(t.count()) / options.speed);
    // A wait of years would overflow the clock.
    const auto due = begun + std::chrono::duration_cast<Steady::duration>(
                                 std::min(after, std::chrono::duration<double, std::micro>(std::chrono::hours(24 * 365))));
    std::unique_lock lock(guard);
    room.wait_until(lock, due, [&] { return stopping; });
  }

  void hand_over(TimedFrame frame) {
    std::unique_lock lock(guard);
    const auto now = Steady::now();
    last_second.push_back(now);
    while (now - last_second.front() > std::chrono::seconds(1)) last_second.pop_front();
    size = frame.picture.size();
    newest = frame.picture;
    const auto is_filmed = [&] { return film != nullptr && !film_ending && error.empty(); };
    const auto has_room = [&] {
      return queue.empty() || (queue.size() < options.queue && queued_bytes + frame.bytes() <= waiting_bytes);
    };
    // At full speed no frame of a recorded film is dropped.
    if (source->is_recorded() && options.speed == 0)
      room.wait(lock, [&] { return stopping || (is_filmed() && has_room()) || !error.empty(); });
    if (film == nullptr || film_ending) return;
    if (!error.empty() || !has_room()) {
      ++dropped;
      return;
    }
    const bool has_pace = !source->is_recorded() || options.speed == 1;
    if (frame.is_own && has_pace) times.add({VideoTime{frame.t}, frame.came});
    queued_bytes += frame.bytes();
    queue.push_back(std::move(frame));
    lock.unlock();
    work.notify_one();
  }

  // Encoding

  void encode_frames() {
    std::unique_lock lock(guard);
    const auto film_is_over = [&] { return film != nullptr && (film_ending || (!running && !film_closed)); };
    for (;;) {
      work.wait(lock, [&] { return !queue.empty() || film_is_over() || (stopping && film == nullptr); });
      if (!queue.empty()) {
        encode_one(lock);
      } else if (film != nullptr) {
        end_film(lock);
      } else {
        return;
      }
    }
  }

  void encode_one(std::unique_lock<std::mutex>& lock) {
    const TimedFrame frame = std::move(queue.front());
    queue.pop_front();
    queued_bytes -= frame.bytes();
    lock.unlock();
    room.notify_one();
    bool written = false;
    std::string failed;
    try {
      written = film->write(frame);
    } catch (const std::exception& e) {
      failed = e.what();
    }
    if (!failed.empty()) log("the film cannot continue: " + failed);
    lock.lock();
    ++(written ? frames : dropped);
    if (failed.empty()) return;
    error = failed;
    dropped += queue.size();
    queue.clear();
    queued_bytes = 0;
    room.notify_one();
  }

  /// Closes the film, also where its source has ended: it is whole then. Forgets it only once it is not wanted.
  void end_film(std::unique_lock<std::mutex>& lock) {
    if (!film_closed) {
      lock.unlock();
      std::string failed;
      try {
        film->end();
      } catch (const std::exception& e) {
        failed = e.what();
      }
      lock.lock();
      film_closed = true;
      if (error.empty()) error = failed;
    }
    if (!film_ending) return;
    film.reset();
    changed.notify_all();
  }
};

VideoCapture::VideoCapture(VideoCaptureOptions options) : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.options = std::move(options);
  const std::string& source = state.options.source;
  if (!std::isfinite(state.options.speed) || state.options.speed < 0)
    throw Error(fmt::format("{}: speed {}; expected 0 or more", source, state.options.speed));
  if (state.options.queue == 0) throw Error(source + ": a queue of 0 frames; expected at least 1");
  if (state.options.quality < 0 || state.options.quality > 51)
    throw Error(fmt::format("{}: quality {} is out of range; expected 0 to 51", source, state.options.quality));
  host_now();  // its clock begins with the first call: not in the middle of a film
  state.source = open_video_source(source);
  state.clock.emplace(!state.source->is_recorded(), state.source->nominal_step());
  std::optional<TimedFrame> first = state.next_frame();
  if (!first) throw Error(source + ": gives no frame; expected a video or a camera that runs");
  state.size = first->picture.size();
  state.grabber = std::thread([&state, frame = std::move(*first)]() mutable { state.grab_frames(std::move(frame)); });
  state.encoder = std::thread([&state] { state.encode_frames(); });
}

VideoCapture::~VideoCapture() = default;

void VideoCapture::start_film(const fs::path& mp4, const fs::path& csv) {
  State& state = *state_;
  cv::Size size;
  {
    const std::scoped_lock lock(state.guard);
    if (state.film != nullptr) throw Error(mp4.string() + ": another film is being made; expected it to be stopped first");
    if (!state.running) throw Error(mp4.string() + ": cannot be filmed, " + state.options.source + " gives no more frames");
    size = state.size;
  }
  auto film = std::make_unique<Film>(mp4, csv, size, state.options.quality);
  const std::scoped_lock lock(state.guard);
  state.film = std::move(film);
  state.film_ending = state.film_closed = false;
  state.filmed_before = true;
  state.frames = state.dropped = 0;
  state.times = ClockPairs<VideoClock>();
  state.error.clear();
  state.room.notify_all();
  state.work.notify_all();  // the source may have ended meanwhile
}

void VideoCapture::stop_film() {
  State& state = *state_;
  std::unique_lock lock(state.guard);
  if (state.film == nullptr) return;
  state.film_ending = true;
  state.work.notify_all();
  state.changed.wait(lock, [&] { return state.film == nullptr; });
  if (!state.error.empty()) throw Error(state.error);
}

cv::Mat VideoCapture::newest_picture() const {
  const std::scoped_lock lock(state_->guard);
  return state_->newest;
}

VideoCaptureState VideoCapture::state() const {
  const State& state = *state_;
  const std::scoped_lock lock(state.guard);
  const auto now = Steady::now();
  const auto recent = std::count_if(state.last_second.begin(), state.last_second.end(),
                                    [&](Steady::time_point came) { return now - came <= std::chrono::seconds(1); });
  return {.running = state.running,
          .frames_per_second = static_cast<double>(recent),
          .frames = state.frames,
          .dropped = state.dropped,
          .queued = state.queue.size(),
          .clock = state.times.offset(),
          .error = state.error};
}

}  // namespace tactile::video
