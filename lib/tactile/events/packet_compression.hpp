#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "tactile/events/stream.hpp"

namespace tactile::events {

/// The largest decompressed packet [B]; a packet that claims more is damaged or malicious.
inline constexpr std::size_t packet_limit = std::size_t{256} << 20;

/// The largest decompressed size of `stored_size` bytes [B]: the limit of their method, and at most `packet_limit`.
std::size_t largest_content(Compression compression, std::size_t stored_size);

/// Memory that is reused from packet to packet, aligned for any scalar. It only grows, small buffers by at least half, and is not
/// initialised. New memory is slow: packets of slowly growing size must not allocate every time.
class PacketBuffer {
 public:
  std::byte* data() { return bytes_.get(); }
  const std::byte* data() const { return bytes_.get(); }
  std::size_t capacity() const { return capacity_; }
  void grow(std::size_t capacity, std::size_t kept);  ///< keeps the first `kept` bytes

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t capacity_ = 0;
};

/// The result of a decompression.
struct Decompressed {
  bool whole = false;    ///< the frame is sound, ends with the packet and stays within the limit
  std::size_t size = 0;  ///< [B]
};

/// The expected contents of a packet. They select the fastest method, not the result.
enum class Expected : std::uint8_t { anything, events };

/// Decompresses packets, with memory that is reused.
class PacketDecompressor {
 public:
  PacketDecompressor();
  ~PacketDecompressor();
  PacketDecompressor(PacketDecompressor&&) noexcept;
  PacketDecompressor& operator=(PacketDecompressor&&) noexcept;

  /// Decompresses exactly one LZ4 or zstd frame of any valid kind to the front of `content`, which grows up to `limit` bytes.
  Decompressed decompress(Compression compression, std::span<const std::byte> stored, PacketBuffer& content, std::size_t limit,
                          Expected expected = Expected::anything);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Receives bytes piece by piece; each piece is valid during the call.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Compresses packets, with memory that is reused: LZ4 frames of 64 KiB blocks without checksums, independent at level 0 and
/// linked at level 9 (the vendor's software also links them at level 0); zstd frames with their content size, at level 3 or the
/// highest.
class PacketCompressor {
 public:
  PacketCompressor();
  ~PacketCompressor();
  PacketCompressor(PacketCompressor&&) noexcept;
  PacketCompressor& operator=(PacketCompressor&&) noexcept;

  /// Compresses `content` to a frame that begins after `reserved` bytes of `stored`. @return  the size of the frame
  /// @throws Error  if the library fails
  std::size_t compress(Compression compression, std::span<const std::byte> content, PacketBuffer& stored, std::size_t reserved);

  /// Compresses `size` bytes that `make` writes in pieces. The frame goes to `sink` in pieces too, so memory follows a piece.
  /// @throws Error  if the library fails, and everything that `make` and `sink` throw
  void compress_pieces(Compression compression, std::uint64_t size, const std::function<void(const ByteSink&)>& make,
                       const ByteSink& sink);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::events
