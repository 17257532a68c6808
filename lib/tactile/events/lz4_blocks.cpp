#include "tactile/events/lz4_blocks.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace tactile::events {
namespace {

constexpr unsigned long_length = 15;       ///< of literals or of a match: further bytes follow
constexpr std::size_t shortest_match = 4;  ///< added to the stored length of a match [B]

/// The most that `take_short` reads and writes: 5 literals and 18 bytes of a match, in writes of 8 bytes [B].
constexpr std::ptrdiff_t short_stored = 9, short_made = 24;

/// Masks for the literals in eight bytes.
constexpr std::array<std::uint64_t, 6> masks{0, 0xff, 0xffff, 0xffffff, 0xffffffff, 0xffffffffff};

template <class Number>
Number number_at(const std::uint8_t* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  return number;
}

/// The state of the decoding of a block.
struct Progress {
  const std::uint8_t* in;
  const std::uint8_t* in_end;
  std::uint8_t* out;
  std::uint8_t* out_end;
  const std::uint8_t* oldest;  ///< first byte that a match may use

  explicit Progress(const Lz4Block& block)
      : in(reinterpret_cast<const std::uint8_t*>(block.stored.data())),
        in_end(in + block.stored.size()),
        out(reinterpret_cast<std::uint8_t*>(block.room.data())),
        out_end(out + block.room.size()),
        oldest(out - block.before) {}

  /// The number of short sequences that surely fit, so that the ends need no check.
  std::ptrdiff_t sure_of() const { return std::min((in_end - in) / short_stored, (out_end - out) / short_made); }
};

/// Decodes a sequence of at most 5 literals and a match of 4 to 18 bytes at a distance of at least 8. False, without a change,
/// for any other sequence. There must be room.
[[gnu::always_inline]] inline bool take_short(const std::uint8_t*& in, std::uint8_t*& out, const std::uint8_t* oldest) {
  const std::size_t token = *in, literals = token >> 4, match = token & 15;
  if (literals >= masks.size() || match == long_length) [[unlikely]]
    return false;
  const std::size_t back = number_at<std::uint16_t>(in + 1 + literals);
  if (back < 8 || back > static_cast<std::size_t>(out - oldest)) [[unlikely]]
    return false;
  // The first 8 bytes of the match, overwritten by the literals.
  const std::uint8_t* from = out - back;
  auto bytes = number_at<std::uint64_t>(from);
  bytes ^= (bytes ^ number_at<std::uint64_t>(in + 1)) & masks[literals];
  std::memcpy(out, &bytes, 8);
  std::memcpy(out + 8, from + 8, 8);
  if (literals + match + shortest_match > 16) [[unlikely]]
    std::memcpy(out + 16, from + 16, 8);
  in += 1 + literals + 2;
  out += literals + match + shortest_match;
  return true;
}

/// A length, which may continue after its token; nothing if the block ends inside it.
std::optional<std::size_t> whole_length(std::size_t length, Progress& block) {
  if (length < long_length) return length;
  for (;;) {
    if (block.in == block.in_end) return std::nullopt;
    const std::uint8_t more = *block.in++;
    length += more;
    if (more != 255) return length;
  }
}

void repeat(std::uint8_t* out, std::size_t back, std::size_t length) {
  const std::uint8_t* from = out - back;
  while (length > back) {  // repeat all bytes so far
    std::memcpy(out, from, back);
    out += back;
    length -= back;
    back *= 2;
  }
  std::memcpy(out, from, length);
}

enum class Sequence : std::uint8_t { taken, last, broken };

/// Decodes any sequence.
[[gnu::noinline]] Sequence take(Progress& block) {
  if (block.in == block.in_end) return Sequence::broken;
  const std::size_t token = *block.in++;
  const std::optional<std::size_t> literals = whole_length(token >> 4, block);
  if (!literals || *literals > static_cast<std::size_t>(block.in_end - block.in) ||
      *literals > static_cast<std::size_t>(block.out_end - block.out))
    return Sequence::broken;
  std::memcpy(block.out, block.in, *literals);
  block.in += *literals;
  block.out += *literals;
  if (block.in == block.in_end) return Sequence::last;
  if (block.in_end - block.in < 2) return Sequence::broken;
  const std::size_t back = number_at<std::uint16_t>(block.in);
  block.in += 2;
  const std::optional<std::size_t> match = whole_length(token & 15, block);
  if (!match || back == 0 || back > static_cast<std::size_t>(block.out - block.oldest) ||
      *match + shortest_match > static_cast<std::size_t>(block.out_end - block.out))
    return Sequence::broken;
  repeat(block.out, back, *match + shortest_match);
  block.out += *match + shortest_match;
  return Sequence::taken;
}

/// Decodes the rest; false if the block is damaged.
bool finish(Progress& block) {
  Sequence sequence = Sequence::taken;
  while (sequence == Sequence::taken) {
    const std::uint8_t* in = block.in;
    std::uint8_t* out = block.out;
    const std::uint8_t* last_in = block.in_end - std::min(block.in_end - in, short_stored);
    const std::uint8_t* last_out = block.out_end - std::min(block.out_end - out, short_made);
    while (in < last_in && out < last_out && take_short(in, out, block.oldest)) continue;
    block.in = in;
    block.out = out;
    sequence = take(block);
  }
  return sequence == Sequence::last;
}

bool finish(Progress& first, Progress& second) {
  for (;;) {
    std::ptrdiff_t count = std::min(first.sure_of(), second.sure_of());
    if (count == 0) return finish(first) && finish(second);
    const std::uint8_t *first_in = first.in, *second_in = second.in;
    std::uint8_t *first_out = first.out, *second_out = second.out;
    Progress* other = nullptr;
    do {
      if (!take_short(first_in, first_out, first.oldest)) [[unlikely]] {
        other = &first;
        break;
      }
      if (!take_short(second_in, second_out, second.oldest)) [[unlikely]] {
        other = &second;
        break;
      }
    } while (--count > 0);
    first.in = first_in, first.out = first_out;
    second.in = second_in, second.out = second_out;
    if (other == nullptr) continue;
    const Sequence sequence = take(*other);
    if (sequence == Sequence::broken) return false;
    if (sequence == Sequence::last) return finish(other == &first ? second : first);
  }
}

std::size_t made(const Progress& progress, const Lz4Block& block) {
  return static_cast<std::size_t>(progress.out - reinterpret_cast<std::uint8_t*>(block.room.data()));
}

}  // namespace

std::optional<std::size_t> decode_lz4_block(const Lz4Block& block) {
  Progress progress(block);
  if (!finish(progress)) return std::nullopt;
  return made(progress, block);
}

std::optional<std::array<std::size_t, 2>> decode_lz4_blocks(const Lz4Block& first, const Lz4Block& second) {
  Progress progress(first), other(second);
  if (!finish(progress, other)) return std::nullopt;
  return std::array{made(progress, first), made(other, second)};
}

}  // namespace tactile::events
