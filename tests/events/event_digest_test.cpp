#include "tactile/events/event_digest.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "events/made_recording.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

constexpr SensorSize sensor_of_digest{64, 48};

std::string digest_of(const std::vector<Event>& events) {
  EventDigest digest;
  digest.add(events);
  return digest.text();
}

TEST(EventDigest, IsThatOfTheEventsInWhateverFile) {
  const test::TemporaryFolder folder;
  const std::vector<Event> events = test::steady_events(5'000, 5'000'000, 100, sensor_of_digest);
  const std::string digest = digest_of(events);
  EXPECT_EQ(digest.size(), 16U);
  for (const auto& [compression, packet_events] :
       {std::pair(Compression::none, 500), std::pair(Compression::lz4, 1'000), std::pair(Compression::zstd, 70)}) {
    const auto file = folder / (std::to_string(packet_events) + ".aedat4");
    RecordingWriter writer(file, {event_stream_declaration(sensor_of_digest, "DVXplorer_DXM00001")},
                           {.compression = compression, .packet_events = static_cast<std::size_t>(packet_events)});
    writer.write_events(0, events);
    writer.close();
    EXPECT_EQ(event_digest_of(file), digest) << packet_events;
  }
}

TEST(EventDigest, IsAnotherIfAnyPartOfAnEventIs) {
  const std::vector<Event> events = test::steady_events(100, 5'000'000, 100, sensor_of_digest);
  const std::string digest = digest_of(events);
  const auto changed = [&](std::size_t i, auto change) {
    std::vector<Event> others = events;
    change(others[i]);
    return digest_of(others);
  };
  for (const std::size_t i : {std::size_t{0}, std::size_t{50}, std::size_t{99}}) {
    EXPECT_NE(changed(i, [](Event& event) { event.t = after(event.t, microseconds{1}); }), digest) << i;
    EXPECT_NE(changed(i, [](Event& event) { event.x ^= 1; }), digest) << i;
    EXPECT_NE(changed(i, [](Event& event) { event.y ^= 1; }), digest) << i;
    EXPECT_NE(changed(i, [](Event& event) { event.on ^= 1; }), digest) << i;
  }
  std::vector<Event> others = events;
  std::swap(others[10], others[11]);
  EXPECT_NE(digest_of(others), digest) << "their order counts";
  EXPECT_NE(digest_of({events.begin(), events.end() - 1}), digest);
  EXPECT_NE(digest_of({}), digest_of({Event{}})) << "an event of zeros counts";
}

}  // namespace
}  // namespace tactile::events
