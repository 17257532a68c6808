#include "tactile/events/stream.hpp"

#include <array>

#include "tactile/core/enum_names.hpp"

namespace tactile::events {
namespace {
constexpr std::array<std::string_view, 5> type_names{"events", "frames", "imu", "triggers", "other"};
constexpr std::array<std::string_view, 5> compression_names{"none", "lz4", "lz4-high", "zstd", "zstd-high"};
}  // namespace

std::string_view name_of(StreamType type) { return type_names.at(static_cast<std::size_t>(type)); }
std::string_view name_of(Compression compression) { return compression_names.at(static_cast<std::size_t>(compression)); }

Compression compression_named(std::string_view name) {
  return enumerator_named<Compression>(name, compression_names, "compression");
}

Stream completed(Stream stream, std::string_view source) {
  if (stream.name.empty()) stream.name = name_of(stream.type);
  if (stream.source.empty()) stream.source = source;
  return stream;
}

}  // namespace tactile::events
