#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::hdf5 {
namespace {

using Row = std::vector<std::uint8_t>;

/// The file of a table with these rows, one per chunk.
template <class Append>
std::string file_with(const std::filesystem::path& file, std::size_t row_size, const Append& append) {
  const Session session;
  Id made = create_file(file, Structure::checked);
  Id table = create_table(made, "rows", H5T_STD_U8LE, {row_size}, 1, "rows");
  append(table);
  table.close("rows");
  made.close("rows");
  return read_text(file);
}

/// HDF5, which checks the checksums, reads these rows packed by `packed_chunk`, in a file about as large as its own.
void expect_read_by_hdf5(const std::vector<Row>& rows) {
  const test::TemporaryFolder folder;
  const std::size_t size = rows.front().size();
  const std::string by_hdf5 = file_with(folder / "hdf5.h5", size, [&](hid_t table) {
    for (const Row& row : rows) append_rows(table, H5T_NATIVE_UINT8, row.data(), 1, "rows");
  });
  const std::string packed = file_with(folder / "packed.h5", size, [&](hid_t table) {
    for (const Row& row : rows) append_packed_rows(table, std::array{packed_chunk(row)}, "rows");
  });
  EXPECT_LE(packed.size(), by_hdf5.size() * 103 / 100) << size << " values in a row";
  const Session session;
  const Id file = open_file(folder / "packed.h5", false), table = open_table(file, "rows", "rows");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Row read(size);
    read_rows(table, H5T_NATIVE_UINT8, read.data(), i, 1, "rows");
    EXPECT_EQ(read, rows[i]) << "row " << i << " of " << size;
  }
}

Row random_row(std::size_t size, double share, Random& random) {
  Row row(size);
  for (std::uint8_t& value : row) {
    if (random.below(1000) < static_cast<std::uint64_t>(1000 * share)) value = static_cast<std::uint8_t>(random.below(256));
  }
  return row;
}

TEST(PackedChunk, IsReadByHdf5) {
  Random random(7);
  for (const std::size_t size : {1U, 2U, 3U, 719U, 8'481U, 70'000U}) {
    std::vector<Row> rows{Row(size, 0), Row(size, 255)};
    for (const double share : {0.01, 0.3, 1.0}) rows.push_back(random_row(size, share, random));
    expect_read_by_hdf5(rows);
  }
}

/// Values of 8 bytes, or of 2: most of them close to each other, as times are. HDF5 reads them, and `unpacked_chunk` those that
/// HDF5 has packed.
template <class T>
void expect_column_read_both_ways(std::size_t rows_per_chunk, std::size_t rows) {
  Random random(9);
  std::vector<T> values(rows);
  for (T& value : values) value = static_cast<T>(std::uint64_t{1'700'000'000'000'000} + random.below(1000));
  const test::TemporaryFolder folder;
  const auto make = [&](const std::string& name, const auto& append) {
    const Session session;
    Id made = create_file(folder / name, Structure::checked);
    Id table = create_table(made, "rows", file_type<T>(), {}, rows_per_chunk, "rows");
    append(table);
    table.close("rows");
    made.close("rows");
  };
  const auto bytes_from = [&](std::size_t first) {
    std::vector<std::uint8_t> bytes(rows_per_chunk * sizeof(T));
    std::memcpy(bytes.data(), &values[first], std::min(rows_per_chunk, rows - first) * sizeof(T));
    return bytes;
  };
  make("hdf5.h5", [&](hid_t table) { append_rows(table, memory_type<T>(), values.data(), values.size(), "rows"); });
  make("packed.h5", [&](hid_t table) {
    for (std::size_t first = 0; first < rows; first += rows_per_chunk)
      append_packed_chunk(table, packed_chunk(bytes_from(first), sizeof(T)), std::min(rows_per_chunk, rows - first), "rows");
  });
  const Session session;
  EXPECT_EQ(read_table<T>(open_file(folder / "packed.h5", false), "rows", "rows"), values);
  const Id file = open_file(folder / "hdf5.h5", false), table = open_table(file, "rows", "rows");
  for (std::size_t first = 0; first < rows; first += rows_per_chunk) {
    const Row packed = read_packed_chunk(table, first, "rows");
    EXPECT_EQ(unpacked_chunk(packed, rows_per_chunk * sizeof(T), "rows", sizeof(T)), bytes_from(first)) << first;
  }
}

TEST(PackedChunk, OfLongerValuesIsReadByHdf5AndTheOtherWayRound) {
  expect_column_read_both_ways<std::int64_t>(100, 250);
  expect_column_read_both_ways<std::uint16_t>(64, 64);
  expect_column_read_both_ways<std::uint8_t>(64, 65);
}

TEST(PackedChunk, IsUnpackedToItsValues) {
  Random random(10);
  const Row row = random_row(500, 0.3, random);
  Row chunk = packed_chunk(row);
  EXPECT_EQ(unpacked_chunk(chunk, 500, "row"), row);
  EXPECT_THROW(unpacked_chunk(chunk, 499, "row"), Damaged);
  EXPECT_THROW(unpacked_chunk(chunk, 501, "row"), Damaged);
  EXPECT_THROW(unpacked_chunk(std::span(chunk).first(4), 500, "row"), Damaged);
  chunk[chunk.size() / 2] ^= 1;
  EXPECT_THROW(unpacked_chunk(chunk, 500, "row"), Damaged);
}

TEST(PackedChunk, IsReadBackAndItsDamageIsNoticed) {
  Random random(8);
  const test::TemporaryFolder folder;
  const Row row = random_row(500, 0.3, random);
  file_with(folder / "rows.h5", row.size(), [&](hid_t table) {
    append_packed_rows(table, std::array{packed_chunk(Row(500)), packed_chunk(row)}, "rows");
    EXPECT_EQ(shape_of(table, "rows"), (std::vector<hsize_t>{2, 500}));
  });
  const Session session;
  const Id file = open_file(folder / "rows.h5", false);
  const Id table = open_table(file, "rows", "rows");
  Row read(row.size());
  read_rows(table, H5T_NATIVE_UINT8, read.data(), 1, 1, "rows");
  EXPECT_EQ(read, row);

  Row damaged = packed_chunk(row);
  damaged[damaged.size() / 2] ^= 1;
  file_with(folder / "damaged.h5", row.size(), [&](hid_t made) { append_packed_rows(made, std::array{damaged}, "rows"); });
  EXPECT_THROW(open_file(folder / "damaged.h5", false), Error);
}

}  // namespace
}  // namespace tactile::hdf5
