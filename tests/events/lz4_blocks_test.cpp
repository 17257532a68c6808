#include "tactile/events/lz4_blocks.hpp"

#include <gtest/gtest.h>
#include <lz4.h>
#include <lz4frame.h>
#include <lz4hc.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/packet_compression.hpp"

namespace tactile::events {
namespace {

constexpr std::size_t full = std::size_t{64} << 10;

/// Events as a camera has them: now and then one that repeats what was long ago.
std::string events_like(std::mt19937& random, std::size_t size) {
  std::string result;
  std::int64_t t = 1'700'000'000'000'000;
  while (result.size() < size) {
    Event event;
    t += static_cast<std::int64_t>(random() % 3 == 0 ? random() % 200 : 0);
    event.t = camera_time(t);
    event.x = static_cast<std::int16_t>(random() % 640);
    event.y = static_cast<std::int16_t>(200 + random() % 20);
    event.on = random() % 2;
    result.append(reinterpret_cast<const char*>(&event), sizeof event);
  }
  result.resize(size);
  return result;
}

std::string noise(std::mt19937& random, std::size_t size) {
  std::string result(size, '\0');
  for (char& c : result) c = static_cast<char>(random());
  return result;
}

/// Pieces of few kinds of bytes and of many, that repeat others from any distance.
std::string patchwork(std::mt19937& random, std::size_t size) {
  std::string result = noise(random, 1);
  while (result.size() < size) {
    const std::size_t length = random() % 8 == 0 ? random() % 2000 : 1 + random() % 40;
    if (random() % 3 == 0) {
      result += noise(random, length);
      continue;
    }
    const std::size_t back = 1 + random() % std::min<std::size_t>(result.size(), random() % 2 == 0 ? 20 : 70'000);
    for (std::size_t i = 0; i < length; ++i) result += result[result.size() - back];
  }
  result.resize(size);
  return result;
}

std::vector<std::string> contents() {
  std::mt19937 random(1);
  std::vector<std::string> all{"", "a", "abcd", std::string(13, 'z'), std::string(full, '\0')};
  for (const std::size_t size : {5UL, 12UL, 17UL, 31UL, 100UL, 1'000UL, 4'097UL, 65'000UL, full - 1, full}) {
    all.push_back(events_like(random, size));
    all.push_back(noise(random, size));
    for (int i = 0; i < 4; ++i) all.push_back(patchwork(random, size));
  }
  return all;
}

std::string compressed(const std::string& content, bool high) {
  std::string stored(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(content.size()))), '\0');
  const auto size = static_cast<int>(content.size()), room = static_cast<int>(stored.size());
  const int made = high ? LZ4_compress_HC(content.data(), stored.data(), size, room, LZ4HC_CLEVEL_DEFAULT)
                        : LZ4_compress_default(content.data(), stored.data(), size, room);
  stored.resize(static_cast<std::size_t>(made));
  return stored;
}

/// Memory of exactly this size, so that a sanitizer detects an access outside it.
class Room {
 public:
  explicit Room(std::size_t size, std::size_t before = 0)
      : size_(size), before_(before), bytes_(new std::byte[before + size + 16]) {
    std::fill_n(bytes_.get(), before + size + 16, std::byte{0x5A});
  }
  Lz4Block block(const std::string& stored) {
    return {.stored = std::as_bytes(std::span(stored)), .room = {bytes_.get() + before_, size_}, .before = before_};
  }
  std::string text(std::size_t size) const { return {reinterpret_cast<const char*>(bytes_.get()) + before_, size}; }
  std::byte* before() { return bytes_.get(); }
  bool is_untouched_after() const {
    return std::all_of(bytes_.get() + before_ + size_, bytes_.get() + before_ + size_ + 16,
                       [](std::byte b) { return b == std::byte{0x5A}; });
  }

