#include "tactile/robot/growing_log.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/time.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::robot {
namespace fs = std::filesystem;
namespace {

constexpr auto write_every = 100ms;
constexpr auto sync_every = 1s;
constexpr std::size_t most_waiting = std::size_t{32} << 20;  // [bytes] about a minute and a half of a fast controller

/// The lines of `text` that are not empty.
std::uint64_t rows_in(std::string_view text) {
  std::uint64_t rows = 0;
  for (std::size_t begin = 0, end = 0; (end = text.find('\n', begin)) != std::string_view::npos; begin = end + 1) {
    if (end > begin) ++rows;
  }
  return rows;
}

}  // namespace

struct GrowingLog::State {
  fs::path file;
  int descriptor = -1;
  off_t whole = 0;  ///< where the last whole line that was written ends

  mutable std::mutex mutex;
  std::condition_variable woken;
  bool stopping = false;
  std::string waiting;
  std::string error;
  std::uint64_t rows = 0;
  std::thread thread;

  ~State() {
    if (descriptor >= 0) ::close(descriptor);
  }

  void run();
  void write(const std::string& lines);
  void sync();
  void fail(std::string_view what, int reason);
  void stop();
};

void GrowingLog::State::fail(std::string_view what, int reason) {
  const std::lock_guard lock(mutex);
  if (error.empty()) {
    error = fmt::format("{}: {} ({}); expected a writable place with room. What was written is kept", file.string(), what,
                        std::strerror(reason));
  }
  waiting.clear();
}

void GrowingLog::State::write(const std::string& lines) {
  std::size_t done = 0;
  int reason = 0;
  while (done < lines.size()) {
    const ssize_t put = ::pwrite(descriptor, lines.data() + done, lines.size() - done, whole + static_cast<off_t>(done));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) {
      reason = put < 0 ? errno : ENOSPC;
      break;
    }
    done += static_cast<std::size_t>(put);
  }
  // Nothing stays of a row that did not fit whole.
  const std::size_t last_end = std::string_view(lines).substr(0, done).rfind('\n');
  const std::size_t kept = last_end == std::string_view::npos ? 0 : last_end + 1;
  whole += static_cast<off_t>(kept);
  if (kept < done && ::ftruncate(descriptor, whole) != 0 && reason == 0) reason = errno;
  {
    const std::lock_guard lock(mutex);
    rows += rows_in(std::string_view(lines).substr(0, kept));
  }
  if (reason != 0) fail("cannot be written any further", reason);
}

void GrowingLog::State::sync() {
  if (::fdatasync(descriptor) != 0 && errno != EINVAL && errno != EROFS) fail("cannot be synced to the disk", errno);
}

void GrowingLog::State::run() {
  auto synced = std::chrono::steady_clock::now();
  bool dirty = false;
  for (std::string lines;;) {
    bool last = false;
    lines.clear();
    {
      std::unique_lock lock(mutex);
      woken.wait_for(lock, write_every, [&] { return stopping; });
      last = stopping;
      std::swap(lines, waiting);
    }
    if (!lines.empty()) {
      write(lines);
      dirty = true;
    }
    const auto now = std::chrono::steady_clock::now();
    if (dirty && (last || now - synced >= sync_every)) {
      sync();
      synced = now;
      dirty = false;
    }
    if (last) return;
  }
}

void GrowingLog::State::stop() {
  {
    const std::lock_guard lock(mutex);
    stopping = true;
  }
  woken.notify_all();
  if (thread.joinable()) thread.join();
}

GrowingLog::GrowingLog(const fs::path& file, std::string_view header) : state_(std::make_unique<State>()) {
  state_->file = file;
  const auto refuse = [&](int reason) {
    throw Error(
        reason == EEXIST
            ? fmt::format("{}: exists already; expected a new name, a log is never overwritten", file.string())
            : fmt::format("{}: cannot be made ({}); expected a writable place with room", file.string(), std::strerror(reason)));
  };
  std::error_code failed;
  if (fs::exists(fs::symlink_status(file, failed))) refuse(EEXIST);
  if (file.has_parent_path() && !fs::is_directory(file.parent_path(), failed)) refuse(ENOENT);

  // The log grows under its name, but has its header from its first byte on.
  WholeFile begun(file, IfThere::refuse);
  state_->descriptor = ::open(begun.path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (state_->descriptor < 0) refuse(errno);
  state_->write(std::string(header) + "\n");
  if (!state_->error.empty()) throw Error(state_->error);
  if (!begun.commit_if_free()) refuse(EEXIST);
  state_->rows = 0;
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

GrowingLog::~GrowingLog() { state_->stop(); }

void GrowingLog::append(std::string_view lines) {
  const std::lock_guard lock(state_->mutex);
  if (!state_->error.empty()) return;
  if (state_->waiting.size() + lines.size() > most_waiting) {
    state_->error =
        fmt::format("{}: the disk is too slow: {} MB wait to be written; expected it to keep up. What was written is kept",
                    state_->file.string(), most_waiting >> 20);
    return;
  }
  state_->waiting += lines;
}

void GrowingLog::close() {
  state_->stop();
  if (const std::string why = error(); !why.empty()) throw Error(why);
}

std::uint64_t GrowingLog::rows() const {
  const std::lock_guard lock(state_->mutex);
  return state_->rows;
}

std::string GrowingLog::error() const {
  const std::lock_guard lock(state_->mutex);
  return state_->error;
}

}  // namespace tactile::robot
