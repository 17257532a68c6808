#include "tactile/windows/event_columns.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::windows {
namespace {

constexpr std::size_t chunk = EventColumns::rows_per_chunk;

std::vector<events::Event> events_for_columns(std::size_t count) {
  Random random(11);
  std::vector<events::Event> events(count);
  for (std::size_t i = 0; i < count; ++i) {
    events[i].t = camera_time(static_cast<std::int64_t>(i) * 3 - 1'000'000);
    events[i].x = static_cast<std::int16_t>(random.below(640));
    events[i].y = static_cast<std::int16_t>(random.below(480));
    events[i].on = static_cast<std::uint8_t>(random.below(2));
  }
  return events;
}

/// A file of events that are written in pieces of these sizes.
class WrittenColumns {
 public:
  WrittenColumns(std::span<const events::Event> events, const std::vector<std::size_t>& sizes) {
    const hdf5::Session session;
    hdf5::Id file = hdf5::create_file(file_, hdf5::Structure::checked);
    {
      EventColumns columns(file, "events.h5");
      for (const std::size_t size : sizes) {
        const auto end = events.begin() + static_cast<std::ptrdiff_t>(size);
        columns.write(EventColumns::packed(columns.full_chunks_with({events.begin(), end})));
        events = events.subspan(size);
      }
      columns.finish();
    }
    file.close("events.h5");
    EXPECT_TRUE(events.empty()) << "the sizes are not those of all events";
  }

  std::string bytes() const { return read_text(file_); }

  std::vector<events::Event> events() const {
    const hdf5::Session session;
    const hdf5::Id file = hdf5::open_file(file_, false);
    const auto t = hdf5::read_table<std::int64_t>(file, "t_us", "events.h5");
    const auto x = hdf5::read_table<std::uint16_t>(file, "x", "events.h5"),
               y = hdf5::read_table<std::uint16_t>(file, "y", "events.h5");
    const auto on = hdf5::read_table<std::uint8_t>(file, "on", "events.h5");
    std::vector<events::Event> events(t.size());
    for (std::size_t i = 0; i < t.size(); ++i) {
      events[i].t = camera_time(t[i]);
      events[i].x = static_cast<std::int16_t>(x.at(i));
      events[i].y = static_cast<std::int16_t>(y.at(i));
      events[i].on = on.at(i);
    }
    return events;
  }

 private:
  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "events.h5";
};

TEST(EventColumns, GiveTheSameBytesForAnyPieces) {
  const std::vector<events::Event> all = events_for_columns(3 * chunk + 5);
  const WrittenColumns at_once(all, {all.size()});
  EXPECT_EQ(at_once.events(), all);
  const auto bytes_of = [&](const std::vector<std::size_t>& sizes) { return WrittenColumns(all, sizes).bytes(); };
  EXPECT_EQ(bytes_of({0, 1, chunk - 1, chunk, 0, chunk - 1, 1, 5}), at_once.bytes());  // pieces end where chunks end
  EXPECT_EQ(bytes_of({chunk + 1, chunk - 2, 2, chunk - 1, 5}), at_once.bytes());       // or one event beside that
  EXPECT_EQ(bytes_of({7, 2 * chunk + 7, chunk - 9}), at_once.bytes());                 // a joined chunk, then full ones
}

TEST(EventColumns, OfWholeChunksHaveNoFurtherOne) {
  const std::vector<events::Event> all = events_for_columns(2 * chunk);
  EXPECT_EQ(WrittenColumns(all, {all.size()}).events(), all);
  EXPECT_EQ(WrittenColumns({}, {0}).events(), std::vector<events::Event>{});
}

}  // namespace
}  // namespace tactile::windows