 private:
  std::size_t size_, before_;
  std::unique_ptr<std::byte[]> bytes_;
};

TEST(Lz4Blocks, AreDecodedToWhatWasCompressedAlsoWhereItJustFits) {
  for (const std::string& content : contents()) {
    for (const bool high : {false, true}) {
      const std::string stored = compressed(content, high);
      for (const std::size_t more : {0UL, 1UL, 30UL, full}) {
        Room room(content.size() + more);
        const auto size = decode_lz4_block(room.block(stored));
        ASSERT_EQ(size, content.size());
        ASSERT_EQ(room.text(*size), content);
        ASSERT_TRUE(room.is_untouched_after());
      }
      if (content.empty()) continue;
      Room narrow(content.size() - 1);
      EXPECT_FALSE(decode_lz4_block(narrow.block(stored)));
      EXPECT_TRUE(narrow.is_untouched_after());
    }
  }
}

TEST(Lz4Blocks, AreDecodedTwoAtATimeAsEachAlone) {
  const std::vector<std::string> all = contents();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = 0; k < all.size(); k += 3) {
      const std::string first = compressed(all[i], i % 2 == 0), second = compressed(all[k], k % 2 == 0);
      Room first_room(all[i].size()), second_room(all[k].size() + 40);
      const auto sizes = decode_lz4_blocks(first_room.block(first), second_room.block(second));
      ASSERT_TRUE(sizes);
      ASSERT_EQ(first_room.text((*sizes)[0]), all[i]);
      ASSERT_EQ(second_room.text((*sizes)[1]), all[k]);
      ASSERT_TRUE(first_room.is_untouched_after() && second_room.is_untouched_after());
    }
  }
}

TEST(Lz4Blocks, RepeatWhatIsBeforeThemAndNothingEarlier) {
  // A literal, then 8 bytes from 10 back, then 5 literals: two bytes are from before the room.
  const std::string stored = std::string("\x14") + "a" + std::string("\x0A\x00", 2) + "\x50" + "vwxyz";
  Room room(14, 9);
  std::memcpy(room.before(), "123456789", 9);
  ASSERT_EQ(decode_lz4_block(room.block(stored)), 14U);
  EXPECT_EQ(room.text(14), "a12345678vwxyz");
  Room less(14, 8);
  EXPECT_FALSE(decode_lz4_block(less.block(stored)));
}

TEST(Lz4Blocks, ThatAreBrokenAreRefused) {
  const auto decode = [](const std::string& stored) {
    Room room(100);
    return decode_lz4_block(room.block(stored));
  };
  EXPECT_FALSE(decode(""));
  EXPECT_FALSE(
      decode("\x30"
             "ab"));  // a literal is missing
  EXPECT_FALSE(
      decode(std::string("\x10"
                         "a\x01",
                         3)));  // half of a distance
  EXPECT_FALSE(
      decode(std::string("\x10"
                         "a\x00\x00\x10"
                         "b",
                         6)));  // a distance of nothing
  EXPECT_FALSE(
      decode(std::string("\x10"
                         "a\x02\x00\x10"
                         "b",
                         6)));  // before the beginning
  EXPECT_FALSE(
      decode(std::string("\x10"
                         "a\x01\x00",
                         4)));   // it ends with a match
  EXPECT_FALSE(decode("\xF0"));  // a length is missing
  EXPECT_FALSE(
      decode(std::string("\x1F"
                         "a\x01\x00\xFF\xFF",
                         6)));  // the same, after its first parts
  EXPECT_EQ(decode(std::string("\x10"
                               "a\x01\x00\x10"
                               "b",
                               6)),
            6U);  // as all of these might have been
}

