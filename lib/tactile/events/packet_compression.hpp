#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "tactile/events/stream.hpp"

namespace tactile {

/// The most that one packet may decompress to [B]; a packet that claims more is broken or hostile.
inline constexpr std::size_t packet_limit = std::size_t{256} << 20;

/// The most that `stored_size` bytes can be once decompressed [B]: what their method can reach at best, and `packet_limit` at
/// most.
std::size_t largest_content(Compression compression, std::size_t stored_size);

/// Bytes that are used again from packet to packet, aligned for any scalar. They grow, small ones by half at least, and never
/// shrink, and are not set to anything. Fresh memory is slow: packets each a little larger than those before must not ask for it
/// every time.
class PacketBuffer {
 public:
  std::byte* data() { return bytes_.get(); }
  std::size_t capacity() const { return capacity_; }
  void grow(std::size_t capacity, std::size_t kept);  ///< keeps the first `kept` bytes, as far as there were any

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t capacity_ = 0;
};

/// What decompression left in the buffer.
struct Decompressed {
  bool whole = false;    ///< the frame is sound, ends with the packet and stays within the limit
  std::size_t size = 0;  ///< [B]
};

/// What a packet should hold: how it is decompressed fastest, not to what.
enum class Expected : std::uint8_t { anything, events };

/// Decompresses packets one after the other with one set of working memory.
class PacketDecompressor {
 public:
  PacketDecompressor();
  ~PacketDecompressor();
  PacketDecompressor(PacketDecompressor&&) noexcept;
  PacketDecompressor& operator=(PacketDecompressor&&) noexcept;

  /// `stored`, exactly one LZ4 or zstd frame of any legal kind, into the front of `content`, which grows as the contents turn
  /// out, up to `limit` bytes.
  Decompressed decompress(Compression compression, std::span<const std::byte> stored, PacketBuffer& content, std::size_t limit,
                          Expected expected = Expected::anything);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Takes bytes that come piece by piece; each is valid during the call.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Compresses packets one after the other with one set of working memory: LZ4 frames of 64 KiB blocks without checksums,
/// independent at level 0, linked at level 9 (the vendor's software links them at level 0 too); zstd frames with their content
/// size at level 3 or the highest.
class PacketCompressor {
 public:
  PacketCompressor();
  ~PacketCompressor();
  PacketCompressor(PacketCompressor&&) noexcept;
  PacketCompressor& operator=(PacketCompressor&&) noexcept;

  /// `content` as a frame, which starts `reserved` bytes into `stored`; returns the frame's size. @throws Error if the library
  /// fails
  std::size_t compress(Compression compression, std::span<const std::byte> content, PacketBuffer& stored, std::size_t reserved);

  /// Likewise `size` bytes that `make` puts piece by piece; the frame goes to `sink` in pieces too, so that memory follows a
  /// piece.
  /// @throws Error likewise, and what `make` and `sink` throw
  void compress_pieces(Compression compression, std::uint64_t size, const std::function<void(const ByteSink&)>& make,
                       const ByteSink& sink);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
