#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>

namespace tactile {

/// Executes steps one after the other, in the order of their numbers 0, 1, 2, …, while several threads of a parallel_for prepare
/// them in any order. Work for a lower number must begin first, as in parallel_for. Each number comes once.
class InOrder {
 public:
  /// @param most_ahead  > 0; `later` waits while the next step to execute has a number that is so much lower, or lower still
  explicit InOrder(std::size_t most_ahead) : most_ahead_(most_ahead) {}

  /// Executes the step here or, later, on a thread that calls `later` or `now` too. Unless something fails, all steps are
  /// executed when the last of these calls has returned. After a failure it does nothing.
  /// @throws what one of the executed steps throws; then no further step begins
  void later(std::size_t number, std::function<void()> step);
  /// Waits for the steps with lower numbers, and executes the step here. @return  whether it did; false after a failure
  bool now(std::size_t number, std::function<void()> step);
  /// No further step begins, except one that a thread has already taken. Call it if a step's number will not come, because the
  /// work for it failed, or `later` or `now` threw.
  void fail();

 private:
  void execute(std::unique_lock<std::mutex>& lock);

  std::size_t most_ahead_;
  std::mutex guard_;
  std::condition_variable changed_;
  std::map<std::size_t, std::function<void()>> waiting_;
  std::size_t next_ = 0;
  bool executing_ = false, failed_ = false;
};

}  // namespace tactile
