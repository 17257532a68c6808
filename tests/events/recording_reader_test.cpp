#include "tactile/events/recording_reader.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "events/recording_contents.hpp"
#include "support/paths.hpp"
#include "support/vendor_files.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::events {
namespace {

using test::vendor_files;

// Files that the vendor's own writer made, and what went into them.
class VendorFile : public testing::TestWithParam<const char*> {
 protected:
  std::filesystem::path file() const { return vendor_files / (std::string(GetParam()) + ".aedat4"); }
  nlohmann::json truth() const { return read_json(vendor_files / "truth.json").at(GetParam()); }
};

TEST_P(VendorFile, IsReadAsItWasWritten) {
  const nlohmann::json expected = truth();
  RecordingReader recording(file());
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  EXPECT_EQ(recording.file_size(), expected.at("bytes"));
  std::string compression(name_of(recording.compression()));
  std::transform(compression.begin(), compression.end(), compression.begin(),
                 [](char c) { return c == '-' ? '_' : std::toupper(c); });
  EXPECT_EQ(compression, expected.at("compression").get<std::string>());
  const Stream& stream = event_stream(recording);
  EXPECT_EQ(stream.source, expected.at("source").get<std::string>());
  EXPECT_EQ(stream.name, "events");
  ASSERT_TRUE(stream.size.has_value());
  EXPECT_EQ(stream.size->width, expected.at("width"));
  EXPECT_EQ(stream.size->height, expected.at("height"));

  const auto all = test::contents_of(recording);
  EXPECT_EQ(all.events.size(), expected.at("events"));
  EXPECT_EQ(all.event_packets, expected.at("event_packets"));
  EXPECT_EQ(us_of(all.events.front().t), expected.at("first_us"));
  EXPECT_EQ(us_of(all.events.back().t), expected.at("last_us"));
  std::int64_t on = 0;
  std::int64_t sum_x = 0;
  std::int64_t sum_y = 0;
  for (const Event& e : all.events) {
    on += e.on;
    sum_x += e.x;
    sum_y += e.y;
  }
  EXPECT_EQ(on, expected.at("on"));
  EXPECT_EQ(sum_x, expected.at("sum_x"));
  EXPECT_EQ(sum_y, expected.at("sum_y"));
  EXPECT_EQ(all.event_digest(), expected.at("digest").get<std::string>());
  EXPECT_EQ(all.imu.size(), expected.value("imu", 0U));
  EXPECT_EQ(all.triggers.size(), expected.value("triggers", 0U));
  EXPECT_EQ(all.frames.size(), expected.value("frames", 0U));
  if (expected.contains("imu_last_us")) {
    EXPECT_EQ(us_of(all.imu.back().t), expected.at("imu_last_us"));
  }
  if (expected.contains("frames_sha256")) {
    EXPECT_EQ(all.frame_digest(), expected.at("frames_sha256").get<std::string>());
  }
}

INSTANTIATE_TEST_SUITE_P(All, VendorFile,
                         testing::Values("dv-none", "dv-lz4", "dv-lz4-high", "dv-zstd", "dv-zstd-high", "dv-events-only"),
                         [](const testing::TestParamInfo<const char*>& file) {
                           std::string name = file.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace tactile::events
