#include "tactile/conversion/convert.hpp"

#include <gtest/gtest.h>

#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/conversion/hdf5_recording.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/events/recording_health.hpp"

namespace tactile::conversion {
namespace {

using test::files_in;
using test::vendor_files;

namespace fs = std::filesystem;

TEST(RecordingFormatOf, GoesByTheExtension) {
  EXPECT_EQ(recording_format_of("a/b.aedat4"), RecordingFormat::aedat4);
  EXPECT_EQ(recording_format_of("a/b.CSV"), RecordingFormat::csv);
  EXPECT_EQ(recording_format_of("a/b.h5"), RecordingFormat::hdf5);
  EXPECT_EQ(recording_format_of("a/b.HDF5"), RecordingFormat::hdf5);
  EXPECT_EQ(recording_format_of("a/b.npz"), RecordingFormat::npz);
  EXPECT_EQ(recording_format_of("a/b.txt"), RecordingFormat::csv);
  EXPECT_THROW(recording_format_of("a/b.mat"), Error);
  EXPECT_THROW(recording_format_of("a/b"), Error);
}

TEST(Convert, KeepsEveryElementFromAnyCompressionToAnyOther) {
  const test::TemporaryFolder folder;
  for (const char* name : {"dv-none", "dv-lz4", "dv-lz4-high", "dv-zstd", "dv-zstd-high"}) {
    const fs::path in = vendor_files / (std::string(name) + ".aedat4");
    const test::RecordingContents expected = test::contents_of(in);
    for (const events::Compression compression :
         {events::Compression::none, events::Compression::lz4, events::Compression::lz4_high, events::Compression::zstd,
          events::Compression::zstd_high}) {
      const fs::path out = folder / (std::string(name) + "-" + std::string(name_of(compression)) + ".aedat4");
      const ConvertSummary summary = convert_recording(in, out, {.compression = compression});
      EXPECT_EQ(events::RecordingReader(out).compression(), compression);
      EXPECT_TRUE(same(test::contents_of(out), expected)) << out;
      EXPECT_EQ(summary.bytes_out, fs::file_size(out));
      EXPECT_EQ(summary.streams.size(), 4U);
      EXPECT_TRUE(events::examine_recording(out).healthy()) << out;
    }
  }
}

TEST(Convert, KeepsTheInputsCompressionByDefault) {
  const test::TemporaryFolder folder;
  convert_recording(vendor_files / "dv-zstd.aedat4", folder / "out.aedat4");
  EXPECT_EQ(events::RecordingReader(folder / "out.aedat4").compression(), events::Compression::zstd);
}

TEST(Convert, CutsEveryStreamAndLeavesTheEnd) {
  const test::TemporaryFolder folder;
  const test::RecordingContents all = test::contents_of(vendor_files / "dv-lz4.aedat4");
  const CameraTime from = all.events.at(1'000).t, to = all.events.at(4'000).t;
  const auto expect_cut = [&](const auto& elements, const auto& kept) {
    std::size_t inside = 0;
    for (const auto& element : elements) inside += element.t >= from && element.t < to ? 1 : 0;
    EXPECT_EQ(kept.size(), inside);
    for (const auto& element : kept) EXPECT_TRUE(element.t >= from && element.t < to);
    return inside;
  };
  const ConvertSummary summary =
      convert_recording(vendor_files / "dv-lz4.aedat4", folder / "out.aedat4", {.from = from, .to = to});
  const test::RecordingContents kept = test::contents_of(folder / "out.aedat4");
  EXPECT_GT(expect_cut(all.events, kept.events), 2'000U);
  EXPECT_GT(expect_cut(all.imu, kept.imu), 0U);
  EXPECT_EQ(expect_cut(all.frames, kept.frames), 0U);
  expect_cut(all.triggers, kept.triggers);
  EXPECT_EQ(summary.streams.at(0).elements, kept.events.size());
  EXPECT_EQ(summary.first, from);  // an event stands there
  EXPECT_LT(*summary.last, to);
  EXPECT_TRUE(
      std::equal(kept.events.begin(), kept.events.end(),
                 std::find_if(all.events.begin(), all.events.end(), [&](const events::Event& e) { return e.t >= from; })));
}

TEST(Convert, LaysCutsEndToEndWithoutLosingAnEvent) {
  const test::TemporaryFolder folder;
  const fs::path in = vendor_files / "dv-zstd.aedat4";
  const test::RecordingContents all = test::contents_of(in);
  const CameraTime middle = all.events.at(3'000).t;
  convert_recording(in, folder / "a.csv", {.to = middle});
  convert_recording(in, folder / "b.csv", {.from = middle});
  convert_recording(in, folder / "all.csv");
  EXPECT_EQ(read_text(folder / "a.csv") + read_text(folder / "b.csv").substr(std::string("t_us,x,y,on\n").size()),
            read_text(folder / "all.csv"));
}

TEST(Convert, RefusesACutWithoutElements) {
  const test::TemporaryFolder folder;
  for (const char* out : {"out.aedat4", "out.csv"}) {
    EXPECT_THROW(convert_recording(vendor_files / "dv-lz4.aedat4", folder / out, {.to = camera_time(5)}), Error);
    EXPECT_THROW(convert_recording(vendor_files / "dv-lz4.aedat4", folder / out, {.from = camera_time(5), .to = camera_time(5)}),
                 Error);
  }
  EXPECT_EQ(files_in(folder.path()), 0U);
}

TEST(Convert, WritesACsvThatPythonFindsTrue) {
  const test::TemporaryFolder folder;
  const nlohmann::json truth = read_json(vendor_files / "truth.json");
  write_whole(
      folder / "sums.py",
      "import csv, hashlib, struct, sys, json\n"
      "n = on = x = y = 0\n"
      "digest = hashlib.sha256()\n"
      "rows = csv.DictReader(open(sys.argv[1], newline=''))\n"
      "for row in rows:\n"
      "    t = int(row['t_us'])\n"
      "    first = t if n == 0 else first\n"
      "    n += 1; on += int(row['on']); x += int(row['x']); y += int(row['y'])\n"
      "    digest.update(struct.pack('<qhhB', t, int(row['x']), int(row['y']), int(row['on'])))\n"
      "print(json.dumps(dict(events=n, on=on, sum_x=x, sum_y=y, first_us=first, last_us=t, digest=digest.hexdigest())))\n");
  for (const auto& [name, expected] : truth.items()) {
    convert_recording(vendor_files / (name + ".aedat4"), folder / (name + ".csv"));
    const test::CommandResult python = test::run_shell("python3 sums.py " + name + ".csv", folder.path());
    ASSERT_EQ(python.exit_code, 0) << python.err;
    const nlohmann::json sums = nlohmann::json::parse(python.out);
    EXPECT_EQ(sums.size(), 7U);
    for (const auto& [key, value] : sums.items()) EXPECT_EQ(value, expected.at(key)) << name << ": " << key;
  }
}

TEST(Convert, GivesTheSameBytesFromCsvThroughAedat4ToCsv) {
  const test::TemporaryFolder folder;
  for (const char* name : {"dv-lz4.aedat4", "dv-events-only.aedat4"}) {
    for (const char* file : {"a.csv", "b.aedat4", "c.csv"}) fs::remove(folder / file);
    convert_recording(vendor_files / name, folder / "a.csv");
    convert_recording(folder / "a.csv", folder / "b.aedat4", {.compression = events::Compression::zstd});
    convert_recording(folder / "b.aedat4", folder / "c.csv");
    EXPECT_EQ(read_text(folder / "a.csv"), read_text(folder / "c.csv")) << name;
    EXPECT_TRUE(events::examine_recording(folder / "b.aedat4").healthy());
  }
}

events::SensorSize size_from(const std::string& csv, const ConvertOptions& options = {}) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in.csv", "t_us,x,y,on\n" + csv);
  const ConvertSummary summary = convert_recording(folder / "in.csv", folder / "out.aedat4", options);
  EXPECT_EQ(summary.size_guessed, !options.size.has_value());
  const events::RecordingReader recording(folder / "out.aedat4");
  EXPECT_EQ(recording.streams().front().size, summary.size);
  return *summary.size;
}

TEST(Convert, TakesTheSmallestUsualSensorThatHoldsTheEventsOfACsv) {
  EXPECT_EQ(size_from("0,319,239,1\n"), (events::SensorSize{320, 240}));
  EXPECT_EQ(size_from("0,320,239,1\n"), (events::SensorSize{346, 260}));
  EXPECT_EQ(size_from("0,0,240,1\n"), (events::SensorSize{346, 260}));
  EXPECT_EQ(size_from("0,346,0,1\n"), (events::SensorSize{640, 480}));
  EXPECT_EQ(size_from("0,1279,700,1\n"), (events::SensorSize{1280, 720}));
  EXPECT_EQ(size_from("0,0,0,1\n5,639,479,1\n"), (events::SensorSize{640, 480}));
  EXPECT_EQ(size_from("0,1280,9,1\n5,3,99,1\n"), (events::SensorSize{1281, 100}));
  EXPECT_EQ(size_from("0,0,0,1\n", {.size = events::SensorSize{1280, 720}}), (events::SensorSize{1280, 720}));
}

TEST(Convert, NamesTheCameraOfACsv) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in.csv", "t_us,x,y,on\n0,0,0,1\n");
  convert_recording(folder / "in.csv", folder / "a.aedat4");
  convert_recording(folder / "in.csv", folder / "b.aedat4", {.source = "DVXplorer_DXA00042"});
  EXPECT_EQ(events::RecordingReader(folder / "a.aedat4").streams().front().source, "csv");
  EXPECT_EQ(events::RecordingReader(folder / "b.aedat4").streams().front().source, "DVXplorer_DXA00042");
}

TEST(Convert, RefusesEventsOutsideTheGivenSensorAndWritesNothing) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in.csv", "t_us,x,y,on\n0,0,0,1\n1,320,0,1\n");
  try {
    convert_recording(folder / "in.csv", folder / "out.aedat4", {.size = events::SensorSize{320, 240}});
    ADD_FAILURE() << "the event lies outside";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("in.csv:3: x is '320'; expected a whole number from 0 to 319"), std::string::npos)
        << e.what();
  }
  EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST(Convert, CannotDeriveTheSizeOfACsvWithoutEvents) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in.csv", "t_us,x,y,on\n");
  EXPECT_THROW(convert_recording(folder / "in.csv", folder / "out.aedat4"), Error);
  EXPECT_EQ(
      convert_recording(folder / "in.csv", folder / "out.aedat4", {.size = events::SensorSize{64, 48}}).streams.at(0).elements,
      0U);
}

