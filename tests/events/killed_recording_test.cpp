// What a recording holds whose writer was killed, or met a full disk.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <new>
#include <thread>

#include "events/aedat4_bytes.hpp"
#include "events/made_streams.hpp"
#include "events/recording_contents.hpp"
#include "events/rewrite.hpp"
#include "support/comes_true.hpp"
#include "support/file_size_limit.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

using test::event;
using test::mini;

/// The event that a writing process makes as its i-th.
Event numbered_event(std::int64_t i) {
  return event(1'700'000'000'000'000 + i / 3, static_cast<int>(i * 7 % 640), static_cast<int>(i * 11 % 480),
               static_cast<int>(i % 2));
}

TEST(KilledRecording, HoldsEveryFlushedPacketAndAnExactPrefix) {
  const test::TemporaryFolder folder;
  Random random(11);
  std::int64_t most = 0;
  for (int moment = 0; moment < 20; ++moment) {
    const auto file = folder / ("killed" + std::to_string(moment) + ".aedat4");
    const auto compression = static_cast<Compression>(moment % 4);
    void* shared = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(shared, MAP_FAILED);
    auto* flushed = new (shared) std::atomic<std::int64_t>(-1);  // -1: the file is not begun
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      try {
        RecordingWriter writer(file, {mini}, {.compression = compression, .packet_events = 500});
        flushed->store(0);
        std::vector<Event> events(300);
        for (std::int64_t next = 0;;) {
          for (Event& e : events) e = numbered_event(next++);
          writer.write_events(0, events);
          if (next % 9'000 == 0) {
            writer.flush();
            flushed->store(next);
          }
        }
      } catch (...) {
      }
      ::_exit(1);
    }
    const auto kept = static_cast<std::int64_t>(9'000 * random.below(4));
    const bool has_kept = test::comes_true([&] { return flushed->load() >= kept; });
    std::this_thread::sleep_for(microseconds{random.below(10'000)});
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "it was to end by the kill alone";
    ASSERT_TRUE(has_kept) << kept;

    RecordingReader recording(file);
    EXPECT_EQ(recording.index(), PacketIndex::scan);
    EXPECT_EQ(recording.problems().broken_packets + recording.problems().undeclared_packets + recording.problems().empty_packets,
              0U);
    std::int64_t read = 0;
    for_all_events(recording, 0, [&](std::span<const Event> events) {
      for (const Event& e : events) ASSERT_EQ(e, numbered_event(read++));
    });
    EXPECT_GE(read, flushed->load());
    most = std::max(most, read);
    ::munmap(shared, 4096);
  }
  EXPECT_GT(most, 9'000) << "no kill came late enough for a test";
}

TEST(KilledRecording, OnAFullDiskGivesBackTheRoomOfAPartOfAPacket) {
  const test::TemporaryFolder folder;
  const auto file = folder / "full.aedat4";
  std::uintmax_t whole = 0;
  {
    RecordingWriter writer(file, {mini}, {.compression = Compression::none});
    std::vector<Event> events(1000);
    for (std::int64_t i = 0; i < 1000; ++i) events[static_cast<std::size_t>(i)] = numbered_event(i);
    writer.write_events(0, events);
    writer.flush();
    whole = std::filesystem::file_size(file);
    writer.write_events(0, std::array{numbered_event(1000)});
    {
      const test::FileSizeLimit little(whole + 10);  // room for a part of the next packet, and none for a table
      EXPECT_THROW(writer.close(), Error);
    }
    EXPECT_EQ(writer.written().front().elements, 1000U) << "what waited is not in the file";
  }
  EXPECT_EQ(std::filesystem::file_size(file), whole);
  RecordingReader recording(file);
  EXPECT_EQ(recording.index(), PacketIndex::scan);
  std::int64_t read = 0;
  for_all_events(recording, 0, [&](std::span<const Event> events) { read += static_cast<std::int64_t>(events.size()); });
  EXPECT_EQ(read, 1000);
}

TEST(KilledRecording, OnAFullDiskReportsItAndKeepsItsWholePackets) {
  const test::TemporaryFolder folder;
  const auto file = folder / "full.aedat4";
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);  // writing beyond the limit then fails as it does on a full disk
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit little{.rlim_cur = 100'000, .rlim_max = limit.rlim_max};
    int outcome = 1;
    try {
      RecordingWriter writer(file, {mini}, {.compression = Compression::none, .packet_events = 500});
      ::setrlimit(RLIMIT_FSIZE, &little);
      std::vector<Event> events(300);
      try {
        for (std::int64_t next = 0; next < 300'000;) {
          for (Event& e : events) e = numbered_event(next++);
          writer.write_events(0, events);
        }
      } catch (const Error&) {
        outcome = 2;
        ::setrlimit(RLIMIT_FSIZE, &limit);
        writer.close();  // there is room again
        outcome = 0;
      }
    } catch (...) {
    }
    ::_exit(outcome);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  RecordingReader recording(file);
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  std::int64_t read = 0;
  for_all_events(recording, 0, [&](std::span<const Event> events) {
    for (const Event& e : events) ASSERT_EQ(e, numbered_event(read++));
  });
  EXPECT_GE(read, 5'500);
}

}  // namespace
}  // namespace tactile::events
