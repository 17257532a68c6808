#include "tactile/core/parallel.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

namespace tactile {
namespace {

/// One call of parallel_for.
struct Job {
  const std::size_t count;
  const std::function<void(std::size_t)>& work;
  std::atomic<std::size_t> next{0};
  std::mutex guard{};
  std::exception_ptr first_failure{};

  // These two under the pool's mutex.
  std::size_t places = 0;   ///< for further helpers
  std::size_t helpers = 0;  ///< that work
  std::condition_variable last_left{};

  void take_work() {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::scoped_lock lock(guard);
        if (!first_failure) first_failure = std::current_exception();
        next = count;
      }
    }
  }
};

/// Threads that help in calls of parallel_for, also in calls from within such a call. They are made when first needed, and sleep
/// between calls: starting threads again takes longer than a step of a training. A call never waits for a helper to come, so it
/// ends even where no thread can be made.
class Pool {
 public:
  /// Never destroyed, because its threads run until the program ends.
  static Pool& instance() {
    static Pool* pool = nullptr;
    static const int registered = [] {
      pool = new Pool;
      return ::pthread_atfork(nullptr, nullptr, [] { pool = new Pool; });  // a child has none of the threads
    }();
    static_cast<void>(registered);
    return *pool;
  }

  void run(Job& job, std::size_t helpers) {
    std::unique_lock lock(guard_);
    job.places = helpers;
    open_.push_back(&job);
    std::size_t wanted = 0;
    for (const Job* each : open_) wanted += each->places;
    while (idle_ < wanted && add_thread()) {
    }
    lock.unlock();
    for (std::size_t i = 0; i < helpers; ++i) wake_.notify_one();
    job.take_work();
    lock.lock();
    std::erase(open_, &job);
    job.last_left.wait(lock, [&] { return job.helpers == 0; });
  }

 private:
  bool add_thread() {
    try {
      std::thread([this] { help(); }).detach();
    } catch (const std::exception&) {
      return false;  // the existing threads do the work
    }
    ++idle_;
    return true;
  }

  [[noreturn]] void help() {
    std::unique_lock lock(guard_);
    while (true) {
      wake_.wait(lock, [&] { return !open_.empty(); });
      Job& job = *open_.front();
      if (--job.places == 0) open_.pop_front();
      --idle_;
      ++job.helpers;
      lock.unlock();
      job.take_work();
      lock.lock();
      ++idle_;
      if (--job.helpers == 0) job.last_left.notify_one();
    }
  }

  std::mutex guard_;
  std::condition_variable wake_;
  std::deque<Job*> open_;  ///< jobs with places for helpers
  std::size_t idle_ = 0;   ///< threads that sleep, or are about to look for a job
};

}  // namespace

void parallel_for(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& work) {
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  Job job{count, work};
  if (std::min<std::size_t>(threads, count) > 1) {
    Pool::instance().run(job, std::min<std::size_t>(threads, count) - 1);
  } else {
    job.take_work();
  }
  if (job.first_failure) std::rethrow_exception(job.first_failure);
}

}  // namespace tactile
