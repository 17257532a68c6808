#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace tactile::events {

/// A block of an LZ4 frame, and the memory for its contents.
struct Lz4Block {
  std::span<const std::byte> stored;
  std::span<std::byte> room;
  std::size_t before = 0;  ///< available bytes before `room`, which the contents may repeat [B]
};

/// Decodes a block to the front of its room; the rest of the room is undefined. Never accesses memory outside `stored`, the room
/// and the bytes before it, whatever the input.
///
/// It is optimised for events: each takes one to three short sequences, which repeat those of a recent event. A processor is slow
/// to read recently written bytes unless one write contains all of them. Therefore a sequence is composed in a register and
/// written at once, not copied part by part.
/// @return  the size of the contents [B]; nothing if the block is damaged, or its contents do not fit. Unlike liblz4, it accepts
/// blocks
///          with a match close to the end
/// Source: the LZ4 block format, https://github.com/lz4/lz4/blob/dev/doc/lz4_Block_format.md
std::optional<std::size_t> decode_lz4_block(const Lz4Block& block);

/// Decodes two blocks alternately: the start of a sequence depends on the one before, and a processor can work on the other block
/// meanwhile. Neither may overlap the other's room or, by `before`, need its contents.
std::optional<std::array<std::size_t, 2>> decode_lz4_blocks(const Lz4Block& first, const Lz4Block& second);

}  // namespace tactile::events
