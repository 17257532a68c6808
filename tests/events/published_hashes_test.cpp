// A recording of faery, which publishes a SHA3-224 of each column that its own reader finds. It is not part of this project.
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "events/recording_contents.hpp"
#include "support/real_recordings.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::events {
namespace {

namespace fs = std::filesystem;

/// @return  by column: what faery's tests expect of a file
std::map<std::string, std::string> published_hashes(const fs::path& expected_assets, const std::string& file) {
  std::string text = read_text(expected_assets);
  text.erase(0, text.find("/ \"" + file + "\""));
  const std::size_t begin = text.find("field_to_digest={"), end = text.find('}', begin);
  std::map<std::string, std::string> hashes;
  std::istringstream lines(text.substr(begin, end - begin));
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> quoted;
    std::istringstream parts(line);
    for (std::string part; std::getline(parts, part, '"');) quoted.push_back(part);
    if (quoted.size() >= 4) hashes[quoted[1]] = quoted[3];
  }
  return hashes;
}

template <class T>
void append_value(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The columns as faery hashes them: packed, little-endian.
std::map<std::string, std::string> columns_of(const test::RecordingContents& contents) {
  std::map<std::string, std::string> columns;
  for (const Event& event : contents.events) {
    append_value(columns["t"], us_of(event.t));
    append_value(columns["x"], event.x);
    append_value(columns["y"], event.y);
    append_value(columns["on"], event.on);
  }
  for (const ImuSample& sample : contents.imu) {
    std::string& bytes = columns["imus"];
    append_value(bytes, us_of(sample.t));
    append_value(bytes, sample.temperature_c);
    append_value(bytes, sample.acceleration_g);
    append_value(bytes, sample.angular_rate_dps);
    append_value(bytes, sample.magnetic_field_ut);
  }
  for (const Trigger& trigger : contents.triggers) {
    append_value(columns["triggers"], us_of(trigger.t));
    append_value(columns["triggers"], trigger.type);
  }
  for (const Frame& frame : contents.frames) columns["frame"].append(frame.pixels.begin(), frame.pixels.end());
  return columns;
}

std::map<std::string, std::string> sha3_224_of(const std::map<std::string, std::string>& columns) {
  const test::TemporaryFolder folder;
  for (const auto& [name, bytes] : columns) std::ofstream(folder / name, std::ios::binary) << bytes;
  const test::CommandResult python = test::run_shell(
      "python3 -c \"import hashlib, os; [print(name, hashlib.sha3_224(open(name, 'rb').read()).hexdigest()) for name in "
      "os.listdir('.')]\"",
      folder.path());
  std::map<std::string, std::string> hashes;
  std::istringstream words(python.out);
  for (std::string name, hash; words >> name >> hash;) hashes[name] = hash;
  return hashes;
}

TEST(PublishedHashes, AreThoseOfEventsFramesSamplesAndTriggersOfADavis) {
  const std::string name = "faery/davis346.aedat4";
  const fs::path file = test::real_recording(name), expected = test::real_recording("faery/expected_assets.py");
  if (file.empty() || expected.empty()) GTEST_SKIP() << test::not_tested_without(name);
  const auto published = published_hashes(expected, "davis346.aedat4");
  EXPECT_EQ(published.size(), 7U) << expected;
  EXPECT_EQ(sha3_224_of(columns_of(test::contents_of(file))), published);
}

}  // namespace
}  // namespace tactile::events
