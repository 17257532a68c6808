#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "events/aedat4_bytes.hpp"
#include "events/recording_contents.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::test {

inline std::string vendor_bytes(const std::string& name) { return bytes_of(vendor_files / (name + ".aedat4")); }

/// A recording from bytes, in a folder of its own.
class DamagedRecording : public ::testing::Test {
 protected:
  events::RecordingReader reader_of(const std::string& bytes) {
    return events::RecordingReader(write_bytes(folder_ / ("recording" + std::to_string(++made_) + ".aedat4"), bytes));
  }
  RecordingContents contents_of(const std::string& bytes) {
    events::RecordingReader recording = reader_of(bytes);
    return test::contents_of(recording);
  }
  std::string error_of(const std::string& bytes) {
    try {
      reader_of(bytes);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }

  TemporaryFolder folder_;
  int made_ = 0;
};

#define EXPECT_SAYS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

inline const std::string one_camera = xml_of(event_node(0, 640, 480, "DVXplorer_DXM00001"));

/// n events, one a microsecond from t on, at places that differ.
inline std::vector<events::Event> row_of_events(std::int64_t t, int n) {
  std::vector<events::Event> events;
  for (int i = 0; i < n; ++i) events.push_back(event(t + i, (7 * i) % 640, (5 * i) % 480, i % 2));
  return events;
}

/// Three packets of one camera, and the entries that a sound table has for them.
struct ThreePackets {
  explicit ThreePackets(int compression = 0) {
    bytes = file_start(compression, one_camera);
    for (int i = 0; i < 3; ++i) {
      const auto events = row_of_events(1000 * i, 10 + i);
      const std::string payload = compression == 1 ? lz4(event_payload(events)) : event_payload(events);
      const auto offset = static_cast<std::int64_t>(bytes.size() + 8);
      entries.push_back({.offset = offset,
                         .id = 0,
                         .size = static_cast<std::int32_t>(payload.size()),
                         .elements = 10 + i,
                         .first = 1000 * i,
                         .last = 1000 * i + 9 + i});
      bytes += packet(0, payload);
      all.insert(all.end(), events.begin(), events.end());
    }
  }
  std::string bytes;
  std::vector<TableEntry> entries;
  std::vector<events::Event> all;
};

}  // namespace tactile::test
