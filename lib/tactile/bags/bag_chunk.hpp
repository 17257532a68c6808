#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "tactile/events/packet_compression.hpp"

namespace tactile::bags {

inline constexpr std::uint64_t most_chunk = std::uint64_t{256} << 20;  ///< of a chunk or message [B], compressed or not

/// Decompresses the chunks of bags, with memory that is reused.
class BagChunk {
 public:
  /// @param method   "none" or "", "lz4" (a frame), "bz2", "zstd"
  /// @param claimed  decompressed size, at most `most_chunk`
  /// @param is_cut   whether the end of `stored` is missing: then the front that can be decompressed counts
  /// @return  the contents, valid until the next call; nothing if they cannot be decompressed to exactly `claimed` bytes
  std::optional<std::span<const std::byte>> contents(std::string_view method, std::span<const std::byte> stored,
                                                     std::size_t claimed, bool is_cut);

  /// Decompresses a message that is one zstd frame. @return  nothing if that fails, or it is larger than `most_chunk`
  std::optional<std::span<const std::byte>> zstd_message(std::span<const std::byte> stored);

 private:
  events::PacketBuffer content_;
  events::PacketDecompressor decompressor_;
};

}  // namespace tactile::bags
