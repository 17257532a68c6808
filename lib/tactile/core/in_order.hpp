#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>

namespace tactile {

/// Executes steps one after the other, in the order of their numbers 0, 1, 2, …, while several threads of a parallel_for prepare
/// them in any order. Threads must begin with the work for lower numbers first, as parallel_for does.
class InOrder {
 public:
  /// @param most_waiting  steps that may wait for lower ones; > 0. A thread that brings a further one waits.
  explicit InOrder(std::size_t most_waiting) : most_waiting_(most_waiting) {}

  /// Executes the step here or, later, on a thread that calls `later` or `now` too. All are executed when the last of these calls
  /// has returned. @throws what one of the executed steps throws; then no further step is executed
  void later(std::size_t number, std::function<void()> step);
  /// The same, and waits for it. @return  whether it was executed; false: a step or the work of another thread failed
  bool now(std::size_t number, std::function<void()> step);
  /// No further step is executed. Call it if the work for a step fails: its number will not come.
  void fail();

 private:
  std::size_t most_waiting_;
  std::mutex guard_;
  std::condition_variable changed_;
  std::map<std::size_t, std::function<void()>> waiting_;
  std::size_t next_ = 0;
  bool executing_ = false, failed_ = false;
};

}  // namespace tactile
