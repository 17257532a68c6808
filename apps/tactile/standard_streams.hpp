#pragma once

#include <string>
#include <string_view>

namespace tactile {

/// Opens each of the descriptors 0, 1 and 2 that is closed, so that no file of data gets its number: standard error takes
/// whatever is written, standard output refuses it still.
void open_missing_streams();

/// Puts `text` on standard output, at once. @throws Error  if not all of it can be written
void print(std::string_view text);

/// Why not all that was put on standard output, by whatever library, has been written, as a sentence; empty if it has.
std::string what_output_lost();

/// A line on standard error: "tactile: `sentence`". One that cannot be written is passed over.
void print_error(const std::string& sentence) noexcept;

}  // namespace tactile