TEST(Convert, CutsACsvByTime) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in.csv", "t_us,x,y,on\n0,1,1,1\n10,2,2,0\n20,3,3,1\n30,4,4,1\n");
  convert_recording(folder / "in.csv", folder / "cut.aedat4", {.from = camera_time(10), .to = camera_time(30)});
  convert_recording(folder / "cut.aedat4", folder / "cut.csv");
  EXPECT_EQ(read_text(folder / "cut.csv"), "t_us,x,y,on\n10,2,2,0\n20,3,3,1\n");
}

TEST(Convert, KeepsTheChosenCameraWithItsOtherStreams) {
  const test::TemporaryFolder folder;
  const fs::path two = folder / "two.aedat4";
  test::write_two_cameras(two);
  convert_recording(two, folder / "b.aedat4", {.streams = {"B"}});
  const events::RecordingReader kept(folder / "b.aedat4");
  ASSERT_EQ(kept.streams().size(), 2U);
  EXPECT_EQ(kept.streams()[0].id, 4);
  EXPECT_EQ(kept.streams()[1].id, 6);
  EXPECT_EQ(test::contents_of(folder / "b.aedat4").events.size(), 20U);
  EXPECT_EQ(convert_recording(two, folder / "all.aedat4").streams.size(), 4U);
}