TEST(Lz4Blocks, ThatWereDamagedTouchNothingOutsideTheirRoom) {
  std::mt19937 random(2);
  int sound = 0, broken = 0;
  const std::string whole = compressed(events_like(random, 3'000), false);
  for (int i = 0; i < 20'000; ++i) {
    std::string stored = i % 2 == 0 ? compressed(patchwork(random, 50 + random() % 500), i % 4 == 0)
                                    : compressed(events_like(random, 16 * (1 + random() % 60)), false);
    if (i % 5 == 0) stored.resize(random() % stored.size());
    for (unsigned k = random() % 4; k > 0 && !stored.empty(); --k) stored[random() % stored.size()] = static_cast<char>(random());
    // A copy of exactly its size.
    const std::vector<char> exact(stored.begin(), stored.end());
    const std::size_t size = random() % 1'500;
    Room room(size), again(size), other(3'000), theirs(size);
    Lz4Block block = room.block(stored), same = again.block(stored);
    block.stored = same.stored = std::as_bytes(std::span(exact));
    const auto alone = decode_lz4_block(block);
    const auto two = decode_lz4_blocks(same, other.block(whole));
    ASSERT_TRUE(room.is_untouched_after() && again.is_untouched_after() && other.is_untouched_after());
    ASSERT_EQ(alone.has_value(), two.has_value());
    const int by_library = LZ4_decompress_safe(exact.data(), reinterpret_cast<char*>(theirs.before()),
                                               static_cast<int>(exact.size()), static_cast<int>(size));
    ++(alone ? sound : broken);
    if (!alone) continue;
    ASSERT_EQ((*two)[0], *alone);
    ASSERT_EQ(room.text(*alone), again.text(*alone));
    if (by_library < 0) continue;  // it refuses some whose match ends too near to the end
    ASSERT_EQ(static_cast<std::size_t>(by_library), *alone);
    ASSERT_EQ(room.text(*alone), theirs.text(*alone));
  }
  EXPECT_GT(sound, 1'000);
  EXPECT_GT(broken, 1'000);
}

/// Frames of blocks that were ended before they were full, of `pieces` each.
std::string frame_of(const std::vector<std::string>& pieces, LZ4F_blockMode_t mode) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max64KB;
  preferences.frameInfo.blockMode = mode;
  LZ4F_cctx* context = nullptr;
  LZ4F_createCompressionContext(&context, LZ4F_VERSION);
  std::string frame(LZ4F_HEADER_SIZE_MAX, '\0');
  frame.resize(LZ4F_compressBegin(context, frame.data(), frame.size(), &preferences));
  const auto append = [&](std::size_t room, const auto& make) {
    const std::size_t before = frame.size();
    frame.resize(before + room);
    frame.resize(before + make(frame.data() + before, room));
  };
  for (const std::string& piece : pieces) {
    append(LZ4F_compressBound(piece.size(), &preferences), [&](char* to, std::size_t room) {
      return LZ4F_compressUpdate(context, to, room, piece.data(), piece.size(), nullptr);
    });
    append(LZ4F_compressBound(0, &preferences),
           [&](char* to, std::size_t room) { return LZ4F_flush(context, to, room, nullptr); });
  }
  append(LZ4F_compressBound(0, &preferences),
         [&](char* to, std::size_t room) { return LZ4F_compressEnd(context, to, room, nullptr); });
  LZ4F_freeCompressionContext(context);
  return frame;
}

TEST(Lz4Blocks, OfFramesMayBeShortUncompressedLinkedOrNot) {
  std::mt19937 random(3);
  PacketDecompressor decompressor;
  PacketBuffer content;
  const auto decompress = [&](const std::string& frame, std::size_t limit) {
    return decompressor.decompress(Compression::lz4, std::as_bytes(std::span(frame)), content, limit, Expected::events);
  };
  for (int round = 0; round < 60; ++round) {
    std::vector<std::string> pieces;
    std::string all(4, '\0');  // a packet's own length, which is looked at where it has to grow
    if (round % 8 != 0) pieces.push_back(all);
    if (pieces.empty()) all.clear();
    for (std::uint64_t i = pieces.empty() ? 0 : random() % 6; i > 0; --i) {
      const std::size_t size = random() % 2 == 0 ? random() % 300 : random() % 200'000;
      pieces.push_back(random() % 4 == 0   ? noise(random, size)
                       : random() % 4 == 0 ? std::string(size, 'x')
                                           : events_like(random, size));
      all += pieces.back();
    }
    for (const auto mode : {LZ4F_blockLinked, LZ4F_blockIndependent}) {
      const std::string frame = frame_of(pieces, mode);
      if (round % 2 == 0) content = {};  // it must grow then
      const Decompressed made = decompress(frame, std::size_t{2} << 20);
      ASSERT_TRUE(made.whole);
      ASSERT_EQ(std::string(reinterpret_cast<const char*>(content.data()), made.size), all);
      if (all.empty()) continue;
      EXPECT_FALSE(decompress(frame, all.size() - 1).whole);
      for (const std::size_t cut : {std::size_t{1}, std::size_t{4}, std::size_t{5}, frame.size() / 2, frame.size() - 7}) {
        const std::string short_frame = frame.substr(0, frame.size() - cut);
        EXPECT_FALSE(decompress(short_frame, std::size_t{2} << 20).whole);
      }
      const std::string longer = frame + '\0';
      EXPECT_FALSE(decompress(longer, std::size_t{2} << 20).whole);
    }
  }
}

}  // namespace
}  // namespace tactile::events
