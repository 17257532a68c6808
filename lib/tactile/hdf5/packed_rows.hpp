#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::hdf5 {

/// Consecutive rows of a table of one axis, as the file stores them. They are read within a Session, and unpacked outside of it,
/// by several threads at the same time: HDF5 itself unpacks one chunk after the other.
class PackedRows {
 public:
  /// Reads `count` rows from `first` on. A table that is stored in another way than `create_table` does is unpacked here.
  /// @throws Error  as `read_rows`
  template <class T>
  static PackedRows of(hid_t table, hsize_t first, hsize_t count, const std::string& where) {
    return {table, {file_type<T>(), memory_type<T>(), sizeof(T)}, first, count, where};
  }

  /// @param T  as in `of`  @throws Damaged  if the checksum of a chunk differs, or it holds another number of rows
  template <class T>
  std::vector<T> unpacked() const {
    std::vector<T> rows(count_);
    unpack(reinterpret_cast<std::uint8_t*>(rows.data()));
    return rows;
  }

 private:
  struct Type {
    hid_t in_file, in_memory;
    std::size_t size;
  };
  PackedRows(hid_t table, const Type& type, hsize_t first, hsize_t count, const std::string& where);
  bool read_chunks(hid_t table);
  void unpack(std::uint8_t* rows) const;

  std::string where_;
  std::size_t row_size_;
  hsize_t first_, count_;
  hsize_t rows_per_chunk_ = 0;                     ///< 0 if the rows are unpacked
  std::vector<std::vector<std::uint8_t>> chunks_;  ///< those that hold the rows; or all rows, unpacked, as one
};

}  // namespace tactile::hdf5
