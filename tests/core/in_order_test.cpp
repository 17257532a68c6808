#include "tactile/core/in_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"

namespace tactile {
namespace {

std::vector<std::size_t> numbers_to(std::size_t count) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

/// Later numbers often come first.
void wait_a_while(std::size_t number) { std::this_thread::sleep_for(std::chrono::microseconds((number * 7919) % 400)); }

TEST(InOrder, ExecutesStepsInTheirOrder) {
  for (const unsigned threads : {1U, 2U, 7U}) {
    for (const std::size_t most_ahead : {1U, 3U, 1000U}) {
      InOrder in_order(most_ahead);
      std::vector<std::size_t> executed;  // one step at a time, so it needs no lock
      parallel_for(200, threads, [&](std::size_t i) {
        wait_a_while(i);
        in_order.later(i, [&executed, i] { executed.push_back(i); });
      });
      EXPECT_EQ(executed, numbers_to(200)) << threads << " threads, " << most_ahead;
    }
  }
}

TEST(InOrder, NowWaitsForTheStep) {
  InOrder in_order(10);
  std::vector<std::size_t> executed;
  std::atomic<int> missing{0};
  parallel_for(200, 5, [&](std::size_t i) {
    bool done = false;
    wait_a_while(i);
    const bool was_executed = in_order.now(i, [&] {
      executed.push_back(i);
      done = true;
    });
    missing += was_executed && done ? 0 : 1;
  });
  EXPECT_EQ(missing, 0);
  EXPECT_EQ(executed, numbers_to(200));
}

TEST(InOrder, NowIsNotLeftWhileItsStepExecutes) {
  InOrder in_order(10);
  std::atomic<bool> executes{false};
  bool was_executed = false;
  parallel_for(2, 2, [&](std::size_t i) {
    if (i == 0) {
      in_order.later(0, [] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); });
      while (!executes) std::this_thread::yield();
      in_order.fail();
      return;
    }
    bool done = false;  // used after its end, if `now` does not wait
    was_executed = in_order.now(1, [&] {
      executes = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      done = true;
    });
    EXPECT_TRUE(done);
  });
  EXPECT_TRUE(was_executed);
}

TEST(InOrder, LetsStepsBeOnlySoFarAhead) {
  constexpr std::size_t most_ahead = 3;
  InOrder in_order(most_ahead);
  std::atomic<bool> first_came{false};
  std::atomic<std::size_t> waiting{0}, executed{0};
  std::vector<std::thread> threads;
  for (std::size_t i = 1; i < 8; ++i) {
    threads.emplace_back([&, i] {
      in_order.later(i, [&] { ++executed; });
      if (!first_came) ++waiting;  // `later` has returned, though the step cannot be executed yet
    });
  }
  while (waiting < most_ahead - 1) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(waiting, most_ahead - 1);  // 1 and 2, as only 0 to 2 may come before 0 is executed
  first_came = true;
  in_order.later(0, [&] { ++executed; });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(executed, 8U);
}

TEST(InOrder, AFailedStepEndsTheOthers) {
  InOrder in_order(2);
  std::atomic<std::size_t> executed{0};
  EXPECT_THROW(parallel_for(100, 4,
                            [&](std::size_t i) {
                              in_order.later(i, [&executed, i] {
                                if (i == 5) throw Error("the disk is full");
                                ++executed;
                              });
                            }),
               Error);
  EXPECT_EQ(executed, 5U);
}

TEST(InOrder, AfterAFailureNobodyWaits) {
  InOrder in_order(1);
  std::vector<std::thread> threads;
  std::atomic<int> was_executed{0};
  for (std::size_t i = 1; i < 4; ++i) {
    threads.emplace_back([&, i] { was_executed += in_order.now(i, [] {}) ? 1 : 0; });
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  in_order.fail();  // number 0 will not come
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(was_executed, 0);
}

}  // namespace
}  // namespace tactile
