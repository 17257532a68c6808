#include <lz4.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "abort_unless.hpp"
#include "tactile/events/lz4_blocks.hpp"

/// For any input, a block is decoded to the same bytes as by the library, or refused. The first byte chooses between contents
/// that are compressed first and a block, and the size of the output.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  using test::abort_unless;
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
  std::vector<char> theirs(room), ours(room), first(room), second(room);
  const int by_library =
      LZ4_decompress_safe(stored.data(), theirs.data(), static_cast<int>(stored.size()), static_cast<int>(room));
  const auto block = [&](std::vector<char>& to) {
    return events::Lz4Block{.stored = std::as_bytes(std::span(stored)), .room = std::as_writable_bytes(std::span(to))};
  };
  const auto alone = events::decode_lz4_block(block(ours));
  const auto two = events::decode_lz4_blocks(block(first), block(second));
  abort_unless(alone.has_value() == two.has_value() && (alone || !is_content));
  if (!alone) return 0;
  const auto same = [&](const std::vector<char>& other, std::size_t length) {
    return length == *alone && std::memcmp(ours.data(), other.data(), length) == 0;
  };
  abort_unless(same(first, (*two)[0]) && same(second, (*two)[1]));
  abort_unless(by_library < 0 || same(theirs, static_cast<std::size_t>(by_library)));
  abort_unless(!is_content || (by_library >= 0 && std::memcmp(ours.data(), data + 1, *alone) == 0));
  return 0;
}