TEST(Convert, KeepsSeveralChosenStreamsApart) {
  const test::TemporaryFolder folder;
  const fs::path two = folder / "two.aedat4";
  test::write_two_cameras(two);
  EXPECT_EQ(convert_recording(two, folder / "both.aedat4", {.streams = {"B", "0"}}).streams.size(), 4U);
  const events::RecordingReader both(folder / "both.aedat4");
  EXPECT_EQ(both.stream(0).size, (events::SensorSize{64, 48}));
  EXPECT_EQ(both.stream(4).size, (events::SensorSize{32, 24}));
  EXPECT_THROW(convert_recording(two, folder / "out.csv", {.streams = {"A", "B"}}), Error);
  EXPECT_THROW(convert_recording(two, folder / "out.npz", {.streams = {"A", "B"}}), Error);
  EXPECT_THROW(convert_recording(two, folder / "out.npz"), Error);
  EXPECT_EQ(convert_recording(two, folder / "out.npz", {.streams = {"B"}}).streams.at(0).elements, 20U);
}

TEST(Convert, CropsEventsAndCountsThemFromTheCorner) {
  const test::TemporaryFolder folder;
  const test::RecordingContents all = test::contents_of(vendor_files / "dv-lz4.aedat4");
  const events::SensorSize size = *events::event_stream(events::RecordingReader(vendor_files / "dv-lz4.aedat4")).size;
  const PixelRegion crop{size.width / 4, size.height / 3, size.width / 2, size.height / 3};
  std::vector<events::Event> expected;
  for (const events::Event& e : all.events) {
    if (e.x < crop.x || e.y < crop.y || e.x >= crop.x + crop.width || e.y >= crop.y + crop.height) continue;
    events::Event moved = e;
    moved.x = static_cast<std::int16_t>(e.x - crop.x);
    moved.y = static_cast<std::int16_t>(e.y - crop.y);
    expected.push_back(moved);
  }
  ASSERT_GT(expected.size(), 100U);
  std::optional<std::string> csv;
  for (const char* out : {"out.aedat4", "out.h5", "out.csv", "out.npz"}) {
    const ConvertSummary summary = convert_recording(vendor_files / "dv-lz4.aedat4", folder / out, {.crop = crop});
    EXPECT_EQ(summary.streams.at(0).elements, expected.size()) << out;
    EXPECT_EQ(summary.cropped_events, all.events.size() - expected.size()) << out;
    EXPECT_EQ(summary.size, (events::SensorSize{crop.width, crop.height}));
  }
  convert_recording(folder / "out.h5", folder / "back.aedat4");
  for (const char* made : {"out.aedat4", "back.aedat4"}) {
    EXPECT_EQ(test::contents_of(folder / made).events, expected);
    EXPECT_EQ(events::event_stream(events::RecordingReader(folder / made)).size, (events::SensorSize{crop.width, crop.height}));
    EXPECT_EQ(test::contents_of(folder / made).imu.size(), all.imu.size());
  }
  convert_recording(folder / "out.aedat4", folder / "again.csv");
  EXPECT_EQ(read_text(folder / "again.csv"), read_text(folder / "out.csv"));
}

