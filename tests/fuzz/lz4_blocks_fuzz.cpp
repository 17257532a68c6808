#include <lz4.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "tactile/events/lz4_blocks.hpp"

/// Whatever the bytes, a block is decoded as by the library, or refused. The first byte says what the others are: contents to be
/// compressed first, or a block, and how much room it has.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  if (size < 2 || size > 1 << 16) return 0;
  const bool is_content = *data % 2 == 0;
  std::vector<char> stored(data + 1, data + size);
  const std::size_t room = is_content ? stored.size() : *data * 16UL;
  if (is_content) {
    std::vector<char> made(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(stored.size()))));
    const int made_size =
        LZ4_compress_default(stored.data(), made.data(), static_cast<int>(stored.size()), static_cast<int>(made.size()));
    stored.assign(made.begin(), made.begin() + made_size);
  }
  std::vector<char> theirs(room), ours(room), again(room), last(room);
  const int by_library =
      LZ4_decompress_safe(stored.data(), theirs.data(), static_cast<int>(stored.size()), static_cast<int>(room));
  const auto block = [&](std::vector<char>& to) {
    return Lz4Block{.stored = std::as_bytes(std::span(stored)), .room = std::as_writable_bytes(std::span(to))};
  };
  const auto alone = decode_lz4_block(block(ours));
  const auto two = decode_lz4_blocks(block(again), block(last));
  if (alone.has_value() != two.has_value() || (is_content && !alone)) std::abort();
  if (!alone) return 0;
  const auto same = [&](const std::vector<char>& other, std::size_t length) {
    return length == *alone && std::memcmp(ours.data(), other.data(), length) == 0;
  };
  if (!same(again, (*two)[0]) || !same(last, (*two)[1])) std::abort();
  if (by_library >= 0 && !same(theirs, static_cast<std::size_t>(by_library))) std::abort();
  if (is_content && (by_library < 0 || std::memcmp(ours.data(), data + 1, *alone) != 0)) std::abort();
  return 0;
}
