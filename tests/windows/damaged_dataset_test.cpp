// HDF5 crashes on damaged files. Each test here reads hundreds of them in its own process, which must survive.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <new>
#include <numeric>

#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/hdf5/read_apart.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"
#include "windows/written_dataset.hpp"

namespace tactile::windows {
namespace {

namespace fs = std::filesystem;

/// What reading did not find in order, and the SHA-256 of what it found.
struct Reading {
  std::vector<std::string> errors;
  std::string sha256;
};

/// Reads as `heatmaps`, `windows --verify`, `train` and `eval` do: tables, every event, every history by its values.
Reading read_everything(const fs::path& file) {
  Reading reading;
  Sha256 digest;
  const auto add = [&](const auto& values) { digest.add(std::as_bytes(std::span(values))); };
  const auto attempt = [&](const std::function<void()>& read) {
    try {
      read();
    } catch (const Error& e) {
      reading.errors.emplace_back(e.what());
    }
  };
  attempt([&] {
    const Dataset dataset(file);
    add(dataset.manifest_hash());
    for (const Sample& sample : dataset.samples()) {
      add(std::array{std::int64_t{sample.run_index}, us_of(sample.t), static_cast<std::int64_t>(sample.touch)});
    }
    for (const DatasetInterval& interval : dataset.intervals())
      add(std::array{std::int64_t{interval.run_index}, us_of(interval.interval.start), us_of(interval.interval.end)});
    for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
      add(dataset.runs()[run].folder);
      attempt([&] {
        for (const events::Event& event : dataset.events(run))
          add(std::array{us_of(event.t), std::int64_t{event.x}, std::int64_t{event.y}, std::int64_t{event.on}});
      });
    }
    std::vector<std::uint32_t> all(dataset.samples().size());
    std::iota(all.begin(), all.end(), 0U);
    if (!dataset.find_heatmaps("th_002")) reading.errors.emplace_back("no history");
    attempt([&] { add(dataset.read_heatmaps("th_002", all)); });
    const std::string wrong = dataset.what_is_wrong_with("th_002");
    if (!wrong.empty()) reading.errors.push_back(wrong);
  });
  reading.sha256 = digest.hex();
  return reading;
}

class DamagedDataset : public testing::Test {
 protected:
  void SetUp() override {
    test::make_run(data(), {.run = "01", .seed = 1, .length_us = 1'000'000});
    test::make_run(data(), {.run = "02", .seed = 2, .length_us = 1'000'000});
    write_dataset(data(), file());
    const Dataset dataset(file());
    HeatmapsWriter heatmaps(dataset, {.name = "th_002", .settings = {{"history_us", 2000}}, .width = 4, .height = 3});
    Random random(5);
    std::vector<std::uint8_t> values(12 * dataset.samples().size());
    for (std::uint8_t& value : values) value = static_cast<std::uint8_t>(random.below(256));
    test::append_to(heatmaps, values);
    heatmaps.commit();
  }

  /// Makes of the dataset's files what tactile wrote before it asked HDF5 for checksums.
  void make_plain() {
    write_whole(folder / "plain.py", R"(import h5py, os
def copy(source, target):
    for name, value in source.attrs.items(): target.attrs[name] = value
    for name in source:
        link = source.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink): target[name] = link
        elif isinstance(source[name], h5py.Group): copy(source[name], target.create_group(name))
        else:
            d = source[name]
            made = target.create_dataset(name, data=d[()], dtype=d.dtype, chunks=d.chunks, maxshape=d.maxshape, compression='gzip',
                                         fletcher32=True, shuffle=d.dtype.kind != 'S' and d.dtype.itemsize > 1)
            for key, value in d.attrs.items(): made.attrs[key] = value
for name in ('dataset.h5', 'dataset.events.h5', 'dataset.th_002.h5'):
    with h5py.File(name) as source, h5py.File('plain', 'w') as target: copy(source, target)
    os.replace('plain', name)
)");
    const test::CommandResult made = test::run_shell("/usr/bin/python3 ../plain.py", data());
    ASSERT_EQ(made.exit_code, 0) << made.err;
    ASSERT_EQ(read_everything(file()).errors, std::vector<std::string>{});
  }