TEST(Convert, CropsFramesWhereverTheyLieOnTheSensor) {
  const test::TemporaryFolder folder;
  events::Frame frame;
  frame.format = 16;  // BGR
  frame.width = 4;
  frame.height = 3;
  frame.position_x = 2;
  frame.position_y = 1;
  for (int i = 0; i < 4 * 3 * 3; ++i) frame.pixels.push_back(static_cast<std::uint8_t>(i));
  events::Stream stream = test::stream_of(1, events::StreamType::frames, "FRME");
  stream.size = events::SensorSize{10, 8};
  {
    events::RecordingWriter writer(folder / "in.aedat4", {stream});
    writer.write_frame(1, frame);
    frame.t = camera_time(5);
    frame.position_x = 6;
    writer.write_frame(1, frame);
    writer.close();
  }
  const ConvertSummary summary =
      convert_recording(folder / "in.aedat4", folder / "out.aedat4", {.crop = PixelRegion{3, 2, 2, 4}});
  EXPECT_EQ(summary.cropped_frames, 1U);
  const test::RecordingContents out = test::contents_of(folder / "out.aedat4");
  ASSERT_EQ(out.frames.size(), 1U);
  EXPECT_EQ(out.frames[0].width, 2);
  EXPECT_EQ(out.frames[0].height, 2);
  EXPECT_EQ(out.frames[0].position_x, 0);
  EXPECT_EQ(out.frames[0].position_y, 0);
  EXPECT_EQ(out.frames[0].pixels, (std::vector<std::uint8_t>{15, 16, 17, 18, 19, 20, 27, 28, 29, 30, 31, 32}));
}

