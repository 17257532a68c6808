#include "tactile/core/host_clock.hpp"

namespace tactile {

HostTime host_now() {
  using std::chrono::duration_cast;
  using Steady = std::chrono::steady_clock;
  static const Steady::time_point steady_begin = Steady::now();
  static const auto system_begin = duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch());
  return HostTime{system_begin + duration_cast<microseconds>(Steady::now() - steady_begin)};
}

}  // namespace tactile
