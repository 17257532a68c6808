#include "tactile/events/packet_compression.hpp"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/events/lz4_blocks.hpp"

namespace tactile::events {
namespace {

/// LZ4 decodes a block in place only if a whole block fits. This is the vendor's block size.
constexpr std::size_t lz4_block = std::size_t{64} << 10;

constexpr std::size_t most_at_once = std::size_t{8}
                                     << 20;  ///< up to this size a buffer grows by half, beyond it only as needed [B]

/// The length of a packet according to its first four bytes; 0 if they are not decoded yet.
std::size_t length_by_prefix(const std::byte* content, std::size_t known) {
  std::uint32_t prefix = 0;
  if (known < sizeof prefix) return 0;
  std::memcpy(&prefix, content, sizeof prefix);
  return std::size_t{prefix} + sizeof prefix;
}

/// Makes room for more than `known` bytes: as much as the packet claims, otherwise twice as much. False at the limit.
bool make_room(PacketBuffer& content, std::size_t known, std::size_t limit) {
  const std::size_t claimed = length_by_prefix(content.data(), known);
  if (known >= limit || claimed > limit) return false;
  const std::size_t wanted = claimed > known ? claimed : std::min(limit, 2 * known + lz4_block);
  content.grow(wanted + lz4_block, known);
  return true;
}

/// The frame headers, with their checksum, in usual recordings: blocks of 64 KiB without checksums or size, linked or not.
constexpr std::array<std::uint8_t, 7> linked_frame{0x04, 0x22, 0x4D, 0x18, 0x40, 0x40, 0xC0};
constexpr std::array<std::uint8_t, 7> unlinked_frame{0x04, 0x22, 0x4D, 0x18, 0x60, 0x40, 0x82};

/// A block of a frame; the end mark if `stored` is empty.
struct FrameBlock {
  std::span<const std::byte> stored;
  bool compressed = false;
};

/// The block at `at`, which is advanced after it; nothing if the frame ends inside the block.
std::optional<FrameBlock> next_block(std::span<const std::byte> frame, std::size_t& at) {
  std::uint32_t head = 0;
  if (frame.size() - at < sizeof head) return std::nullopt;
  std::memcpy(&head, frame.data() + at, sizeof head);
  at += sizeof head;
  const std::size_t size = head & 0x7FFFFFFF;
  if (size > frame.size() - at || (size == 0 && head != 0)) return std::nullopt;
  at += size;
  return FrameBlock{.stored = frame.subspan(at - size, size), .compressed = head >> 31 == 0};
}

/// Decompresses such a frame of events faster than the library. Not whole for any other frame, or a damaged one: then the library
/// is used.
Decompressed decompress_usual_lz4(std::span<const std::byte> stored, PacketBuffer& content, std::size_t limit) {
  const auto starts_with = [&](const auto& head) {
    return stored.size() >= head.size() && std::memcmp(stored.data(), head.data(), head.size()) == 0;
  };
  const bool linked = starts_with(linked_frame);
  if (!linked && !starts_with(unlinked_frame)) return {};
  content.grow(std::min(4 * stored.size(), limit) + lz4_block, 0);
  std::size_t at = linked_frame.size(), made = 0;
  const auto room_for = [&](const FrameBlock& block, std::size_t place) {
    return Lz4Block{.stored = block.stored, .room = {content.data() + place, lz4_block}, .before = linked ? made : 0};
  };
  for (;;) {
    const std::optional<FrameBlock> block = next_block(stored, at);
    if (!block) return {};
    if (block->stored.empty()) return {.whole = at == stored.size() && made <= limit, .size = made};
    while (content.capacity() - made < lz4_block) {
      if (!make_room(content, made, limit)) return {};
    }
    if (!block->compressed) {
      if (block->stored.size() > lz4_block) return {};
      std::memcpy(content.data() + made, block->stored.data(), block->stored.size());
      made += block->stored.size();
      continue;
    }
    if (!linked && content.capacity() - made >= 2 * lz4_block) {
      std::size_t after_next = at;
      const std::optional<FrameBlock> next = next_block(stored, after_next);
      if (next && next->compressed && !next->stored.empty()) {
        const auto sizes = decode_lz4_blocks(room_for(*block, made), room_for(*next, made + lz4_block));
        if (!sizes) return {};
        const auto [first, second] = *sizes;
        if (first < lz4_block) std::memmove(content.data() + made + first, content.data() + made + lz4_block, second);
        made += first + second;
        at = after_next;
        continue;
      }
    }
    const std::optional<std::size_t> size = decode_lz4_block(room_for(*block, made));
    if (!size) return {};
    made += *size;
  }
}

Decompressed decompress_lz4(LZ4F_dctx* context, std::span<const std::byte> stored, PacketBuffer& content, std::size_t limit) {
  LZ4F_resetDecompressionContext(context);
  content.grow(std::min(4 * stored.size(), limit) + lz4_block, 0);
  std::size_t used = 0;
  std::size_t made = 0;
  for (;;) {
    std::size_t input = stored.size() - used;
    std::size_t output = content.capacity() - made;
    const std::size_t rest = LZ4F_decompress(context, content.data() + made, &output, stored.data() + used, &input, nullptr);
    if (LZ4F_isError(rest) != 0U) return {};
    used += input;
    made += output;
    if (rest == 0) return {.whole = used == stored.size() && made <= limit, .size = made};
    if (made == content.capacity()) {
      if (!make_room(content, made, limit)) return {};
    } else if (input == 0 && output == 0) {
      return {};  // the frame continues after the end of the packet
    }
  }
}

Decompressed decompress_zstd_stream(ZSTD_DCtx* context, std::span<const std::byte> stored, PacketBuffer& content,
                                    std::size_t limit) {
  ZSTD_DCtx_reset(context, ZSTD_reset_session_only);
  content.grow(std::min(4 * stored.size(), limit) + lz4_block, 0);
  ZSTD_inBuffer in{stored.data(), stored.size(), 0};
  std::size_t made = 0;
  for (;;) {
    ZSTD_outBuffer out{content.data(), content.capacity(), made};
    const std::size_t used = in.pos;
    const std::size_t rest = ZSTD_decompressStream(context, &out, &in);
    if (ZSTD_isError(rest) != 0U) return {};
    const bool moved = in.pos != used || out.pos != made;
    made = out.pos;
    if (rest == 0) return {.whole = in.pos == in.size && made <= limit, .size = made};
    if (made == content.capacity()) {
      if (!make_room(content, made, limit)) return {};
    } else if (!moved || in.pos == in.size) {
      return {};
    }
  }
}

Decompressed decompress_zstd(ZSTD_DCtx* context, std::span<const std::byte> stored, PacketBuffer& content, std::size_t limit) {
  const auto size = ZSTD_getFrameContentSize(stored.data(), stored.size());
  if (size == ZSTD_CONTENTSIZE_ERROR) return {};
  if (size == ZSTD_CONTENTSIZE_UNKNOWN) return decompress_zstd_stream(context, stored, content, limit);
  if (size > limit) return {};
  content.grow(static_cast<std::size_t>(size), 0);
  const std::size_t made =
      ZSTD_decompressDCtx(context, content.data(), static_cast<std::size_t>(size), stored.data(), stored.size());
  if (ZSTD_isError(made) != 0U || made != size) return {};
  return {.whole = true, .size = made};
}

bool is_lz4(Compression compression) { return compression == Compression::lz4 || compression == Compression::lz4_high; }

struct FreeLz4Decoder {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};
struct FreeLz4Encoder {
  void operator()(LZ4F_cctx* context) const { LZ4F_freeCompressionContext(context); }
};
struct FreeZstdDecoder {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
struct FreeZstdEncoder {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

void check_lz4(std::size_t result) {
  if (LZ4F_isError(result) != 0U) throw Error(std::string("LZ4: ") + LZ4F_getErrorName(result) + "; expected it to work");
}
void check_zstd(std::size_t result) {
  if (ZSTD_isError(result) != 0U) throw Error(std::string("zstd: ") + ZSTD_getErrorName(result) + "; expected it to work");
}

LZ4F_preferences_t lz4_preferences(int level) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max64KB;
  // Independent blocks are compressed 8 to 19 % faster than linked ones, to similar sizes. The slow level is chosen for size.
  preferences.frameInfo.blockMode = level == 0 ? LZ4F_blockIndependent : LZ4F_blockLinked;
  preferences.compressionLevel = level;
  return preferences;
}

/// The levels of the vendor's software.
int level_of(Compression compression) {
  switch (compression) {
    case Compression::lz4_high:
      return 9;
    case Compression::zstd:
      return 3;
    case Compression::zstd_high:
      return ZSTD_maxCLevel();
    default:
      return 0;
  }
}

}  // namespace

std::size_t largest_content(Compression compression, std::size_t stored_size) {
  if (compression == Compression::none) return stored_size;
  // A byte of LZ4 expands to at most 255 bytes; zstd has no such limit.
  if (is_lz4(compression) && stored_size < packet_limit / 255) return 255 * stored_size;
  return packet_limit;
}

void PacketBuffer::grow(std::size_t capacity, std::size_t kept) {
  if (capacity <= capacity_) return;
  capacity = std::max(capacity, std::min(capacity_ + capacity_ / 2, most_at_once));
  std::unique_ptr<std::byte[]> larger(new std::byte[capacity]);
  if (capacity_ > 0) std::memcpy(larger.get(), bytes_.get(), std::min(kept, capacity_));
  bytes_ = std::move(larger);
  capacity_ = capacity;
}

struct PacketDecompressor::State {
  std::unique_ptr<LZ4F_dctx, FreeLz4Decoder> lz4;
  std::unique_ptr<ZSTD_DCtx, FreeZstdDecoder> zstd;
};

PacketDecompressor::PacketDecompressor() : state_(std::make_unique<State>()) {}
PacketDecompressor::~PacketDecompressor() = default;
PacketDecompressor::PacketDecompressor(PacketDecompressor&&) noexcept = default;
PacketDecompressor& PacketDecompressor::operator=(PacketDecompressor&&) noexcept = default;

Decompressed PacketDecompressor::decompress(Compression compression, std::span<const std::byte> stored, PacketBuffer& content,
                                            std::size_t limit, Expected expected) {
  if (is_lz4(compression)) {
    if (expected == Expected::events) {
      if (const Decompressed usual = decompress_usual_lz4(stored, content, limit); usual.whole) return usual;
    }
    if (!state_->lz4) {
      LZ4F_dctx* context = nullptr;
      check_lz4(LZ4F_createDecompressionContext(&context, LZ4F_VERSION));
      state_->lz4.reset(context);
    }
    const Decompressed result = decompress_lz4(state_->lz4.get(), stored, content, limit);
    // After an incomplete frame, liblz4 1.9 keeps its announced size even after a reset, so the next frame would fail.
    if (!result.whole) state_->lz4.reset();
    return result;
  }
  if (!state_->zstd) state_->zstd.reset(ZSTD_createDCtx());
  if (!state_->zstd) throw std::bad_alloc();
  return decompress_zstd(state_->zstd.get(), stored, content, limit);
}

struct PacketCompressor::State {
  std::unique_ptr<LZ4F_cctx, FreeLz4Encoder> lz4;
  std::unique_ptr<ZSTD_CCtx, FreeZstdEncoder> zstd;

