#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/bags/bag.hpp"
#include "tactile/bags/bag_contents.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::bags {
namespace {

namespace fs = std::filesystem;
const fs::path ros2_bags = fs::path(test::data_folder) / "bags";

struct Ros2Contents {
  std::vector<std::string> messages;  ///< topic, time of arrival and digest of each
  BagProblems problems;
};

Ros2Contents ros2_contents_of(BagReader& bag) {
  Ros2Contents contents;
  while (const auto message = bag.next()) {
    Sha256 digest;
    digest.add(message->data);
    contents.messages.push_back(message->connection->topic + " " + std::to_string(us_of(message->received)) + " " + digest.hex());
  }
  contents.problems = bag.problems();
  return contents;
}
Ros2Contents ros2_contents_of(const fs::path& file) { return ros2_contents_of(*open_bag(file)); }
Ros2Contents ros2_contents_of_bytes(const std::string& bytes) {
  const test::TemporaryFolder folder;
  write_whole(folder / "made", bytes);
  return ros2_contents_of(folder / "made");
}

/// Whether the messages are the first of all.
bool is_front(const Ros2Contents& part, const Ros2Contents& all) {
  return part.messages.size() <= all.messages.size() &&
         std::equal(part.messages.begin(), part.messages.end(), all.messages.begin());
}

TEST(OpenBag, GivesTheSameMessagesFromEveryForm) {
  const Ros2Contents lz4 = ros2_contents_of(ros2_bags / "run-lz4.mcap");
  EXPECT_EQ(lz4.messages.size(), 379U);
  for (const char* name : {"run-zstd.mcap", "run-file.db3.zstd", "run-message.db3"})
    EXPECT_EQ(ros2_contents_of(ros2_bags / name).messages, lz4.messages) << name;
  EXPECT_EQ(ros2_contents_of(ros2_bags / "mono.mcap").messages, ros2_contents_of(ros2_bags / "mono.db3").messages);
}

TEST(OpenBag, StartsAgainWhenRewound) {
  for (const char* name : {"mono.mcap", "mono.db3", "run-file.db3.zstd"}) {
    const auto bag = open_bag(ros2_bags / name);
    for (int i = 0; i < 10; ++i) bag->next();
    bag->rewind();
    EXPECT_EQ(ros2_contents_of(*bag).messages, ros2_contents_of(ros2_bags / name).messages) << name;
    EXPECT_EQ(bag->bytes_read(), bag->file_size()) << name;
  }
}

TEST(OpenBag, RefusesWhatIsNoBag) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(ros2_contents_of_bytes("text"), Error);
  EXPECT_THROW(ros2_contents_of_bytes(""), Error);
  EXPECT_THROW(ros2_contents_of_bytes(std::string("SQLite format 3\0", 16)), Error);
  EXPECT_THROW(open_bag(folder / "none.db3"), Error);
  EXPECT_THROW(open_bag(folder.path()), Error);
}

TEST(McapReader, ReadsAFileUpToTheCutWhereverThatIs) {
  for (const char* name : {"mono.mcap", "run-lz4.mcap", "run-zstd.mcap"}) {
    const std::string whole = read_text(ros2_bags / name);
    const Ros2Contents all = ros2_contents_of(ros2_bags / name);
    std::size_t most = 0;
    for (std::size_t size = 8; size < whole.size(); size += 997) {
      const Ros2Contents cut = ros2_contents_of_bytes(whole.substr(0, size));
      EXPECT_TRUE(is_front(cut, all)) << name << " " << size;
      EXPECT_GE(cut.messages.size(), most) << name << " " << size;
      EXPECT_EQ(cut.problems.broken_chunks, 0U) << name << " " << size;
      most = std::max(most, cut.messages.size());
    }
    EXPECT_EQ(most, all.messages.size()) << name;  // the summary at the end is not needed
  }
}

TEST(McapReader, PassesOverAChunkWithAWrongChecksum) {
  std::string bytes = read_text(ros2_bags / "mono.mcap");
  const std::size_t all = ros2_contents_of(ros2_bags / "mono.mcap").messages.size();
  bytes[15'000] = static_cast<char>(bytes[15'000] ^ 1);  // in the second of its chunks
  const Ros2Contents damaged = ros2_contents_of_bytes(bytes);
  EXPECT_EQ(damaged.problems.broken_chunks, 1U);
  EXPECT_LT(damaged.messages.size(), all);
  EXPECT_GT(damaged.messages.size(), all / 3);
}

TEST(SqliteBagReader, ReadsAFileUpToTheCut) {
  const std::string whole = read_text(ros2_bags / "mono.db3");
  const Ros2Contents all = ros2_contents_of(ros2_bags / "mono.db3");
  std::size_t most = 0;
  for (std::size_t size = 20'480; size < whole.size(); size += 4096) {
    const Ros2Contents cut = ros2_contents_of_bytes(whole.substr(0, size));
    EXPECT_TRUE(is_front(cut, all)) << size;
    EXPECT_EQ(cut.problems.truncated_bytes, whole.size() - size);
    most = std::max(most, cut.messages.size());
  }
  EXPECT_GT(most, all.messages.size() / 2);
}

