#include "tactile/events/stream.hpp"

#include <array>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {
constexpr std::array<std::string_view, 5> type_names{"events", "frames", "imu", "triggers", "other"};
constexpr std::array<std::string_view, 5> compression_names{"none", "lz4", "lz4-high", "zstd", "zstd-high"};
}  // namespace

std::string_view name_of(StreamType type) { return type_names.at(static_cast<std::size_t>(type)); }
std::string_view name_of(Compression compression) { return compression_names.at(static_cast<std::size_t>(compression)); }

Compression compression_named(std::string_view name) {
  for (std::size_t i = 0; i < compression_names.size(); ++i) {
    if (compression_names[i] == name) return static_cast<Compression>(i);
  }
  throw Error("compression: '" + std::string(name) + "' is not known; expected none, lz4, lz4-high, zstd or zstd-high");
}

Stream completed(Stream stream, std::string_view source) {
  if (stream.name.empty()) stream.name = name_of(stream.type);
  if (stream.source.empty()) stream.source = source;
  return stream;
}

}  // namespace tactile
