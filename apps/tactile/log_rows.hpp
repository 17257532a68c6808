#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace tactile::cli {

/// Contents of a log with times, such as robot.csv or video.csv.
struct LogRows {
  std::uint64_t rows = 0;         ///< complete rows after the header
  std::uint64_t gaps = 0;         ///< empty lines between them, without data
  std::optional<double> rate_hz;  ///< over steps up to `longest_step_s`; nothing without such a step
};

/// Reads a table with a header row. A last row without newline does not count.
/// @param column          with the times
/// @param unit_s          of that column [s]
/// @param longest_step_s  longer steps are gaps and restarts, and do not count for the rate [s]
/// @return  nothing if there is no such file, it has no such column, or a row is longer than 1 MiB
std::optional<LogRows> log_rows(const std::filesystem::path& file, std::string_view column, double unit_s, double longest_step_s);

}  // namespace tactile::cli