TEST(SqliteBagReader, GivesTheSameFromADamagedFileWhenRewound) {
  const std::string whole = read_text(ros2_bags / "run-message.db3");
  const test::TemporaryFolder folder;
  int read = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(seed);
    std::string damaged = whole;
    for (int n = 0; n < 40; ++n) damaged[4096 + random.below(damaged.size() - 4096)] = static_cast<char>(random.below(256));
    write_whole(folder / "damaged.db3", damaged);
    try {
      const auto bag = open_bag(folder / "damaged.db3");
      const Ros2Contents first = ros2_contents_of(*bag);
      bag->rewind();
      ASSERT_EQ(ros2_contents_of(*bag).messages, first.messages) << seed;
      read += first.messages.empty() ? 0 : 1;
    } catch (const Error&) {  // its tables cannot be found
    }
  }
  EXPECT_GT(read, 100);
}

TEST(SqliteBagReader, EndsWhereADamagedFileGivesItsPagesAgainAndAgain) {
  const test::TemporaryFolder folder;
  // Of three inner pages, every entry of the first leads to the second, of the second to the third, and of the third to one leaf.
  write_whole(folder / "damage.py", R"(
import sqlite3, sys
c = sqlite3.connect('many.db3', isolation_level=None)
c.execute('PRAGMA page_size=512'); c.execute('VACUUM')
c.execute('BEGIN')
topic = c.execute('SELECT id FROM topics').fetchone()[0]
c.executemany('INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)', [(topic, i, bytes(100)) for i in range(4000)])
c.execute('COMMIT'); c.close()
data = bytearray(open('many.db3', 'rb').read())
root = [p for p in range(1, len(data) // 512) if data[512 * p] == 5]
number = lambda at, size: int.from_bytes(data[at:at + size], 'big')
entries = lambda page: [512 * page + 8] + [512 * page + number(512 * page + 12 + 2 * i, 2) for i in range(number(512 * page + 3, 2))]
children = lambda page: [number(at, 4) - 1 for at in entries(page)]
inner = [p for p in root if all(data[512 * child] == 13 for child in children(p))][:3]
assert len(inner) == 3
leaf = children(inner[2])[0]
for page, child in zip(inner, inner[1:] + [leaf]):
    for at in entries(page):
        data[at:at + 4] = (child + 1).to_bytes(4, 'big')
open('many.db3', 'wb').write(data)
)");
  std::filesystem::copy_file(ros2_bags / "mono.db3", folder / "many.db3");
  const auto made = test::run_shell("/usr/bin/python3 damage.py", folder.path());
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto bag = open_bag(folder / "many.db3");
  std::uint64_t bytes = 0;
  while (const auto message = bag->next()) bytes += message->data.size();
  EXPECT_LE(bytes, bag->file_size());
  EXPECT_GT(bytes, bag->file_size() / 2);
  EXPECT_EQ(bag->problems().broken_chunks, 1U);
}

TEST(SqliteBagReader, ReadsTheLogOfAKilledRecorder) {
  const test::TemporaryFolder folder;
  // The process ends without closing the file, so its newest message is in the write-ahead log alone.
  const std::string script = "import os, shutil, sqlite3; shutil.copy('" + (ros2_bags / "mono.db3").string() +
                             "', 'killed.db3'); c = sqlite3.connect('killed.db3'); c.execute('PRAGMA journal_mode=WAL'); "
                             "c.execute(\"INSERT INTO messages SELECT max(id) + 1, topic_id, timestamp, x'00010000' FROM "
                             "messages\"); c.commit(); os._exit(9)";
  write_whole(folder / "kill.py", script);
  test::run_shell("python3 kill.py", folder.path());
  ASSERT_TRUE(fs::exists(folder / "killed.db3-wal"));
  EXPECT_EQ(ros2_contents_of(folder / "killed.db3").messages.size(),
            ros2_contents_of(ros2_bags / "mono.db3").messages.size() + 1);
}

TEST(ReadBagContents, CountsWhatTopicsContain) {
  const BagContents contents = read_bag_contents(ros2_bags / "mono.mcap");
  ASSERT_EQ(contents.topics.size(), 1U);
  const TopicContents& topic = contents.topics.front();
  EXPECT_EQ(topic.encoding, "mono");
  EXPECT_EQ(topic.events, 2'000U);
  EXPECT_EQ(topic.messages, 100U);
  EXPECT_EQ(topic.lost_packets, 1U);
  EXPECT_EQ(contents.format, "ROS 2 bag (MCAP)");
}

}  // namespace
}  // namespace tactile::bags
