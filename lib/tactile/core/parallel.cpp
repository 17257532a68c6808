#include "tactile/core/parallel.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace tactile {
namespace {

/// The threads of a call of parallel_for that is not within another, and of all calls within it. Under the pool's mutex.
struct Team {
  const std::size_t limit;                         ///< of threads that work
  std::size_t working = 1;                         ///< the caller
  std::condition_variable* idle_caller = nullptr;  ///< from when the caller has no work of its own call left
};

thread_local Team* current_team = nullptr;

/// One call of parallel_for.
struct Job {
  const std::size_t count;
  const std::function<void(std::size_t)>& work;
  Team& team;
  std::atomic<std::size_t> next{0};
  std::mutex guard{};
  std::exception_ptr first_failure{};

  // These two under the pool's mutex.
  std::size_t places = 0;   ///< for further helpers
  std::size_t helpers = 0;  ///< that work
  std::condition_variable last_left{};

  void take_work() {
    Team* const before = std::exchange(current_team, &team);
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::scoped_lock lock(guard);
        if (!first_failure) first_failure = std::current_exception();
        next = count;
      }
    }
    current_team = before;
  }
};

/// Threads that help in calls of parallel_for. They are made when first needed, and sleep between calls: starting threads again
/// takes longer than a step of a training. A call never waits for a helper to come, so it ends even where no thread can be made.
/// Calls within a call share its threads: a helper, or the outermost caller, who finds no work left in one of them helps in
/// another. The caller of a call within waits for its helpers.
class Pool {
 public:
  /// Never destroyed, because its threads run until the program ends.
  static Pool& instance() {
    static Pool* pool = nullptr;
    static const int registered = [] {
      pool = new Pool;
      return ::pthread_atfork(nullptr, nullptr, [] {  // a child has none of the threads
        pool = new Pool;
        current_team = nullptr;
      });
    }();
    static_cast<void>(registered);
    return *pool;
  }

  /// @param outermost  the call is not within another
  void run(Job& job, std::size_t helpers, bool outermost) {
    std::unique_lock lock(guard_);
    job.places = helpers;
    open_.push_back(&job);
    while (idle_ < wanted() && add_thread()) {
    }
    const std::size_t free = std::min(helpers, job.team.limit - job.team.working);
    if (job.team.idle_caller != nullptr) job.team.idle_caller->notify_one();
    lock.unlock();
    for (std::size_t i = 0; i < free; ++i) wake_.notify_one();
    job.take_work();
    lock.lock();
    std::erase(open_, &job);
    if (!outermost) {
      job.last_left.wait(lock, [&] { return job.helpers == 0; });
      return;
    }
    job.team.idle_caller = &job.last_left;
    for (Job* other = nullptr; job.helpers > 0;) {
      job.last_left.wait(lock, [&] { return job.helpers == 0 || (other = open_job_of(&job.team)) != nullptr; });
      if (job.helpers > 0) help_in(*other, lock);
    }
  }

 private:
  /// The number of threads that open jobs can still use: of each team no more than it may have.
  std::size_t wanted() const {
    std::size_t wanted = 0;
    for (auto first = open_.begin(); first != open_.end(); ++first) {
      const Team& team = (*first)->team;
      const auto is_of_team = [&](const Job* job) { return &job->team == &team; };
      if (std::any_of(open_.begin(), first, is_of_team)) continue;  // is counted
      std::size_t places = 0;
      for (const Job* job : open_) places += is_of_team(job) ? job->places : 0;
      wanted += std::min(places, team.limit - team.working);
    }
    return wanted;
  }

  bool add_thread() {
    try {
      std::thread([this] { help(); }).detach();
    } catch (const std::exception&) {
      return false;  // the existing threads do the work
    }
    ++idle_;
    return true;
  }

  /// The oldest job with places for helpers, of this team or of any that may have a further thread; null: there is none.
  Job* open_job_of(const Team* team) {
    const auto found = std::find_if(open_.begin(), open_.end(), [team](const Job* job) {
      return job->places > 0 && (team != nullptr ? &job->team == team : job->team.working < job->team.limit);
    });
    return found == open_.end() ? nullptr : *found;
  }

  void help_in(Job& job, std::unique_lock<std::mutex>& lock) {
    --job.places;
    ++job.helpers;
    lock.unlock();
    job.take_work();
    lock.lock();
    if (--job.helpers == 0) job.last_left.notify_one();
  }

  [[noreturn]] void help() {
    std::unique_lock lock(guard_);
    while (true) {
      Job* job = nullptr;
      wake_.wait(lock, [&] { return (job = open_job_of(nullptr)) != nullptr; });
      Team& team = job->team;
      --idle_;
      ++team.working;
      for (; job != nullptr; job = open_job_of(&team)) help_in(*job, lock);
      --team.working;
      ++idle_;
    }
  }

  std::mutex guard_;
  std::condition_variable wake_;
  std::deque<Job*> open_;  ///< calls whose caller still works; some have no place or no work left
  std::size_t idle_ = 0;   ///< threads that sleep, or are about to look for a job
};

}  // namespace

unsigned threads_or_all(unsigned threads) {
  if (threads > 0) return threads;
  // A cluster may bind this process to some cores of a machine.
  cpu_set_t cores;
  CPU_ZERO(&cores);
  if (::sched_getaffinity(0, sizeof cores, &cores) == 0) return static_cast<unsigned>(CPU_COUNT(&cores));
  return std::max(1U, std::thread::hardware_concurrency());  // more than 1024
}

void parallel_for(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& work) {
  threads = threads_or_all(threads);
  Team own{.limit = threads};
  const bool outermost = current_team == nullptr;
  Job job{count, work, outermost ? own : *current_team};
  if (const std::size_t most = std::min<std::size_t>(threads, count); most > 1) {
    Pool::instance().run(job, most - 1, outermost);
  } else {
    job.take_work();
  }
  if (job.first_failure) std::rethrow_exception(job.first_failure);
}

}  // namespace tactile
