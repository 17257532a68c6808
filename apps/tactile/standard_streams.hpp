#pragma once

#include <string>
#include <string_view>

namespace tactile::cli {

/// Opens the descriptors 0, 1 and 2 if they are closed, so that no data file gets these numbers. Standard error then accepts
/// everything; writing to standard output still fails.
void open_missing_streams();

/// Prints `text` to standard output immediately. @throws Error  if not all of it can be written
void print(std::string_view text);

/// A sentence if any output to standard output could not be written, by any library; else empty.
std::string what_output_lost();

/// Prints "tactile: `sentence`" to standard error, and ignores a failure.
void print_error(const std::string& sentence) noexcept;

}  // namespace tactile::cli
