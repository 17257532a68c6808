#include "tactile/conversion/hdf5_recording.hpp"

#include <gtest/gtest.h>

#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/conversion/convert.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_health.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::conversion {
namespace {

using test::vendor_files;

namespace fs = std::filesystem;

/// Runs Python lines in `folder`, with numpy as np and h5py; returns what they print.
std::string python(const test::TemporaryFolder& folder, const std::string& lines) {
  write_whole(folder / "script.py", "import json, hashlib, struct\nimport h5py\nimport numpy as np\n" + lines);
  const test::CommandResult result = test::run_shell("/usr/bin/python3 script.py", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  fs::remove(folder / "script.py");
  return result.out;
}

/// The error for a file.
std::string hdf5_refusal_of(const fs::path& file, const ConvertOptions& options = {}) {
  const test::TemporaryFolder folder;
  try {
    convert_recording(file, folder / "out.aedat4", options);
  } catch (const Error& e) {
    EXPECT_TRUE(fs::is_empty(folder.path()));
    return e.what();
  }
  ADD_FAILURE() << file << " was taken";
  return {};
}

TEST(Hdf5Recording, GivesEveryElementBack) {
  const test::TemporaryFolder folder;
  for (const char* name : {"dv-lz4", "dv-zstd-high", "dv-none"}) {
    const fs::path in = vendor_files / (std::string(name) + ".aedat4"), middle = folder / (std::string(name) + ".h5");
    const ConvertSummary there = convert_recording(in, middle);
    convert_recording(middle, folder / (std::string(name) + ".aedat4"));
    test::RecordingContents expected = test::contents_of(in);
    EXPECT_EQ(there.left_out.size(), expected.frames.empty() ? 0U : 1U);
    expected.frames.clear();
    EXPECT_TRUE(same(test::contents_of(folder / (std::string(name) + ".aedat4")), expected)) << name;
    EXPECT_TRUE(events::examine_recording(folder / (std::string(name) + ".aedat4")).healthy());
    const events::RecordingReader before(in), after(folder / (std::string(name) + ".aedat4"));
    for (const events::Stream& stream : after.streams()) {
      const events::Stream& original = before.stream(stream.id);
      EXPECT_EQ(stream.source, original.source);
      EXPECT_EQ(stream.name, original.name);
      EXPECT_EQ(stream.size, original.size);
      EXPECT_EQ(stream.info, original.info);
    }
  }
}

TEST(Hdf5Recording, IsWhatPythonFindsTrue) {
  const test::TemporaryFolder folder;
  const nlohmann::json truth = read_json(vendor_files / "truth.json");
  for (const auto& [name, expected] : truth.items()) {
    convert_recording(vendor_files / (name + ".aedat4"), folder / "made.h5");
    const nlohmann::json sums = nlohmann::json::parse(python(
        folder,
        "f = h5py.File('made.h5')\n"
        "t, x, y, on = (f['events/' + n][:] for n in ('t_us', 'x', 'y', 'on'))\n"
        "assert [c.dtype.str for c in (t, x, y, on)] == ['<i8', '<u2', '<u2', '|u1']\n"
        "rows = np.rec.fromarrays([t, x, y, on], dtype=[('t', '<i8'), ('x', '<u2'), ('y', '<u2'), ('on', 'u1')])\n"
        "print(json.dumps(dict(events=len(t), on=int(on.sum()), sum_x=int(x.sum()), sum_y=int(y.sum()), first_us=int(t[0]),\n"
        "    last_us=int(t[-1]), digest=hashlib.sha256(rows.tobytes()).hexdigest(),\n"
        "    width=int(f.attrs['sensor_width']), source=f.attrs['source'].decode(), "
        "compression=f['events/t_us'].compression)))\n"));
    for (const char* key : {"events", "on", "sum_x", "sum_y", "first_us", "last_us", "digest"})
      EXPECT_EQ(sums.at(key), expected.at(key)) << name << ": " << key;
    const events::RecordingReader recording(vendor_files / (name + ".aedat4"));
    EXPECT_EQ(sums.at("width"), events::event_stream(recording).size->width);
    EXPECT_EQ(sums.at("source"), events::event_stream(recording).source);
    EXPECT_EQ(sums.at("compression"), "gzip");
    fs::remove(folder / "made.h5");
  }
}

TEST(Hdf5Recording, GivesTheSameBytesForTheSameInput) {
  const test::TemporaryFolder folder;
  convert_recording(vendor_files / "dv-lz4.aedat4", folder / "a.h5");
  convert_recording(vendor_files / "dv-lz4.aedat4", folder / "b.h5");
  EXPECT_TRUE(read_text(folder / "a.h5") == read_text(folder / "b.h5"));
}

TEST(Hdf5Recording, KeepsSeveralStreamsApart) {
  const test::TemporaryFolder folder;
  const std::vector<events::Event> left = test::steady_events(150'000, 0, 10, {64, 48}),
                                   right = test::steady_events(50, 7, 100, {32, 24});
  {
    events::Stream second = test::stream_of(4, events::StreamType::events, "EVTS", "B");
    second.size = events::SensorSize{32, 24};
    events::RecordingWriter writer(folder / "two.aedat4", {events::event_stream_declaration({64, 48}, "A"), second});
    writer.write_events(0, left);
    writer.write_events(4, right);
    writer.close();
  }
  convert_recording(folder / "two.aedat4", folder / "two.h5");
  EXPECT_EQ(
      python(folder,
             "f = h5py.File('two.h5')\nprint(sorted(f), len(f['events/x']), len(f['events_4/x']), f['events_4'].attrs['width'])"),
      "['events', 'events_4'] 150000 50 32\n");
  convert_recording(folder / "two.h5", folder / "back.aedat4");
  events::RecordingReader back(folder / "back.aedat4");
  std::vector<events::Event> events;
  const auto keep = [&](std::span<const events::Event> some) { events.insert(events.end(), some.begin(), some.end()); };
  events::for_all_events(back, 0, keep);
  EXPECT_EQ(events, left);
  events.clear();
  events::for_all_events(back, 4, keep);
  EXPECT_EQ(events, right);
  EXPECT_LT(back.packets()[1].first, camera_time(20'000));  // the streams are interleaved
  EXPECT_EQ(convert_recording(folder / "two.h5", folder / "b.csv", {.streams = {"B"}}).streams.at(0).elements, 50U);
}

TEST(Hdf5Recording, ReadsWhatAnotherProgramMade) {
  const test::TemporaryFolder folder;
  python(folder,
         "with h5py.File('theirs.h5', 'w') as f:\n"
         "    f['events/t_us'] = np.arange(100000, dtype='uint64')\n"
         "    f['events/x'] = np.arange(100000, dtype='int32') % 640\n"
         "    f.create_dataset('events/y', data=np.arange(100000) % 480, chunks=(777,), compression='gzip')\n"
         "    f['events/on'] = np.arange(100000) % 2 == 0\n"
         "    f.attrs['sensor_width'] = 640\n"
         "    f.attrs['sensor_height'] = np.uint16(480)\n"
         "    f.attrs['source'] = 'a text of variable length'\n");
  convert_recording(folder / "theirs.h5", folder / "out.aedat4");
  const test::RecordingContents contents = test::contents_of(folder / "out.aedat4");
  ASSERT_EQ(contents.events.size(), 100'000U);
  EXPECT_EQ(contents.events.at(99'999), test::event_at(99'999, 99'999 % 640, 99'999 % 480, 0));
  EXPECT_EQ(contents.events.at(2), test::event_at(2, 2, 2, 1));
  EXPECT_EQ(events::RecordingReader(folder / "out.aedat4").streams().front().source, "a text of variable length");
}

TEST(Hdf5Recording, TakesTheSensorFromTheUserWhereTheFileLacksIt) {
  const test::TemporaryFolder folder;
  python(folder,
         "with h5py.File('theirs.h5', 'w') as f:\n"
         "    for n in ('t_us', 'x', 'y', 'on'): f['events/' + n] = np.array([0, 1])\n");
  EXPECT_NE(hdf5_refusal_of(folder / "theirs.h5").find("--size WxH"), std::string::npos);
  convert_recording(folder / "theirs.h5", folder / "out.aedat4", {.size = events::SensorSize{320, 240}, .source = "mine"});
  EXPECT_EQ(events::RecordingReader(folder / "out.aedat4").streams().front().size, (events::SensorSize{320, 240}));
  EXPECT_EQ(events::RecordingReader(folder / "out.aedat4").streams().front().source, "mine");
  convert_recording(folder / "out.aedat4", folder / "out.h5");
  EXPECT_NE(hdf5_refusal_of(folder / "out.h5", {.size = events::SensorSize{64, 48}}).find("omit --size"), std::string::npos);
}

TEST(Hdf5Recording, ReportsInWordsWhatIsWrongWithAFile) {
  const test::TemporaryFolder folder;
  const auto refusal = [&](const std::string& change) {
    python(folder,
           "with h5py.File('bad.h5', 'w') as f:\n"
           "    columns = dict(t_us=np.arange(5), x=np.arange(5), y=np.arange(5), on=np.ones(5, dtype='u1'))\n"
           "    f.attrs['sensor_width'], f.attrs['sensor_height'] = 64, 48\n" +
               change + "\n    for n, v in columns.items(): f.create_dataset('events/' + n, data=v)\n");
    return hdf5_refusal_of(folder / "bad.h5");
  };
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(refusal("    columns['x'] = np.arange(4)"), "/events/x: has 4 rows, and t_us has 5");
  expect(refusal("    del columns['on']"), "/events/on: is missing");
  expect(refusal("    columns['t_us'] = np.arange(5) / 1e6"),
         "/events/t_us: holds another kind of values; expected whole numbers");
  expect(refusal("    columns['y'] = np.zeros((5, 2), dtype=int)"), "/events/y: has another shape; expected [rows]");
  expect(refusal("    columns['x'] = np.array([0, 1, 64, 3, 4])"), "/events/x: row 2 is 64; expected 0 to 63");
  expect(refusal("    columns['y'] = np.array([0, 1, 2, -1, 4])"), "/events/y: row 3 is -1; expected 0 to 47");
  expect(refusal("    columns['y'] = np.array([0, 1, 2, 2**33, 4])"), "/events/y: row 3 is");
  expect(refusal("    columns['on'] = np.array([0, 1, 2, 1, 1])"), "/events/on: row 2 is 2; expected 0 to 1");
  expect(refusal("    columns['t_us'] = np.array([0, 5, 4, 6, 7])"), "/events/t_us: time goes back in row 2, from 5 to 4 us");
  expect(refusal("    columns['t_us'] = np.array([0, 1, 2, 3, 2**63 + 5], dtype='uint64')"), "/events/t_us: row 4 is beyond");
  expect(refusal("    f.attrs['sensor_width'] = 0"), "0x48 pixels");
  expect(refusal("    columns = {}\n    f['other'] = 1"), "contains no recording, only other");
  expect(refusal("    columns = {}\n    f['events'] = np.zeros(3, dtype=[('t', 'i8'), ('x', 'u2')])"), "/events: is not a group");
  write_whole(folder / "bad.h5", "no HDF5 at all");
  expect(hdf5_refusal_of(folder / "bad.h5"), "cannot be opened");
}

TEST(Hdf5Recording, NeverAllocatesForWhatAFileMerelyClaims) {
  const test::TemporaryFolder folder;
  python(
      folder,
      "with h5py.File('huge.h5', 'w') as f:\n"
      "    f.attrs['sensor_width'], f.attrs['sensor_height'] = 64, 48\n"
      "    for n in ('t_us', 'x', 'y', 'on'): f.create_dataset('events/' + n, shape=(2**40,), dtype='i8', chunks=(1024,))\n"
      "with h5py.File('chunk.h5', 'w') as f:\n"
      "    f.attrs['sensor_width'], f.attrs['sensor_height'] = 64, 48\n"
      "    for n in ('t_us', 'x', 'y', 'on'):\n"
      "        f.create_dataset('events/' + n, shape=(5,), maxshape=(None,), dtype='i8', chunks=(2**28,), compression='gzip')\n");
  EXPECT_NE(hdf5_refusal_of(folder / "huge.h5").find("claims more values than its file can contain"), std::string::npos);
  EXPECT_NE(hdf5_refusal_of(folder / "chunk.h5").find("chunks of more than 64 MiB"), std::string::npos);
}

/// Reads a recording's every element; whether that gives an error.
bool is_refused(const fs::path& file) {
  try {
    Hdf5RecordingReader reader(file);
    std::vector<std::int32_t> ids;
    for (const events::Stream& stream : reader.streams()) ids.push_back(stream.id);
    const auto nothing = [](const events::Stream&, const auto&) {};
    reader.read(ids, {.events = nothing, .imu = nothing, .triggers = nothing});
    return false;
  } catch (const Error&) {
    return true;
  }
}

TEST(Hdf5Recording, NeverCrashesOnADamagedFile) {
  const test::TemporaryFolder folder;
  convert_recording(vendor_files / "dv-lz4.aedat4", folder / "ours.h5", {.to = camera_time(1'000), .to_counts_from_first = true});
  python(folder,
         "with h5py.File('theirs.h5', 'w') as f:\n"
         "    f['events/t_us'] = np.arange(500, dtype='uint64')\n"
         "    f.create_dataset('events/x', data=np.arange(500) % 64, chunks=(77,), scaleoffset=0)\n"
         "    f.create_dataset('events/y', data=np.arange(500) % 48, chunks=(77,), compression='gzip', shuffle=True)\n"
         "    f['events/on'] = np.arange(500) % 2 == 0\n"
         "    f.attrs['sensor_width'], f.attrs['sensor_height'] = 64, 48\n"
         "    f.attrs['source'] = 'a text of variable length'\n");
  Random random(3);
  for (const char* name : {"ours.h5", "theirs.h5"}) {
    const std::string whole = read_text(folder / name);
    ASSERT_FALSE(is_refused(folder / name)) << name;
    int refused = 0;
    const auto attempt = [&](std::size_t offset, std::string patch) {
      patch.resize(std::min(patch.size(), whole.size() - offset));
      write_whole(folder / "damaged.h5", std::string(whole).replace(offset, patch.size(), patch));
      refused += is_refused(folder / "damaged.h5") ? 1 : 0;
    };
    for (std::size_t offset = 2; offset < std::min(whole.size(), std::size_t{65536}); offset += 64)
      attempt(offset, std::string(8, '\0'));
    for (int i = 0; i < 150; ++i) {
      std::string patch(1 + random.below(16), '\0');
      for (char& byte : patch) byte = static_cast<char>(random.below(256));
      attempt(random.below(whole.size()), patch);
    }
    EXPECT_GT(refused, 20) << name;
  }
}

TEST(Hdf5Recording, ReportsThatADatasetIsNoRecording) {
  const test::TemporaryFolder folder;
  python(folder,
         "for name, attributes in (('dataset.h5', ()), ('dataset.events.h5', ('manifest_sha256',))):\n"
         "    with h5py.File(name, 'w') as f:\n"
         "        g = f.create_group('events')\n"
         "        for a in attributes: g.attrs[a] = 'ab'\n"
         "        if not attributes: f.create_group('runs')\n"
         "with h5py.File('linked.h5', 'w') as f: f['events'] = h5py.ExternalLink('other.h5', '/events')\n");
  for (const char* name : {"dataset.h5", "dataset.events.h5"})
    EXPECT_NE(hdf5_refusal_of(folder / name).find("is the events file of a dataset"), std::string::npos);
  EXPECT_NE(hdf5_refusal_of(folder / "linked.h5").find("lies in another file"), std::string::npos);
}

TEST(Hdf5Recording, NeverHoldsTimesThatStepBack) {
  const test::TemporaryFolder folder;
  const events::Stream stream = events::event_stream_declaration({64, 48}, "A");
  Hdf5RecordingWriter writer(folder / "out.h5", {&stream, 1});
  const std::vector<events::Event> events{test::event_at(5, 1, 1, 1), test::event_at(4, 1, 1, 1)};
  EXPECT_THROW(writer.write_events(0, events), Error);
}

TEST(Hdf5Recording, LeavesOutASizeThatAStreamDoesNotHave) {
  const test::TemporaryFolder folder;
  events::Stream sized = events::event_stream_declaration({64, 48}, "A"),
                 sizeless = test::stream_of(4, events::StreamType::events, "EVTS", "B");
  const std::vector<events::Stream> streams{sized, sizeless};
  Hdf5RecordingWriter writer(folder / "two.h5", streams);
  writer.write_events(0, test::steady_events(30, 0, 100, {64, 48}));
  writer.write_events(4, test::steady_events(30, 0, 100, {320, 240}));
  writer.close();
  EXPECT_NE(hdf5_refusal_of(folder / "two.h5").find("--size WxH"), std::string::npos);
  const Hdf5RecordingReader reader(folder / "two.h5", events::SensorSize{320, 240});
  EXPECT_EQ(reader.streams()[0].size, (events::SensorSize{64, 48}));
  EXPECT_EQ(reader.streams()[1].size, (events::SensorSize{320, 240}));
}

TEST(Hdf5Recording, NamesACompressionThatIsMissing) {
  const test::TemporaryFolder folder;
  python(folder,
         "with h5py.File('theirs.h5', 'w') as f:\n"
         "    for n in ('t_us', 'x', 'y', 'on'):\n"
         "        f.create_dataset('events/' + n, data=np.zeros(1000, dtype='i8'), chunks=(100,), compression='lzf')\n");
  const std::string message = hdf5_refusal_of(folder / "theirs.h5", {.size = events::SensorSize{64, 48}});
  EXPECT_NE(message.find("/events/t_us: compressed with lzf (HDF5 filter 32000), which this program does not have; expected gzip "
                         "or none"),
            std::string::npos)
      << message;
}

/// What DSEC and Metavision write: the filter is named first, then the layout.
TEST(Hdf5Recording, RefusesTheLayoutsOfOtherProgramsInOneSentence) {
  const test::TemporaryFolder folder;
  python(folder,
         "with h5py.File('dsec.h5', 'w') as f:\n"
         "    for n in ('t', 'x', 'y', 'p'): f['events/' + n] = np.arange(5)\n"
         "    f['t_offset'] = 7\n"
         "with h5py.File('packed.h5', 'w') as f:\n"
         "    for n in ('t', 'x', 'y', 'p'): f.create_dataset('events/' + n, data=np.arange(5), chunks=(5,), compression='lzf')\n"
         "with h5py.File('metavision.h5', 'w') as f:\n"
         "    events = np.zeros(5, dtype=[('x', 'u2'), ('y', 'u2'), ('p', 'i2'), ('t', 'i8')])\n"
         "    f.create_dataset('CD/events', data=events, chunks=(5,), compression='lzf')\n");
  const auto expect = [&](const char* file, const char* part) {
    const std::string message = hdf5_refusal_of(folder / file);
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(
      "dsec.h5",
      "dsec.h5: /events: has the columns of another program, p, t, x, y; expected those that 'tactile convert' writes: t_us, x, "
      "y and on");
  expect("packed.h5", "packed.h5: /events/p: compressed with lzf (HDF5 filter 32000)");
  expect("metavision.h5", "metavision.h5: /CD/events: compressed with lzf (HDF5 filter 32000)");
}

}  // namespace
}  // namespace tactile::conversion
