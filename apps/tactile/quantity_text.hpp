#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "tactile/core/measured.hpp"
#include "tactile/core/time.hpp"

namespace tactile::cli {

std::string counted(std::uint64_t n, const std::string& thing);  ///< "1 packet", "118 packets"
std::string counted(std::uint64_t n, const std::string& one, const std::string& several);
std::string rate_text(double per_second);          ///< "807 /s", "189.8 k/s", "3.10 M/s"
std::string duration_text(microseconds duration);  ///< "200 us", "61.3 ms", "12.345 s", "5:09 min", "1:05:09 h"
std::string bytes_text(std::uint64_t bytes);       ///< "949253 bytes (927.0 KiB)"

/// "195.16323 ± 0.00012", with two digits of the uncertainty; the value alone if the uncertainty is unknown or below 1e-7 of it.
std::string measured_text(const Measured& measured);

/// "2020-11-16 14:38:13.718345 UTC" if a camera time can be host time, from 2001 to 2099; else "33 us".
std::string moment_text(CameraTime t);

}  // namespace tactile::cli
