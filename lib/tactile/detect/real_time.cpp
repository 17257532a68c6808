#include "tactile/detect/real_time.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

namespace tactile {

std::string go_ahead_of_others(int priority) {
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted);
  if (error == 0) return {};
  return std::string("SCHED_FIFO is refused (") + std::strerror(error) + "); it takes CAP_SYS_NICE, or rtprio in limits.conf";
}

std::string lock_memory() {
  rlimit limit{};
  // Pages are locked as they are first used: the libraries that are loaded are ten times what is used of them.
  // With a limit, memory asked for later could be refused in the middle of the work.
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && ::geteuid() != 0)
    return "memory may be locked in part only; it takes CAP_IPC_LOCK, or memlock unlimited in limits.conf";
  if (::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  return std::string("memory cannot be locked (") + std::strerror(errno) + "); it takes CAP_IPC_LOCK, or memlock in limits.conf";
}

AwakeProcessors::AwakeProcessors() : latency_(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
  const std::int32_t longest_us = 0;
  if (latency_.is_open() && ::write(latency_.number(), &longest_us, sizeof longest_us) == sizeof longest_us) return;
  refused_ = std::string("processors may sleep (/dev/cpu_dma_latency: ") + std::strerror(errno) + "); it takes leave to write it";
  latency_.reset();
}

}  // namespace tactile
