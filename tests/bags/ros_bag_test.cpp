#include "tactile/bags/ros_bag.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <string>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::bags {
namespace {

namespace fs = std::filesystem;
const fs::path bags = fs::path(test::data_folder) / "bags";

struct Contents {
  std::map<std::string, int> messages;  ///< by topic
  std::string digest;                   ///< of all in their order
  BagProblems problems;
};

Contents contents_of(RosBagReader& bag) {
  Contents contents;
  Sha256 digest;
  while (const auto message = bag.next()) {
    ++contents.messages[message->connection->topic];
    digest.add(message->connection->topic + std::to_string(us_of(message->received)));
    digest.add(message->data);
  }
  contents.digest = digest.hex();
  contents.problems = bag.problems();
  return contents;
}
Contents contents_of(const fs::path& file) {
  RosBagReader bag(file);
  return contents_of(bag);
}

/// The bag with `value` written little-endian over the bytes after the first `name=` after `from`.
std::string patched(std::string bytes, const std::string& name, std::uint32_t value, std::size_t from = 0) {
  const std::size_t at = bytes.find(name + "=", from);
  EXPECT_NE(at, std::string::npos);
  for (std::size_t i = 0; i < 4; ++i) bytes[at + name.size() + 1 + i] = static_cast<char>(value >> (8 * i) & 0xFF);
  return bytes;
}

Contents contents_of_bytes(const std::string& bytes) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "made.bag", std::ios::binary) << bytes;
  return contents_of(folder / "made.bag");
}

TEST(RosBagReader, GivesTheSameMessagesFromEveryCompression) {
  const Contents plain = contents_of(bags / "run.bag");
  EXPECT_EQ(plain.messages, (std::map<std::string, int>{{"/camera/image_raw", 6},
                                                        {"/chatter", 1},
                                                        {"/dvs/events", 100},
                                                        {"/dvs/imu", 20},
                                                        {"/joint_states", 126},
                                                        {"/tf", 126}}));
  for (const char* name : {"run-lz4.bag", "run-bz2.bag"}) {
    const Contents packed = contents_of(bags / name);
    EXPECT_EQ(packed.digest, plain.digest) << name;
    EXPECT_EQ(packed.problems.broken_chunks, 0U);
  }
}

TEST(RosBagReader, StartsAgainWhenRewound) {
  RosBagReader bag(bags / "run-lz4.bag");
  for (int i = 0; i < 10; ++i) bag.next();
  bag.rewind();
  EXPECT_EQ(contents_of(bag).digest, contents_of(bags / "run.bag").digest);
  EXPECT_EQ(bag.bytes_read(), bag.file_size());
}

TEST(RosBagReader, ReadsABagWithoutItsIndex) {
  std::string bytes = read_text(bags / "mono.bag");
  const std::size_t index = bytes.find("op=\x07", bytes.find("op=\x04"));
  ASSERT_NE(index, std::string::npos);
  bytes.resize(index);  // inside the first record after the chunks
  const Contents cut = contents_of_bytes(bytes);
  EXPECT_EQ(cut.digest, contents_of(bags / "mono.bag").digest);
  EXPECT_GT(cut.problems.truncated_bytes, 0U);
}

TEST(RosBagReader, ReadsACutBagUpToTheCutWhereverThatIs) {
  const std::string whole = read_text(bags / "no-events.bag");
  const std::size_t chunk_end = whole.find("op=\x04");  // its one chunk is followed by that chunk's index
  for (std::size_t size = 13; size < whole.size(); size += 7) {
    if (size + 60 > chunk_end && size < chunk_end) continue;  // inside the header before it
    const Contents cut = contents_of_bytes(whole.substr(0, size));
    EXPECT_LE(cut.messages.size(), 1U) << size;
    EXPECT_GE(cut.messages.size(), size > chunk_end ? 1U : 0U) << size;
    EXPECT_EQ(cut.problems.broken_chunks, 0U) << size;
  }
}

TEST(RosBagReader, GivesTheFrontOfAChunkThatIsCutOff) {
  const test::TemporaryFolder folder;
  for (const char* name : {"run.bag", "run-lz4.bag"}) {
    const std::string whole = read_text(bags / name);
    write_whole(folder / "cut.bag", whole.substr(0, whole.find("op=\x04") * 2 / 3));  // its first chunk, in part
    const Contents cut = contents_of(folder / "cut.bag"), all = contents_of(bags / name);
    EXPECT_GT(cut.messages.at("/dvs/events"), 5) << name;
    EXPECT_LT(cut.messages.at("/dvs/events"), all.messages.at("/dvs/events")) << name;
    EXPECT_GT(cut.problems.truncated_bytes, 0U);
    EXPECT_EQ(cut.problems.broken_chunks, 0U);
    RosBagReader reader(bags / name), reader_of_cut(folder / "cut.bag");
    while (const auto message = reader_of_cut.next()) {
      const auto expected = reader.next();
      ASSERT_TRUE(expected &&
                  std::equal(message->data.begin(), message->data.end(), expected->data.begin(), expected->data.end()))
          << name;
    }
  }
}

TEST(RosBagReader, PassesOverAChunkThatDoesNotDecompress) {
  for (const char* name : {"run-lz4.bag", "run-bz2.bag"}) {
    const std::string whole = read_text(bags / name);
    const std::size_t chunk = whole.find("compression=");
    for (const std::uint32_t size : {0xFFFFFFFFU, 0x0FFFFFFFU, 100U, 0U}) {
      const Contents patched_size = contents_of_bytes(patched(whole, "size", size, chunk - 40));
      EXPECT_GE(patched_size.problems.broken_chunks, 1U) << name << " " << size;
      EXPECT_LT(patched_size.messages.count("/dvs/events") + patched_size.messages.size(), 7U);
    }
    std::string damaged = whole;
    damaged[chunk + 200] ^= 0x55;
    EXPECT_NO_THROW(contents_of_bytes(damaged));
  }
}

TEST(RosBagReader, CountsMessagesOfUndeclaredConnections) {
  const std::string whole = read_text(bags / "no-events.bag");
  const std::size_t message = whole.find("op=\x02");
  const Contents contents = contents_of_bytes(patched(whole, "conn", 99, message - 60));
  EXPECT_EQ(contents.messages.size() + contents.problems.unknown_messages, 1U);
}

TEST(RosBagReader, RefusesWhatIsNoSuchBag) {
  const test::TemporaryFolder folder;
  write_whole(folder / "old.bag", "#ROSBAG V1.2\nrest");
  write_whole(folder / "empty.bag", "");
  write_whole(folder / "only-magic.bag", "#ROSBAG V2.0\n");
  EXPECT_THROW(RosBagReader(folder / "old.bag"), Error);
  EXPECT_THROW(RosBagReader(folder / "empty.bag"), Error);
  EXPECT_THROW(RosBagReader(folder / "none.bag"), Error);
  EXPECT_THROW(RosBagReader{folder.path()}, Error);
  EXPECT_TRUE(contents_of(folder / "only-magic.bag").messages.empty());
}

TEST(RosBagReader, RefusesAnEncryptedBag) {
  const std::string fields = std::string("\x04\0\0\0op=\x03", 8) + std::string("\x15\0\0\0encryptor=rosbag/Aes.", 25);
  std::string bytes = "#ROSBAG V2.0\n";
  bytes += static_cast<char>(fields.size());
  bytes += std::string(3, '\0') + fields + std::string(4, '\0');
  EXPECT_THROW(contents_of_bytes(bytes), Error);
}

}  // namespace
}  // namespace tactile::bags
