#include "tactile/core/utc_time.hpp"

#include <fmt/core.h>

#include <chrono>
#include <ctime>

namespace tactile {

std::string now_utc() {
  const auto now = std::chrono::time_point_cast<std::chrono::microseconds>(std::chrono::system_clock::now());
  const std::time_t second = std::chrono::system_clock::to_time_t(now);
  std::tm utc{};
  gmtime_r(&second, &utc);
  const auto fraction = now.time_since_epoch().count() % 1'000'000;
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
                     utc.tm_min, utc.tm_sec, fraction);
}

}  // namespace tactile