  /// Reads the dataset with `patch` at `offset` of one of its files, which is whole again after that.
  Reading with_patch(const std::string& name, std::size_t offset, const std::string& patch) {
    const std::string before = read_text(data() / name).substr(offset, patch.size());
    put(name, offset, patch.substr(0, before.size()));
    Reading reading = read_everything(file());
    put(name, offset, before);
    return reading;
  }

  void put(const std::string& name, std::size_t offset, const std::string& bytes) {
    std::fstream out(data() / name, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp(static_cast<std::streamoff>(offset));
    out << bytes;
  }

  /// Reads with 8 zero bytes at `first` and each `step`-th offset from there on in the first 64 KiB, and with `patches` random
  /// ones of up to 16 bytes.
  /// @return  how many readings found nothing wrong and gave other values than they should
  int damage(const std::string& name, std::size_t first, std::size_t step, int patches) {
    const std::string sound = read_everything(file()).sha256;
    const std::size_t size = fs::file_size(data() / name);
    int wrong = 0, found = 0;
    const auto attempt = [&](std::size_t offset, const std::string& patch) {
      const Reading reading = with_patch(name, offset, patch);
      found += reading.errors.empty() ? 0 : 1;
      wrong += reading.errors.empty() && reading.sha256 != sound ? 1 : 0;
    };
    for (std::size_t offset = first; offset < std::min(size, std::size_t{65536}); offset += step)
      attempt(offset, std::string(8, '\0'));
    Random random(std::hash<std::string>{}(name));
    for (int i = 0; i < patches; ++i) {
      std::string patch(1 + random.below(16), '\0');
      for (char& byte : patch) byte = static_cast<char>(random.below(256));
      attempt(random.below(size), patch);
    }
    EXPECT_GT(found, patches / 4) << name;
    EXPECT_EQ(read_everything(file()).sha256, sound);
    EXPECT_EQ(read_everything(file()).errors, std::vector<std::string>{});
    return wrong;
  }

  fs::path data() const { return folder.path() / "data"; }
  fs::path file() const { return data() / "dataset.h5"; }
  test::TemporaryFolder folder;
};

TEST_F(DamagedDataset, GivesAnErrorOrTheRightValues) { EXPECT_EQ(damage("dataset.h5", 0, 16, 2000), 0); }

TEST_F(DamagedDataset, GivesAnErrorOrTheRightEvents) { EXPECT_EQ(damage("dataset.events.h5", 0, 128, 300), 0); }

TEST_F(DamagedDataset, GivesAnErrorOrTheRightHeatmaps) { EXPECT_EQ(damage("dataset.th_002.h5", 0, 128, 300), 0); }

TEST_F(DamagedDataset, OfAnEarlierVersionNeverCrashes) {
  make_plain();
  damage("dataset.h5", 2, 32, 200);  // the fields of most messages begin 2 bytes after a multiple of 8
  damage("dataset.events.h5", 2, 256, 100);
  damage("dataset.th_002.h5", 2, 256, 100);
}

TEST_F(DamagedDataset, IsNamedByEachCommandWithTheOneThatMakesItAgain) {
  const std::string sentence =
      "data/dataset.h5: damaged, it cannot be read as HDF5; expected a whole file. 'tactile windows data' makes it again";
  constexpr std::size_t signature = 0, version = 8, root_group = 56;
  for (const std::size_t offset : {signature, version, root_group}) {
    write_dataset(data(), file());
    put("dataset.h5", offset, std::string(8, '\0'));
    for (const char* command : {"heatmaps data --th 2", "train data", "eval data"}) {
      const test::CommandResult result = test::run_tactile(command, folder.path());
      EXPECT_EQ(result.exit_code, 1) << command << offset;
      EXPECT_NE(result.err.find(sentence), std::string::npos) << command << offset << result.err;
    }
    const test::CommandResult verified = test::run_tactile("windows data --verify", folder.path());
    EXPECT_EQ(verified.exit_code, 2);
    EXPECT_NE(verified.out.find(sentence), std::string::npos) << verified.out;
    EXPECT_EQ(test::run_tactile("windows data", folder.path()).exit_code, 0);
    EXPECT_TRUE(Dataset(file()).heatmap_names().empty()) << offset;
  }
}

TEST_F(DamagedDataset, OfAnEarlierVersionIsNamedToo) {
  make_plain();
  put("dataset.h5", 64, std::string(8, '\x11'));  // where the root group lies
  const test::CommandResult result = test::run_tactile("heatmaps data --th 2", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("'tactile windows data' makes it again"), std::string::npos) << result.err;
}

TEST_F(DamagedDataset, IsReplacedOnlyIfItsFileOfEventsExists) {
  put("dataset.h5", 0, std::string(8, '\0'));
  fs::remove(data() / "dataset.events.h5");
  EXPECT_NE(test::error_of([&] { write_dataset(data(), file()); }).find("exists and is not a dataset of tactile"),
            std::string::npos);
}

/// Where the first chunk of a table begins in its file [B].
std::uint64_t place_of_first_chunk(const fs::path& file, const std::string& name) {
  const hdf5::Session session;
  const hdf5::Id opened = hdf5::open_file(file, false), table = hdf5::open_table(opened, name, name);
  const hsize_t first_row = 0;
  haddr_t place = 0;
  EXPECT_GE(H5Dget_chunk_info_by_coord(table, &first_row, nullptr, &place, nullptr), 0);
  return place;
}

TEST_F(DamagedDataset, NamesTheDamagedFileOfItsFolder) {
  put("dataset.events.h5", 56, std::string(8, '\0'));
  EXPECT_NE(test::error_of([&] { const Dataset dataset(file()); }).find("dataset.events.h5: damaged"), std::string::npos);
  write_dataset(data(), file());
  EXPECT_TRUE(Dataset(file()).heatmap_names().empty());

  const Dataset dataset(file());
  put("dataset.events.h5", place_of_first_chunk(data() / "dataset.events.h5", "events/t_us") + 20, "damage");
  const std::string error = test::error_of([&] {
    for (std::uint32_t run = 0; run < 2; ++run) dataset.events(run);
  });
  EXPECT_NE(error.find("Remove " + (data() / "dataset.events.h5").string() + ", and 'tactile windows "), std::string::npos)
      << error;
}

TEST_F(DamagedDataset, OfADamagedHistoryIsRenderedAgain) {
  put("dataset.th_002.h5", 56, std::string(8, '\0'));
  EXPECT_NE(Dataset(file()).what_is_wrong_with("th_002").find("dataset.th_002.h5: damaged"), std::string::npos);
  EXPECT_FALSE(Dataset(file()).find_heatmaps("th_002"));
  const test::CommandResult result = test::run_tactile("heatmaps data --th 2", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Dataset(file()).what_is_wrong_with("th_002"), "");
}

TEST(ReadApart, PassesOnWhatIsSentAndWhatIsThrown) {
  std::vector<std::string> taken;
  const auto take = [&](std::uint32_t kind, std::uint32_t number, std::span<const std::byte> bytes) {
    taken.push_back(std::to_string(kind) + " " + std::to_string(number) + " " + std::to_string(bytes.size()));
  };
  const std::vector<std::byte> much(1 << 20);
  const auto send_twice = [&](const hdf5::Send& send) {
    send(3, 4, much);
    send(5, 6, {});
  };
  hdf5::read_apart("some.h5", send_twice, take);
  EXPECT_EQ(taken, (std::vector<std::string>{"3 4 1048576", "5 6 0"}));
  EXPECT_EQ(test::error_of([] { hdf5::read_apart("some.h5", [](const hdf5::Send&) { throw Error("a sentence"); }); }),
            "a sentence");
}

TEST(ReadApart, TakesEveryOtherFailureForDamage) {
  const auto error = [](const std::function<void()>& work) {
    return test::error_of([&] { hdf5::read_apart("some.h5", [&](const hdf5::Send&) { work(); }); });
  };
  const std::string damaged = "some.h5: damaged, it cannot be read as HDF5; expected a whole file";
  EXPECT_EQ(error([] { ::raise(SIGSEGV); }), damaged);
  EXPECT_EQ(error([] { std::abort(); }), damaged);
  EXPECT_EQ(error([] { ::_exit(0); }), damaged);
  EXPECT_EQ(error([] { throw std::bad_alloc(); }), damaged);
  rlimit seconds{};
  EXPECT_EQ(error([&] {
              if (::getrlimit(RLIMIT_CPU, &seconds) == 0 && seconds.rlim_cur == 20) ::raise(SIGXCPU);
            }),
            damaged);
  rlimit memory{};
  EXPECT_EQ(error([&] {
              if (::getrlimit(RLIMIT_AS, &memory) == 0 && memory.rlim_cur != RLIM_INFINITY) std::abort();
            }),
            damaged);
}

}  // namespace
}  // namespace tactile::windows