TEST(Convert, RefusesACropOutsideTheSensorOrWithoutEvents) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in.csv", "t_us,x,y,on\n0,10,10,1\n10,20,20,0\n");
  const auto crop = [&](const PixelRegion& region) {
    convert_recording(folder / "in.csv", folder / "out.aedat4", {.crop = region, .size = events::SensorSize{64, 48}});
    fs::remove(folder / "out.aedat4");
  };
  EXPECT_NO_THROW(crop({10, 10, 54, 38}));
  EXPECT_THROW(crop({11, 10, 54, 38}), Error);
  EXPECT_THROW(crop({10, 10, 54, 39}), Error);
  EXPECT_THROW(crop({11, 11, 5, 5}), Error);
  EXPECT_THROW(crop({0, 0, 0, 5}), Error);
  EXPECT_THROW(crop({-1, 0, 5, 5}), Error);
  EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST(Convert, NeverMergesTwoCamerasIntoOneCsv) {
  const test::TemporaryFolder folder;
  const fs::path two = folder / "two.aedat4";
  test::write_two_cameras(two);
  EXPECT_THROW(convert_recording(two, folder / "out.csv"), Error);
  const ConvertSummary summary = convert_recording(two, folder / "out.csv", {.streams = {"0"}});
  EXPECT_EQ(summary.streams.at(0).elements, 30U);
  EXPECT_EQ(summary.left_out.size(), 3U);
}

TEST(Convert, RefusesOptionsThatDoNotApply) {
  const test::TemporaryFolder folder;
  const fs::path recording = vendor_files / "dv-lz4.aedat4";
  write_whole(folder / "in.csv", "t_us,x,y,on\n0,0,0,1\n");
  EXPECT_THROW(convert_recording(recording, folder / "out.csv", {.compression = events::Compression::lz4}), Error);
  EXPECT_THROW(convert_recording(recording, folder / "out.aedat4", {.size = events::SensorSize{64, 48}}), Error);
  EXPECT_THROW(convert_recording(recording, folder / "out.aedat4", {.source = "camera"}), Error);
  EXPECT_THROW(convert_recording(folder / "in.csv", folder / "out.aedat4", {.streams = {"0"}}), Error);
  EXPECT_THROW(convert_recording(recording, folder / "out.csv", {.csv = {.columns = "t,x,y,p"}}), Error);
  EXPECT_THROW(convert_recording(recording, folder / "out.csv", {.csv = {.time_unit = events::TimeUnit::s}}), Error);
  EXPECT_THROW(convert_recording(recording, folder / "out.mat"), Error);
  EXPECT_THROW(convert_recording(folder / "none.aedat4", folder / "out.csv"), Error);
}

TEST(Convert, NeverWritesOverItsInputNorUnaskedOverAnother) {
  const test::TemporaryFolder folder;
  fs::copy_file(vendor_files / "dv-lz4.aedat4", folder / "in.aedat4");
  fs::create_hard_link(folder / "in.aedat4", folder / "hard.aedat4");
  const std::string before = read_text(folder / "in.aedat4");
  for (const char* same : {"in.aedat4", "hard.aedat4"})
    EXPECT_THROW(convert_recording(folder / "in.aedat4", folder / same, {.replace = true}), Error);
  EXPECT_EQ(read_text(folder / "in.aedat4"), before);
  for (const char* other : {"other.aedat4", "other.csv"}) {
    write_whole(folder / other, "precious");
    EXPECT_THROW(convert_recording(folder / "in.aedat4", folder / other), Error);
    EXPECT_EQ(read_text(folder / other), "precious");
    convert_recording(folder / "in.aedat4", folder / other, {.replace = true});
    EXPECT_NE(read_text(folder / other), "precious");
  }
}

