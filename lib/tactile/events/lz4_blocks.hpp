#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace tactile {

/// A block of LZ4, which frames of LZ4 are made of, and the place for its contents.
struct Lz4Block {
  std::span<const std::byte> stored;
  std::span<std::byte> room;
  std::size_t before = 0;  ///< so many bytes in front of `room` are there, and contents may repeat them [B]
};

/// Decodes a block into the front of its room; what is behind its contents is left in any state. Nothing outside of `stored`, the
/// room and what is before it is touched, whatever the bytes.
///
/// It is made for events: each takes one to three sequences of few bytes, which repeat those of an event just before. A
/// processor is slow to read again what it has written a moment ago unless it reads no more than one write put there; so here a
/// sequence is put together in a register, from where it begins, and not copied part by part.
/// @return  the contents' size [B]; nothing where the block is broken, or its contents do not fit. Of blocks that liblz4 refuses
///          it takes some, those with a match too near to the end
/// Source: the LZ4 block format, https://github.com/lz4/lz4/blob/dev/doc/lz4_Block_format.md
std::optional<std::size_t> decode_lz4_block(const Lz4Block& block);

/// Likewise two, in turn: where a sequence begins is known only once the one before has been looked at, and a processor has time
/// for another block while it waits for that. Neither may be in the other's room or, by `before`, need its contents.
std::optional<std::array<std::size_t, 2>> decode_lz4_blocks(const Lz4Block& first, const Lz4Block& second);

}  // namespace tactile
