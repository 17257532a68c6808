#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace tactile {

/// What a log of times holds, such as robot.csv or video.csv.
struct LogRows {
  std::uint64_t rows = 0;         ///< whole ones below the header
  std::uint64_t gaps = 0;         ///< empty lines between them: nothing is known there
  std::optional<double> rate_hz;  ///< over the steps that are no longer than was asked for; nothing without one
};

/// Reads a log with a header row, separated by commas, semicolons, tabs or spaces. A last row without its newline is no row.
/// @param column          of times
/// @param unit_s          of that column [s]
/// @param longest_step_s  longer ones are gaps and restarts, which tell nothing of the rate [s]
/// @return  nothing if there is no such file, it has no such column, or a row is longer than 64 KiB
std::optional<LogRows> log_rows(const std::filesystem::path& file, std::string_view column, double unit_s, double longest_step_s);

}  // namespace tactile
