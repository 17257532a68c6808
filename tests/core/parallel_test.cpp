#include "tactile/core/parallel.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <set>
#include <span>
#include <thread>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

std::vector<int> calls_of_each(std::size_t count, unsigned threads) {
  std::vector<std::atomic<int>> calls(count);
  parallel_for(count, threads, [&](std::size_t i) { ++calls[i]; });
  return {calls.begin(), calls.end()};
}

TEST(ParallelFor, CallsEachIndexOnce) {
  for (const unsigned threads : {0U, 1U, 2U, 7U}) {
    for (const std::size_t count : {0U, 1U, 2U, 1000U})
      EXPECT_EQ(calls_of_each(count, threads), std::vector<int>(count, 1)) << threads << " threads, " << count;
  }
}

TEST(ParallelFor, UsesAsManyThreadsAsAsked) {
  constexpr std::size_t threads = 5;
  std::atomic<std::size_t> there{0};
  std::vector<std::thread::id> ids(threads);
  parallel_for(threads, threads, [&](std::size_t i) {
    ids[i] = std::this_thread::get_id();
    ++there;
    while (there < threads) std::this_thread::yield();  // each call waits for the others, so each needs a thread
  });
  EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), threads);
}

TEST(ParallelFor, OneThreadIsTheCallersAlone) {
  parallel_for(50, 1, [caller = std::this_thread::get_id()](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), caller); });
}

TEST(ParallelFor, GivesEachThreadAMemoryOfItsOwn) {
  std::vector<std::vector<std::size_t>> memories(3);
  parallel_for_with(std::span(memories), 1000, [](std::size_t i, std::vector<std::size_t>& own) { own.push_back(i); });
  std::vector<std::size_t> all;
  for (const auto& own : memories) all.insert(all.end(), own.begin(), own.end());
  std::sort(all.begin(), all.end());
  ASSERT_EQ(all.size(), 1000U);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], i);
}

TEST(ParallelFor, WithMemoriesBeginsNoCallAfterAFailure) {
  std::vector<int> memories(2);
  std::atomic<int> calls{0};
  const auto fail = [&](std::size_t, int&) {
    ++calls;
    throw Error("broken");
  };
  EXPECT_THROW(parallel_for_with(std::span(memories), 1000, fail), Error);
  EXPECT_LE(calls, 2);
}

TEST(ParallelFor, CallsWithinCallsAndBesideThemEnd) {
  std::atomic<int> calls{0};
  const auto nested = [&] {
    parallel_for(
        6, 4, [&](std::size_t) { parallel_for(5, 3, [&](std::size_t) { parallel_for(4, 2, [&](std::size_t) { ++calls; }); }); });
  };
  std::vector<std::thread> callers;
  callers.reserve(3);
  for (int i = 0; i < 3; ++i) callers.emplace_back(nested);
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(calls, 3 * 6 * 5 * 4);
}

TEST(ParallelFor, CallsWithinACallUseNoMoreThreads) {
  std::atomic<int> working{0}, most{0};
  parallel_for(5, 3, [&](std::size_t) {
    parallel_for(20, 8, [&](std::size_t) {
      const int now = ++working;
      for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
      --working;
    });
  });
  EXPECT_LE(most, 3);
  EXPECT_GE(most, 2);
}

TEST(ParallelFor, ThreadsWithoutWorkHelpInTheCallWithin) {
  for (const std::size_t busy : {0U, 1U}) {  // its caller has no work left, or a helper
    constexpr int threads = 4;
    std::atomic<int> there{0};
    std::atomic<bool> other_is_done{false};
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{30};
    const auto wait_for = [&](const auto& holds) {
      while (!holds() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    };
    parallel_for(2, threads, [&](std::size_t i) {
      if (i != busy) {
        other_is_done = true;
        return;
      }
      wait_for([&] { return other_is_done.load(); });
      parallel_for(threads, threads, [&](std::size_t) {
        ++there;
        wait_for([&] { return there == threads; });  // each call waits for the others, so each needs a thread
      });
    });
    EXPECT_LT(std::chrono::steady_clock::now(), deadline) << busy;
    EXPECT_EQ(there, threads);
  }
}

TEST(ParallelFor, ThrowsTheFirstFailureAndBeginsNoFurtherCall) {
  std::atomic<int> calls{0};
  const auto work = [&](std::size_t i) {
    ++calls;
    if (i == 3) throw Error("third");
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  };
  EXPECT_THROW(parallel_for(10'000, 4, work), Error);
  EXPECT_LT(calls, 10'000);
  EXPECT_EQ(calls_of_each(100, 4), std::vector<int>(100, 1));  // the threads still work
}

TEST(ParallelFor, EndsInAChildProcessToo) {
  for (int i = 0; i < 20; ++i) {
    for (const unsigned threads : {5U, 2U})  // there are threads, which the child will lack; some sleep, some do not yet
      ASSERT_EQ(calls_of_each(100, threads), std::vector<int>(100, 1));
    const pid_t child = ::fork();
    if (child == 0) {
      ::alarm(60);
      std::atomic<int> calls{0}, together{0};
      parallel_for(100, 8, [&](std::size_t) { ++calls; });
      parallel_for(3, 3, [&](std::size_t) {  // it has threads of its own
        ++together;
        while (together < 3) std::this_thread::yield();
      });
      ::_exit(calls == 100 ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }
}

}  // namespace
}  // namespace tactile
