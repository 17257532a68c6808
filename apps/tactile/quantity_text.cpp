#include "quantity_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

namespace tactile::cli {

std::string counted(std::uint64_t n, const std::string& thing) { return counted(n, thing, thing + "s"); }

std::string counted(std::uint64_t n, const std::string& one, const std::string& several) {
  return fmt::format("{} {}", n, n == 1 ? one : several);
}

std::string rate_text(double per_second) {
  if (per_second < 9.995) return fmt::format("{:.2f} /s", per_second);
  if (per_second < 999.5) return fmt::format("{:.0f} /s", per_second);
  if (per_second < 999.95e3) return fmt::format("{:.1f} k/s", per_second / 1e3);
  return fmt::format("{:.2f} M/s", per_second / 1e6);
}

std::string measured_text(const Measured& measured) {
  const double u = measured.uncertainty;
  if (!std::isfinite(u) || u <= 1e-7 * std::abs(measured.value)) return fmt::format("{:.7g}", measured.value);
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(u))), 0, 9);
  return fmt::format("{:.{}f} ± {:.{}f}", measured.value, digits, u, digits);
}

std::string duration_text(microseconds duration) {
  const std::int64_t us = duration.count();
  if (us < 1'000) return fmt::format("{} us", us);
  if (us < 1'000'000) return fmt::format("{:.1f} ms", static_cast<double>(us) / 1e3);
  if (us < 60'000'000) return fmt::format("{:.3f} s", static_cast<double>(us) / 1e6);
  const std::int64_t seconds = us / 1'000'000 + (us % 1'000'000 >= 500'000 ? 1 : 0);
  if (seconds < 3600) return fmt::format("{}:{:02} min", seconds / 60, seconds % 60);
  return fmt::format("{}:{:02}:{:02} h", seconds / 3600, seconds / 60 % 60, seconds % 60);
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr std::array units{"KiB", "MiB", "GiB", "TiB"};
  if (bytes < 1024) return counted(bytes, "byte");
  double value = static_cast<double>(bytes) / 1024;
  std::size_t unit = 0;
  for (; value >= 1023.95 && unit + 1 < units.size(); ++unit) value /= 1024;
  return fmt::format("{} bytes ({:.1f} {})", bytes, value, units.at(unit));
}

std::string moment_text(CameraTime t) {
  constexpr std::int64_t year_2001_us = 978'307'200'000'000, year_2100_us = 4'102'444'800'000'000;
  const std::int64_t us = us_of(t);
  if (us < year_2001_us || us >= year_2100_us) return fmt::format("{} us", us);
  const auto seconds = static_cast<std::time_t>(us / 1'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02}.{:06} UTC", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                     utc.tm_hour, utc.tm_min, utc.tm_sec, us % 1'000'000);
}

}  // namespace tactile::cli