  LZ4F_cctx* lz4_context();
  ZSTD_CCtx* zstd_context();
  std::size_t lz4_frame(int level, std::span<const std::byte> content, PacketBuffer& stored, std::size_t reserved);
  std::size_t zstd_frame(int level, std::span<const std::byte> content, PacketBuffer& stored, std::size_t reserved);
  void lz4_pieces(int level, const std::function<void(const ByteSink&)>& make, const ByteSink& sink);
  void zstd_pieces(int level, std::uint64_t size, const std::function<void(const ByteSink&)>& make, const ByteSink& sink);
};

PacketCompressor::PacketCompressor() : state_(std::make_unique<State>()) {}
PacketCompressor::~PacketCompressor() = default;
PacketCompressor::PacketCompressor(PacketCompressor&&) noexcept = default;
PacketCompressor& PacketCompressor::operator=(PacketCompressor&&) noexcept = default;

LZ4F_cctx* PacketCompressor::State::lz4_context() {
  if (lz4) return lz4.get();
  LZ4F_cctx* context = nullptr;
  check_lz4(LZ4F_createCompressionContext(&context, LZ4F_VERSION));
  lz4.reset(context);
  return context;
}

ZSTD_CCtx* PacketCompressor::State::zstd_context() {
  if (!zstd) zstd.reset(ZSTD_createCCtx());
  if (!zstd) throw std::bad_alloc();
  return zstd.get();
}

std::size_t PacketCompressor::State::lz4_frame(int level, std::span<const std::byte> content, PacketBuffer& stored,
                                               std::size_t reserved) {
  LZ4F_cctx* context = lz4_context();
  const LZ4F_preferences_t preferences = lz4_preferences(level);
  const std::size_t room = LZ4F_HEADER_SIZE_MAX + LZ4F_compressBound(content.size(), &preferences);
  stored.grow(reserved + room, 0);
  std::byte* frame = stored.data() + reserved;
  std::size_t size = LZ4F_compressBegin(context, frame, room, &preferences);
  check_lz4(size);
  const std::size_t blocks = LZ4F_compressUpdate(context, frame + size, room - size, content.data(), content.size(), nullptr);
  check_lz4(blocks);
  size += blocks;
  const std::size_t end = LZ4F_compressEnd(context, frame + size, room - size, nullptr);
  check_lz4(end);
  return size + end;
}

std::size_t PacketCompressor::State::zstd_frame(int level, std::span<const std::byte> content, PacketBuffer& stored,
                                                std::size_t reserved) {
  ZSTD_CCtx* context = zstd_context();
  const std::size_t room = ZSTD_compressBound(content.size());
  stored.grow(reserved + room, 0);
  const std::size_t size = ZSTD_compressCCtx(context, stored.data() + reserved, room, content.data(), content.size(), level);
  check_zstd(size);
  return size;
}

void PacketCompressor::State::lz4_pieces(int level, const std::function<void(const ByteSink&)>& make, const ByteSink& sink) {
  LZ4F_cctx* context = lz4_context();
  const LZ4F_preferences_t preferences = lz4_preferences(level);
  PacketBuffer frame;
  const auto pass_on = [&](std::size_t made) {
    check_lz4(made);
    if (made > 0) sink({frame.data(), made});
  };
  frame.grow(LZ4F_HEADER_SIZE_MAX + LZ4F_compressBound(0, &preferences), 0);
  pass_on(LZ4F_compressBegin(context, frame.data(), frame.capacity(), &preferences));
  make([&](std::span<const std::byte> piece) {
    frame.grow(LZ4F_compressBound(piece.size(), &preferences), 0);
    pass_on(LZ4F_compressUpdate(context, frame.data(), frame.capacity(), piece.data(), piece.size(), nullptr));
  });
  pass_on(LZ4F_compressEnd(context, frame.data(), frame.capacity(), nullptr));
}

void PacketCompressor::State::zstd_pieces(int level, std::uint64_t size, const std::function<void(const ByteSink&)>& make,
                                          const ByteSink& sink) {
  ZSTD_CCtx* context = zstd_context();
  ZSTD_CCtx_reset(context, ZSTD_reset_session_only);
  check_zstd(ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level));
  check_zstd(ZSTD_CCtx_setPledgedSrcSize(context, size));
  std::vector<std::byte> frame(ZSTD_CStreamOutSize());
  const auto put = [&](std::span<const std::byte> piece, ZSTD_EndDirective directive) {
    ZSTD_inBuffer in{piece.data(), piece.size(), 0};
    for (std::size_t rest = 1; directive == ZSTD_e_end ? rest > 0 : in.pos < in.size;) {
      ZSTD_outBuffer out{frame.data(), frame.size(), 0};
      rest = ZSTD_compressStream2(context, &out, &in, directive);
      check_zstd(rest);
      if (out.pos > 0) sink(std::span(frame).first(out.pos));
    }
  };
  make([&](std::span<const std::byte> piece) { put(piece, ZSTD_e_continue); });
  put({}, ZSTD_e_end);
}

std::size_t PacketCompressor::compress(Compression compression, std::span<const std::byte> content, PacketBuffer& stored,
                                       std::size_t reserved) {
  const int level = level_of(compression);
  if (is_lz4(compression)) return state_->lz4_frame(level, content, stored, reserved);
  if (compression != Compression::none) return state_->zstd_frame(level, content, stored, reserved);
  stored.grow(reserved + content.size(), 0);
  std::memcpy(stored.data() + reserved, content.data(), content.size());
  return content.size();
}

void PacketCompressor::compress_pieces(Compression compression, std::uint64_t size,
                                       const std::function<void(const ByteSink&)>& make, const ByteSink& sink) {
  if (compression == Compression::none) return make(sink);
  const int level = level_of(compression);
  is_lz4(compression) ? state_->lz4_pieces(level, make, sink) : state_->zstd_pieces(level, size, make, sink);
}

}  // namespace tactile::events
