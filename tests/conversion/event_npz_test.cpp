#include "tactile/conversion/event_npz.hpp"

#include <gtest/gtest.h>

#include "events/made_recording.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/conversion/convert.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::conversion {
namespace {

using test::vendor_files;

namespace fs = std::filesystem;

/// What Python finds in an NPZ, as truth.json has it.
nlohmann::json numpy_sums(const fs::path& file) {
  const test::TemporaryFolder folder;
  write_whole(folder / "sums.py",
              "import hashlib, json, sys, zipfile\n"
              "import numpy as np\n"
              "assert zipfile.ZipFile(sys.argv[1]).testzip() is None\n"
              "f = np.load(sys.argv[1])\n"
              "e = f['events']\n"
              "assert e.dtype == np.dtype([('t_us', '<i8'), ('x', '<u2'), ('y', '<u2'), ('on', 'u1')]), e.dtype\n"
              "print(json.dumps(dict(events=len(e), on=int(e['on'].sum()), sum_x=int(e['x'].sum()), sum_y=int(e['y'].sum()),\n"
              "    first_us=int(e['t_us'][0]) if len(e) else None, last_us=int(e['t_us'][-1]) if len(e) else None,\n"
              "    digest=hashlib.sha256(e.tobytes()).hexdigest(), size=f['sensor_size'].tolist(), files=f.files)))\n");
  const test::CommandResult python = test::run_shell("/usr/bin/python3 sums.py '" + file.string() + "'", folder.path());
  EXPECT_EQ(python.exit_code, 0) << python.err;
  return nlohmann::json::parse(python.out, nullptr, false);
}

TEST(EventNpz, IsWhatNumPyFindsTrue) {
  const test::TemporaryFolder folder;
  const nlohmann::json truth = read_json(vendor_files / "truth.json");
  for (const auto& [name, expected] : truth.items()) {
    convert_recording(vendor_files / (name + ".aedat4"), folder / (name + ".npz"));
    const nlohmann::json sums = numpy_sums(folder / (name + ".npz"));
    for (const char* key : {"events", "on", "sum_x", "sum_y", "first_us", "last_us", "digest"})
      EXPECT_EQ(sums.at(key), expected.at(key)) << name << ": " << key;
    EXPECT_EQ(sums.at("files"), (nlohmann::json{"events", "sensor_size"}));
  }
}

TEST(EventNpz, HoldsTheSensorsSizeAndAnyNumberOfEvents) {
  const test::TemporaryFolder folder;
  for (const std::size_t count : {0U, 1U, 65'536U, 65'537U, 200'000U}) {
    const fs::path file = folder / (std::to_string(count) + ".npz");
    EventNpzWriter writer(file, {346, 260});
    const std::vector<events::Event> events = test::steady_events(count, -5, 3, {346, 260});
    writer.write(std::span(events).first(count / 3));
    writer.write(std::span(events).subspan(count / 3));
    writer.close();
    const nlohmann::json sums = numpy_sums(file);
    EXPECT_EQ(sums.at("events"), count);
    EXPECT_EQ(sums.at("size"), (nlohmann::json{346, 260}));
    if (count > 0) {
      EXPECT_EQ(sums.at("last_us"), -5 + 3 * (static_cast<std::int64_t>(count) - 1));
    }
  }
}

TEST(EventNpz, GivesTheSameBytesForTheSameEvents) {
  const test::TemporaryFolder folder;
  convert_recording(vendor_files / "dv-lz4.aedat4", folder / "a.npz");
  convert_recording(vendor_files / "dv-lz4.aedat4", folder / "other.aedat4", {.compression = events::Compression::zstd});
  convert_recording(folder / "other.aedat4", folder / "b.npz");
  EXPECT_TRUE(read_text(folder / "a.npz") == read_text(folder / "b.npz"));
}

TEST(EventNpz, CountsStepsBackInTimeAndWritesThem) {
  const test::TemporaryFolder folder;
  EventNpzWriter writer(folder / "a.npz", {64, 48});
  const std::vector<events::Event> events{test::event_at(5), test::event_at(4), test::event_at(4), test::event_at(9)};
  writer.write(events);
  writer.close();
  EXPECT_EQ(writer.steps_back(), 1U);
  EXPECT_EQ(numpy_sums(folder / "a.npz").at("events"), 4);
  EXPECT_THROW(EventNpzWriter(folder / "a.npz", {64, 48}), Error);
}

}  // namespace
}  // namespace tactile::conversion
