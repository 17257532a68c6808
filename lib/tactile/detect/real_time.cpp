#include "tactile/detect/real_time.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

namespace tactile::detect {

std::string use_real_time_priority(int priority) {
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted);
  if (error == 0) return {};
  return std::string("SCHED_FIFO is refused (") + std::strerror(error) + "); expected CAP_SYS_NICE, or rtprio in limits.conf";
}

std::string lock_memory() {
  rlimit limit{};
  // Pages are locked when they are first used, because only a tenth of the loaded libraries is used. Therefore no limit may be
  // set: with one, memory that is allocated later could be refused during detection.
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && ::geteuid() != 0)
    return "only part of the memory may be locked; expected CAP_IPC_LOCK, or memlock unlimited in limits.conf";
  if (::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  return std::string("memory cannot be locked (") + std::strerror(errno) + "); expected CAP_IPC_LOCK, or memlock in limits.conf";
}

void RealTimeRefusals::add(const std::string& why) {
  const std::scoped_lock lock(guard_);
  if (!why.empty() && std::find(reasons_.begin(), reasons_.end(), why) == reasons_.end()) reasons_.push_back(why);
}

std::vector<std::string> RealTimeRefusals::all() const {
  const std::scoped_lock lock(guard_);
  return reasons_;
}

AwakeProcessors::AwakeProcessors() : latency_(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
  const std::int32_t longest_us = 0;
  if (latency_.is_open() && ::write(latency_.number(), &longest_us, sizeof longest_us) == sizeof longest_us) return;
  refused_ = std::string("processors may sleep (/dev/cpu_dma_latency: ") + std::strerror(errno) + "); expected write permission";
  latency_.reset();
}

}  // namespace tactile::detect
