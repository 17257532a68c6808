#include "tactile/detect/real_time.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace tactile::detect {
namespace {

/// How the calling thread is scheduled, such as SCHED_FIFO.
int policy_here() { return ::sched_getscheduler(0) & ~SCHED_RESET_ON_FORK; }

TEST(RealTimePriority, IsGivenToTheCallingThreadOrRefusedForAReason) {
  const int before = policy_here();
  std::string refused;
  int policy = -1;
  sched_param got{};
  std::thread([&] {
    refused = use_real_time_priority(3);
    policy = policy_here();
    ::sched_getparam(0, &got);
  }).join();
  if (refused.empty()) {
    EXPECT_EQ(policy, SCHED_FIFO);
    EXPECT_EQ(got.sched_priority, 3);
  } else {
    EXPECT_EQ(policy, before) << refused;
    EXPECT_NE(refused.find("CAP_SYS_NICE"), std::string::npos) << refused;
  }
  EXPECT_EQ(policy_here(), before) << "other threads keep their own";
}

TEST(AwakeProcessors, ReportWhyTheyMaySleep) {
  const bool permitted = ::access("/dev/cpu_dma_latency", W_OK) == 0;
  const AwakeProcessors first, second;  // several may ask for it at the same time
  EXPECT_EQ(first.refused().empty(), permitted) << first.refused();
  EXPECT_EQ(second.refused().empty(), permitted) << second.refused();
  if (!permitted) {
    EXPECT_NE(first.refused().find("/dev/cpu_dma_latency"), std::string::npos) << first.refused();
    return;
  }
  std::ifstream device("/dev/cpu_dma_latency", std::ios::binary);
  std::int32_t longest_us = -1;
  if (device.read(reinterpret_cast<char*>(&longest_us), sizeof longest_us)) {
    EXPECT_EQ(longest_us, 0) << "asked for as long as they live";
  }
}

/// The locked memory of this process, as the kernel counts it.
std::size_t locked_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmLck:") continue;
    std::size_t kib = 0;
    status >> kib;
    return kib << 10;
  }
  ADD_FAILURE() << "/proc/self/status has no VmLck";
  return 0;
}

TEST(LockMemory, LocksWhatIsAllocatedLaterOrSaysWhyNot) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizers replace mlockall by nothing";
#endif
  const std::string refused = lock_memory();
  const std::vector<char> later(std::size_t{8} << 20, 1);
  const std::size_t locked = locked_bytes();
  ::munlockall();
  if (refused.empty()) {
    EXPECT_GE(locked, later.size());
  } else {
    EXPECT_EQ(locked, 0U);
    EXPECT_NE(refused.find("CAP_IPC_LOCK"), std::string::npos) << refused;
  }
}

TEST(LockMemory, IsRefusedToAUserWhoMayLockOnlyPartOfIt) {
  const uid_t user = ::geteuid();
  if (user == 0 && ::seteuid(65'534) != 0) GTEST_SKIP() << "there is no user but root";
  rlimit before{};
  EXPECT_EQ(::getrlimit(RLIMIT_MEMLOCK, &before), 0);
  // A limit above what this process has so far, where the system permits it.
  const rlimit limited{.rlim_cur = std::min<rlim_t>(before.rlim_max, rlim_t{1} << 40), .rlim_max = before.rlim_max};
  EXPECT_EQ(::setrlimit(RLIMIT_MEMLOCK, &limited), 0);
  const std::size_t locked_before = locked_bytes();  // a library may have locked some for its keys
  const std::string refused = lock_memory();
  const std::size_t locked = locked_bytes();
  ::munlockall();
  EXPECT_EQ(::setrlimit(RLIMIT_MEMLOCK, &before), 0);
  EXPECT_EQ(::seteuid(user), 0);
  ::prctl(PR_SET_DUMPABLE, 1);  // the change of user ended this, and the leak sanitizer needs it
  EXPECT_NE(refused.find("only part of the memory may be locked"), std::string::npos) << refused;
  EXPECT_EQ(locked, locked_before);
}

TEST(RealTimeRefusals, KeepEachReasonOnce) {
  RealTimeRefusals refusals;
  for (const char* why : {"no priority", "", "no locked memory", "no priority"}) refusals.add(why);
  EXPECT_EQ(refusals.all(), (std::vector<std::string>{"no priority", "no locked memory"}));
}

}  // namespace
}  // namespace tactile::detect
