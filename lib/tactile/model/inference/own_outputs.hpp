#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <string>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/model/inference/own_network.hpp"

namespace tactile::model {

// Of the parts that run networks of one's own; inline, since a part calls few functions of the program.

/// @param found    shape of the output  @throws Error  if it differs by more than leading sizes of 1
inline void check_output(const NetworkPort& port, std::span<const std::int64_t> found) {
  const auto without_ones = [](std::span<const std::int64_t> shape) {
    return shape.subspan(static_cast<std::size_t>(
        std::find_if(shape.begin(), shape.end(), [](std::int64_t size) { return size != 1; }) - shape.begin()));
  };
  if (std::ranges::equal(without_ones(port.shape), without_ones(found))) return;
  throw Error(fmt::format("its output {} has the shape [{}]; expected [{}]", port.name, fmt::join(found, ", "),
                          fmt::join(port.shape, ", ")));
}

/// What a library says went wrong, in one line: its last one that names an error, else its first.
inline std::string line_of(std::string_view text) {
  std::string_view best = text.substr(0, text.find('\n'));
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    if (line.find("Error: ") != std::string_view::npos) best = line;
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
  }
  return std::string(best);
}

}  // namespace tactile::model
