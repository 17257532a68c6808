#include "tactile/bags/bag_chunk.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "tactile/bags/bag_file.hpp"

namespace tactile::bags {
namespace {

constexpr std::size_t lz4_spare = std::size_t{128} << 10;  // room to decode a chunk's last block in place

/// Decompresses bzip2 to the front of `content`: whole only if it gives exactly `size` bytes; otherwise as much as possible.
events::Decompressed decompress_bz2(Bytes stored, events::PacketBuffer& content, std::size_t size) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return {};
  struct End {
    bz_stream& stream;
    ~End() { BZ2_bzDecompressEnd(&stream); }
  } const end{stream};
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(stored.data()));
  stream.avail_in = static_cast<unsigned>(stored.size());
  content.grow(size + 1, 0);  // one byte more shows that it is too long; unused memory costs nothing
  std::size_t done = 0;
  while (done <= size) {
    const std::size_t room = size + 1 - done;
    stream.next_out = reinterpret_cast<char*>(content.data() + done);
    stream.avail_out = static_cast<unsigned>(room);
    const unsigned had_in = stream.avail_in;
    const int result = BZ2_bzDecompress(&stream);
    const std::size_t got = room - stream.avail_out;
    done += got;
    if (result == BZ_STREAM_END) return {.whole = done == size, .size = done};
    if (result != BZ_OK || (got == 0 && had_in == stream.avail_in)) break;  // damaged, or cut off
  }
  return {.whole = false, .size = done};
}

/// Decompresses the front of an LZ4 frame to the front of `content`, at most `size` bytes.
std::size_t decompress_lz4_front(Bytes stored, events::PacketBuffer& content, std::size_t size) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0U) return 0;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> end(context, LZ4F_freeDecompressionContext);
  content.grow(size, 0);
  std::size_t used = 0, done = 0;
  while (used < stored.size() && done < size) {
    std::size_t input = stored.size() - used, output = size - done;
    const std::size_t rest = LZ4F_decompress(context, content.data() + done, &output, stored.data() + used, &input, nullptr);
    if (LZ4F_isError(rest) != 0U) break;
    used += input;
    done += output;
    if (rest == 0 || (input == 0 && output == 0)) break;
  }
  return done;
}

/// Decompresses the front of a zstd frame to the front of `content`, at most `size` bytes.
std::size_t decompress_zstd_front(Bytes stored, events::PacketBuffer& content, std::size_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (!context) return 0;
  content.grow(size, 0);
  ZSTD_inBuffer input{stored.data(), stored.size(), 0};
  ZSTD_outBuffer output{content.data(), size, 0};
  while (output.pos < output.size) {
    const std::size_t had = output.pos, used = input.pos;
    const std::size_t rest = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(rest) != 0U || rest == 0 || (output.pos == had && input.pos == used)) break;
  }
  return output.pos;
}

}  // namespace

std::optional<Bytes> BagChunk::contents(std::string_view method, Bytes stored, std::size_t claimed, bool is_cut) {
  if (claimed > most_chunk) return std::nullopt;
  if (method == "none" || method.empty()) {
    if (is_cut || stored.size() == claimed) return stored.first(std::min(claimed, stored.size()));
    return std::nullopt;
  }
  if (method == "bz2") {
    const events::Decompressed made = decompress_bz2(stored, content_, claimed);
    if (!made.whole && !is_cut) return std::nullopt;
    return Bytes(content_.data(), std::min(made.size, claimed));
  }
  const bool is_lz4 = method == "lz4";
  if (!is_lz4 && method != "zstd") return std::nullopt;
  const events::Compression compression = is_lz4 ? events::Compression::lz4 : events::Compression::zstd;
  const std::size_t largest = std::min(claimed, events::largest_content(compression, stored.size()));
  if (is_cut) {
    const std::size_t made =
        is_lz4 ? decompress_lz4_front(stored, content_, largest) : decompress_zstd_front(stored, content_, largest);
    return Bytes(content_.data(), made);
  }
  content_.grow(largest + lz4_spare, 0);  // otherwise it grows by doubling
  const events::Decompressed made = decompressor_.decompress(compression, stored, content_, claimed);
  if (!made.whole || made.size != claimed) return std::nullopt;
  return Bytes(content_.data(), made.size);
}

std::optional<Bytes> BagChunk::zstd_message(Bytes stored) {
  const events::Decompressed made = decompressor_.decompress(events::Compression::zstd, stored, content_, most_chunk);
  if (!made.whole) return std::nullopt;
  return Bytes(content_.data(), made.size);
}

}  // namespace tactile::bags
