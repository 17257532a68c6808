#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/hdf5/packed_chunk.hpp"
#include "tactile/hdf5/read_apart.hpp"
#include "tactile/hdf5/session.hpp"

// HDF5 with identifiers that close themselves, and errors as `Error`. Include this header only in sources.
namespace tactile::hdf5 {

/// An identifier, closed by its destructor.
class Id {
 public:
  using Close = herr_t (*)(hid_t);
  Id() = default;
  Id(hid_t id, Close closed_by) : id_(id), close_(closed_by) {}
  ~Id() { reset(); }
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Id& operator=(Id&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = std::exchange(other.id_, -1);
      close_ = other.close_;
    }
    return *this;
  }

  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): passed to HDF5's functions
  void close(const std::string& where);   ///< @throws Error if the data was not written to the file

 private:
  void reset() {
    if (id_ >= 0) close_(id_);
    id_ = -1;
  }
  hid_t id_ = -1;
  Close close_ = nullptr;
};

// These two name the reason that HDF5 gives last; std::bad_alloc is thrown if it lacks memory.
[[noreturn]] void fail(const std::string& where, const std::string& what);          ///< @throws Damaged
[[noreturn]] void fail_writing(const std::string& where, const std::string& what);  ///< @throws Error; names a full disk

enum class Structure {
  plain,    ///< readable by all versions of HDF5
  checked,  ///< with checksums that show damage; readable by HDF5 1.10 and later
};

Id create_file(const std::filesystem::path& file, Structure structure);  ///< replaces an existing file
/// @throws Error    if it is missing or cannot be opened
/// @throws Damaged  if `check_readable` finds damage
Id open_file(const std::filesystem::path& file, bool for_writing);
Id create_group(hid_t parent, const std::string& name, const std::string& where);
Id open_table(hid_t parent, const std::string& name, const std::string& where);
bool has_member(hid_t parent, const std::string& name);
std::vector<std::string> members_of(hid_t group);                                ///< the names of its links, in ascending order
std::vector<std::string> attributes_of(hid_t object, const std::string& where);  ///< their names. @throws Damaged
void link_to_file(hid_t parent, const std::string& name, const std::string& file, const std::string& path_there,
                  const std::string& where);

/// Opens a group. @throws Error if there is no such group
Id open_group(hid_t parent, const std::string& name, const std::string& where);
bool is_group(hid_t parent, const std::string& name);
std::string linked_file(hid_t parent, const std::string& name);  ///< the target of an external link; empty for other members

/// The type of T in a file, little-endian and of T's width, and in memory.
template <class T>
hid_t file_type() {
  static_assert(std::is_arithmetic_v<T>);
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_STD_U8LE;
  if constexpr (std::is_same_v<T, std::uint16_t>) return H5T_STD_U16LE;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5T_STD_U32LE;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_STD_U64LE;
  if constexpr (std::is_same_v<T, std::int8_t>) return H5T_STD_I8LE;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_STD_I64LE;
  if constexpr (std::is_same_v<T, float>) return H5T_IEEE_F32LE;
}
template <class T>
hid_t memory_type() {
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_NATIVE_UINT8;
  if constexpr (std::is_same_v<T, std::uint16_t>) return H5T_NATIVE_UINT16;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5T_NATIVE_UINT32;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_NATIVE_UINT64;
  if constexpr (std::is_same_v<T, std::int8_t>) return H5T_NATIVE_INT8;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
}

/// A table that grows along its first axis, with compressed chunks that every HDF5 reads.
Id create_table(hid_t parent, const std::string& name, hid_t type, const std::vector<hsize_t>& row_shape, hsize_t rows_per_chunk,
                const std::string& where);
void append_rows(hid_t table, hid_t memory_type, const void* rows, hsize_t count, const std::string& where);

/// Appends rows, each of them a packed chunk, to a table with one row per chunk.
void append_packed_rows(hid_t table, std::span<const std::vector<std::uint8_t>> rows, const std::string& where);
/// Appends a packed chunk to a table of whole chunks. @param rows  those of its rows that exist; all of them unless it is the
/// last
void append_packed_chunk(hid_t table, std::span<const std::uint8_t> chunk, hsize_t rows, const std::string& where);
/// The chunk that begins with this row, as it is stored; its checksum is not compared. Nothing if it is not stored at all, or
/// without some of the table's filters: HDF5 reads it then. @throws Damaged
std::optional<std::vector<std::uint8_t>> stored_chunk(hid_t table, hsize_t first_row, const std::string& where);
/// The same, compared with its checksum. @throws Damaged  if it is missing, or its checksum differs
std::vector<std::uint8_t> read_packed_chunk(hid_t table, hsize_t first_row, const std::string& where);

/// [rows, ...]
std::vector<hsize_t> shape_of(hid_t table, const std::string& where);
/// Reads `count` rows from `first` on. Numbers beyond the range of the memory type are limited to it.
/// @throws Error  also if the table has another kind of values; booleans (of h5py) count as whole numbers
void read_rows(hid_t table, hid_t memory_type, void* rows, hsize_t first, hsize_t count, const std::string& where);
/// The number of rows that HDF5 reads at once: those of a chunk; 0 if the table has no chunks. @throws Error  if the values lie
/// in other files, or a chunk claims more than 64 MiB
hsize_t rows_per_chunk(hid_t table, const std::string& where);
/// @throws Error  that names the filter, if the table needs a filter that this HDF5 lacks
void check_filters(hid_t table, const std::string& where);
/// @throws Damaged  if a table claims more values than its part of the file can expand to
void check_stored_size(hid_t table, const std::string& where);

template <class T>
void write_table(hid_t parent, const std::string& name, const std::vector<T>& values, const std::string& where) {
  const Id table = create_table(parent, name, file_type<T>(), {}, 16384, where);
  append_rows(table, memory_type<T>(), values.data(), values.size(), where);
}
void write_table(hid_t parent, const std::string& name, const std::vector<std::string>& values, const std::string& where);

template <class T>
std::vector<T> read_table(hid_t parent, const std::string& name, const std::string& where) {
  const Id table = open_table(parent, name, where);
  const std::vector<hsize_t> shape = shape_of(table, where + ": /" + name);
  if (shape.size() != 1) throw Error(where + ": '" + name + "' has " + std::to_string(shape.size()) + " axes; expected 1");
  check_stored_size(table, where + ": '" + name + "'");
  std::vector<T> values(shape[0]);
  read_rows(table, memory_type<T>(), values.data(), 0, shape[0], where + ": '" + name + "'");
  return values;
}
std::vector<std::string> read_texts(hid_t parent, const std::string& name, const std::string& where);

void write_attribute(hid_t object, const std::string& name, std::int64_t value, const std::string& where);
void write_attribute(hid_t object, const std::string& name, double value, const std::string& where);
void write_attribute(hid_t object, const std::string& name, const std::string& value, const std::string& where);
bool has_attribute(hid_t object, const std::string& name);
std::int64_t read_number(hid_t object, const std::string& name, const std::string& where);
/// A text of fixed length, or of variable length as h5py writes it.
std::string read_text_attribute(hid_t object, const std::string& name, const std::string& where);

}  // namespace tactile::hdf5
