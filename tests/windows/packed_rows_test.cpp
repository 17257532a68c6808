#include "tactile/hdf5/packed_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::hdf5 {
namespace {

constexpr hsize_t per_chunk = 100, rows = 350;  // the last chunk is half full

class Rows : public testing::Test {
 protected:
  template <class T>
  static std::vector<T> values() {
    std::vector<T> values(rows);
    for (std::size_t i = 0; i < rows; ++i) values[i] = static_cast<T>(i * 7919);
    return values;
  }

  template <class T>
  void write(const std::string& name) {
    const Session session;
    const Id in = create_file(file_, Structure::plain);
    const Id table = create_table(in, name, file_type<T>(), {}, per_chunk, "t");
    append_rows(table, memory_type<T>(), values<T>().data(), rows, "t");
  }

  template <class T>
  std::vector<T> read(const std::string& name, hsize_t first, hsize_t count) const {
    const PackedRows packed = [&] {
      const Session session;
      const Id in = open_file(file_, false);
      return PackedRows::of<T>(open_table(in, name, "t"), first, count, "t");
    }();
    return packed.unpacked<T>();
  }

  /// @param S  in which they are stored
  template <class T, class S = T>
  void expect_all_parts(const std::string& name) const {
    const std::vector<S> stored = values<S>();
    const std::vector<T> all(stored.begin(), stored.end());
    for (const hsize_t first : {0U, 1U, 99U, 100U, 250U, 349U, 350U}) {
      for (const hsize_t count : {0U, 1U, 50U, 100U, 250U, 350U}) {
        if (first + count > rows) continue;
        const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
        EXPECT_EQ(read<T>(name, first, count), std::vector<T>(begin, begin + static_cast<std::ptrdiff_t>(count)))
            << count << " from " << first;
      }
    }
  }

  /// A table with other properties than `create_table` gives it.
  template <class Set>
  void write_otherwise(const Set& set) {
    const Session session;
    const Id in = create_file(file_, Structure::plain);
    const hsize_t shape = rows;
    const Id space(H5Screate_simple(1, &shape, nullptr), H5Sclose);
    const Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    set(properties);
    const Id table(H5Dcreate2(in, "x", H5T_STD_U16LE, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
    const std::vector<std::uint16_t> all = values<std::uint16_t>();
    ASSERT_GE(H5Dwrite(table, H5T_NATIVE_UINT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), 0);
  }

  test::TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "rows.h5";
};

TEST_F(Rows, OfEveryWidthAreThoseThatWereWritten) {
  write<std::uint8_t>("x");
  expect_all_parts<std::uint8_t>("x");
  write<std::uint16_t>("x");
  expect_all_parts<std::uint16_t>("x");
  write<std::int64_t>("x");
  expect_all_parts<std::int64_t>("x");
}

TEST_F(Rows, OfTablesThatAreStoredOtherwiseToo) {
  const hsize_t chunk = per_chunk;
  write_otherwise([](hid_t) {});  // contiguous
  expect_all_parts<std::uint16_t>("x");
  write_otherwise([&](hid_t properties) { H5Pset_chunk(properties, 1, &chunk); });
  expect_all_parts<std::uint16_t>("x");
  write_otherwise([&](hid_t properties) {
    H5Pset_chunk(properties, 1, &chunk);
    H5Pset_deflate(properties, 1);
    H5Pset_shuffle(properties);
  });
  expect_all_parts<std::uint16_t>("x");
  expect_all_parts<std::int64_t, std::uint16_t>("x");  // of another width than asked for: HDF5 widens
}

TEST_F(Rows, OfChunksThatAreMissingOrNotCompressedToo) {
  const Session session;
  {
    const Id in = create_file(file_, Structure::plain);
    const Id table = create_table(in, "x", H5T_STD_U16LE, {}, per_chunk, "t");
    const hsize_t shape = rows, place = per_chunk;
    ASSERT_GE(H5Dset_extent(table, &shape), 0);
    const std::vector<std::uint16_t> plain(per_chunk, 513);
    constexpr std::uint32_t without_filters = 7;
    ASSERT_GE(H5Dwrite_chunk(table, H5P_DEFAULT, without_filters, &place, 2 * per_chunk, plain.data()), 0);
  }
  std::vector<std::uint16_t> expected(rows, 0);
  std::fill_n(expected.begin() + per_chunk, per_chunk, std::uint16_t{513});
  EXPECT_EQ(read<std::uint16_t>("x", 0, rows), expected);
  EXPECT_EQ(read<std::uint16_t>("x", 150, 20), std::vector<std::uint16_t>(20, 513));
}

TEST_F(Rows, BeyondTheTableAreRefused) {
  write<std::uint16_t>("x");
  EXPECT_THROW(read<std::uint16_t>("x", 300, 51), Error);
  EXPECT_THROW(read<std::uint16_t>("x", 351, 0), Error);
}

TEST_F(Rows, OfADamagedChunkAreRefused) {
  write<std::uint16_t>("x");
  const std::vector<std::uint8_t> second = [&] {
    const Session session;
    return read_packed_chunk(open_table(open_file(file_, false), "x", "t"), per_chunk, "t");
  }();
  std::string bytes = read_text(file_);
  const std::size_t place = bytes.find(std::string(second.begin(), second.end()));
  ASSERT_NE(place, std::string::npos);
  bytes[place + 10] = static_cast<char>(bytes[place + 10] ^ 1);
  const std::filesystem::path damaged = folder_ / "damaged.h5";
  write_whole(damaged, bytes);
  const auto read_damaged = [&](hsize_t first, hsize_t count) {
    const PackedRows packed = [&] {
      const Session session;
      const Id in(H5Fopen(damaged.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
      return PackedRows::of<std::uint16_t>(open_table(in, "x", "t"), first, count, "t");
    }();
    return packed.unpacked<std::uint16_t>();
  };
  EXPECT_EQ(read_damaged(0, per_chunk).size(), per_chunk);
  EXPECT_THROW(read_damaged(0, per_chunk + 1), Damaged);
}

}  // namespace
}  // namespace tactile::hdf5