std::string refusal_of(const fs::path& in, const fs::path& out, const ConvertOptions& options = {}) {
  try {
    convert_recording(in, out, options);
  } catch (const Error& e) {
    return e.what();
  }
  ADD_FAILURE() << in << " was taken";
  return {};
}

TEST(Convert, CutsByTheEventsNotByTheDataTable) {
  const test::TemporaryFolder folder;
  test::write_plain_recording(folder / "in.aedat4", test::steady_events(300, 1'000, 100, {64, 48}), {64, 48});
  std::string bytes = read_text(folder / "in.aedat4");
  const auto text_of = [](std::int64_t number) { return std::string(reinterpret_cast<const char*>(&number), sizeof number); };
  const std::size_t begin_in_table = bytes.rfind(text_of(11'000));  // the second packet's
  ASSERT_GT(begin_in_table, test::packets_of(folder / "in.aedat4").back().payload_offset);
  bytes.replace(begin_in_table, 8, text_of(20'900));
  write_whole(folder / "in.aedat4", bytes);
  const ConvertSummary cut = convert_recording(folder / "in.aedat4", folder / "cut.npz", {.to = camera_time(20'900)});
  EXPECT_EQ(cut.streams.at(0).elements, 199U);
}

TEST(Convert, RequiresASensorSizeOnlyIfTheOutputDoes) {
  const test::TemporaryFolder folder;
  const events::Stream sizeless = test::stream_of(0, events::StreamType::events, "EVTS", "A");
  {
    Hdf5RecordingWriter writer(folder / "in.h5", {&sizeless, 1});
    writer.write_events(0, test::steady_events(30, 0, 100, {64, 48}));
    writer.close();
  }
  EXPECT_NE(refusal_of(folder / "in.h5", folder / "out.aedat4").find("in.h5: has no sensor size"), std::string::npos);
  const ConvertSummary summary = convert_recording(folder / "in.h5", folder / "out.aedat4", {.size = events::SensorSize{64, 48}});
  EXPECT_EQ(summary.streams.at(0).elements, 30U);
}

TEST(Convert, ExportsTimesThatStepBackButMakesNoRecordingOfThem) {
  const test::TemporaryFolder folder;
  test::write_plain_recording(folder / "in.aedat4", test::steady_events(300, 1'000, 100, {64, 48}), {64, 48});
  test::overwrite(folder / "in.aedat4", test::event_offset(test::packets_of(folder / "in.aedat4").front(), 4),
                  std::int64_t{1'000});
  EXPECT_EQ(convert_recording(folder / "in.aedat4", folder / "out.csv").steps_back, 1U);
  for (const char* out : {"out.aedat4", "out.h5"}) {
    const std::string message = refusal_of(folder / "in.aedat4", folder / out);
    EXPECT_TRUE(message.starts_with((folder / "in.aedat4").string() + ": stream 0 goes back in time, from 1300 to 1000 us"))
        << message;
    EXPECT_NE(message.find("CSV and NPZ keep events as they are"), std::string::npos) << message;
    const ConvertSummary cut = convert_recording(folder / "in.aedat4", folder / out, {.from = camera_time(1'301)});
    EXPECT_EQ(cut.streams.at(0).elements, 295U);
    fs::remove(folder / out);
  }
  EXPECT_THROW(convert_recording(folder / "out.csv", folder / "again.aedat4"), Error);
  EXPECT_EQ(files_in(folder.path()), 2U);
}

TEST(Convert, ReportsWhatADamagedInputLost) {
  const test::TemporaryFolder folder;
  test::write_plain_recording(folder / "in.aedat4", test::steady_events(300, 0, 100, {64, 48}), {64, 48});
  fs::resize_file(folder / "in.aedat4", test::packets_of(folder / "in.aedat4").back().payload_offset + 5);
  const ConvertSummary summary = convert_recording(folder / "in.aedat4", folder / "out.csv");
  EXPECT_EQ(summary.streams.at(0).elements, 200U);
  EXPECT_EQ(summary.problems.truncated_bytes, 13U);
}

}  // namespace
}  // namespace tactile::conversion
