#include "tactile/hdf5/hdf5_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <string_view>

namespace tactile::hdf5 {
namespace {

constexpr unsigned deflate_level = 4;                            // of small tables, which HDF5 packs itself
constexpr std::uint64_t largest_expansion = 1100;                // deflate expands to at most 1032 times its size
constexpr std::uint64_t free_of_doubt = std::uint64_t{1} << 22;  // the last chunk may be almost empty
constexpr std::size_t longest_text = std::size_t{1} << 16;
constexpr std::uint64_t largest_chunk = std::uint64_t{64} << 20;  // HDF5 keeps one in memory

/// Properties for objects without times, so that the same content gives the same bytes.
Id untimed(hid_t of_class) {
  Id properties(H5Pcreate(of_class), H5Pclose);
  H5Pset_obj_track_times(properties, 0);
  return properties;
}

/// Properties for the structure of a new file.
Id structure_of(Structure structure) {
  Id properties(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (structure == Structure::checked) H5Pset_libver_bounds(properties, H5F_LIBVER_V110, H5F_LIBVER_V110);
  return properties;
}

Id text_type(std::size_t size) {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<std::size_t>(size, 1));
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

/// Texts end at their first zero byte: a fixed-length text is padded with them.
std::string text_at(const char* bytes, std::size_t size) { return {bytes, std::find(bytes, bytes + size, '\0')}; }

template <class T>
void write_plain_attribute(hid_t object, const std::string& name, hid_t type, hid_t in_memory, const T* value,
                           const std::string& where) {
  const Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Id attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (attribute < 0 || H5Awrite(attribute, in_memory, value) < 0)
    fail_writing(where, "attribute '" + name + "' cannot be written");
}

Id open_attribute(hid_t object, const std::string& name, H5T_class_t type_class, const std::string& where) {
  Id attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
  if (attribute < 0) throw Error(where + ": attribute '" + name + "' is missing; expected a file that tactile made");
  const auto checked = [&](Id part) {  // at once: the next call of HDF5 forgets why this one failed
    if (part < 0) fail(where, "attribute '" + name + "' cannot be read");
    return part;
  };
  const Id type = checked({H5Aget_type(attribute), H5Tclose}), space = checked({H5Aget_space(attribute), H5Sclose});
  if (H5Tget_class(type) != type_class || H5Sget_simple_extent_npoints(space) != 1) {
    throw Error(where + ": attribute '" + name + "' is of another type; expected a file that tactile made");
  }
  return attribute;
}

}  // namespace

void Id::close(const std::string& where) {
  if (id_ >= 0 && close_(std::exchange(id_, -1)) < 0) fail_writing(where, "cannot be closed");
}

namespace {

/// HDF5's description of the last error, innermost first.
/// @throws std::bad_alloc  if the reason is a lack of memory
std::string last_error() {
  // An exception must not leave a function that HDF5 calls: HDF5 would keep its lock, and all other threads would wait for ever.
  struct Reason {
    std::array<char, 1024> text{};
    bool lacks_memory = false;
  } reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned index, const H5E_error2_t* error, void* out) -> herr_t {
        auto& into = *static_cast<Reason*>(out);
        if (index > 0) return 0;
        into.lacks_memory = error->maj_num == H5E_RESOURCE && error->min_num == H5E_NOSPACE;
        if (error->desc != nullptr) std::strncpy(into.text.data(), error->desc, into.text.size() - 1);
        return 0;
      },
      &reason);
  const std::string_view text = reason.text.data();
  if (reason.lacks_memory) throw std::bad_alloc();
  return std::string(text.empty() ? "HDF5 gives no reason" : text);
}

/// Names that HDF5 lists one by one.
struct Names {
  std::vector<std::string> names;
  bool lack_memory = false;
};

/// Keeps one name; `Info` describes a link or an attribute. It must not throw, see `last_error`.
template <class Info>
herr_t keep_name(hid_t, const char* name, const Info*, void* out) noexcept {
  auto& into = *static_cast<Names*>(out);
  try {
    into.names.emplace_back(name);
    return 0;
  } catch (...) {
    into.lack_memory = true;
    return -1;
  }
}

}  // namespace

void fail(const std::string& where, const std::string& what) {
  throw Damaged(where + ": " + what + " (" + last_error() + "); expected a sound HDF5 file");
}

void fail_writing(const std::string& where, const std::string& what) {
  const std::string reason = last_error();
  for (const int full : {ENOSPC, EDQUOT, EFBIG}) {
    if (reason.find("errno = " + std::to_string(full) + ',') != std::string::npos)
      throw Error(fmt::format("{}: {} ({}); expected a place with room", where, what, std::strerror(full)));
  }
  throw Error(where + ": " + what + " (" + reason + "); expected a sound HDF5 file in a place with room");
}

Id create_file(const std::filesystem::path& file, Structure structure) {
  const Id properties = untimed(H5P_FILE_CREATE), access = structure_of(structure);
  Id id(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, properties, access), H5Fclose);
  if (id < 0) fail_writing(file.string(), "cannot be made");
  return id;
}

Id open_file(const std::filesystem::path& file, bool for_writing) {
  if (!std::filesystem::exists(file)) throw Error(file.string() + ": no such file; expected an HDF5 file");
  if (!is_apart()) check_readable(file);
  const Id access = structure_of(Structure::checked);
  Id id(H5Fopen(file.c_str(), for_writing ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access), H5Fclose);
  if (id >= 0) return id;
  const std::string reason = last_error();
  if (reason.find("errno = ") == std::string::npos) fail(file.string(), "cannot be opened");
  throw Error(file.string() + ": cannot be opened (" + reason + "); expected a file that no other program writes to");
}

Id create_group(hid_t parent, const std::string& name, const std::string& where) {
  const Id properties = untimed(H5P_GROUP_CREATE);
  Id id(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT), H5Gclose);
  if (id < 0) fail_writing(where, "group '" + name + "' cannot be made");
  return id;
}

Id open_table(hid_t parent, const std::string& name, const std::string& where) {
  Id id(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (id < 0) fail(where, "'" + name + "' cannot be read");
  return id;
}

Id open_group(hid_t parent, const std::string& name, const std::string& where) {
  Id id(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose);
  if (id < 0) fail(where, "group '" + name + "' cannot be opened");
  return id;
}

bool is_group(hid_t parent, const std::string& name) { return Id(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose) >= 0; }

bool has_member(hid_t parent, const std::string& name) { return H5Lexists(parent, name.c_str(), H5P_DEFAULT) > 0; }

std::vector<std::string> members_of(hid_t group) {
  Names found;
  hsize_t index = 0;
  H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &index, keep_name<H5L_info_t>, &found);
  if (found.lack_memory) throw std::bad_alloc();
  return std::move(found.names);
}

std::vector<std::string> attributes_of(hid_t object, const std::string& where) {
  Names found;
  hsize_t index = 0;
  const herr_t result = H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, &index, keep_name<H5A_info_t>, &found);
  if (found.lack_memory) throw std::bad_alloc();
  if (result < 0) fail(where, "its attributes cannot be listed");
  return std::move(found.names);
}

void link_to_file(hid_t parent, const std::string& name, const std::string& file, const std::string& path_there,
                  const std::string& where) {
  if (H5Lcreate_external(file.c_str(), path_there.c_str(), parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0) {
    fail_writing(where, "link '" + name + "' cannot be made");
  }
}

std::string linked_file(hid_t parent, const std::string& name) {
  H5L_info_t info{};
  if (H5Lget_info(parent, name.c_str(), &info, H5P_DEFAULT) < 0 || info.type != H5L_TYPE_EXTERNAL ||
      info.u.val_size > longest_text)
    return {};
  std::vector<char> value(info.u.val_size);
  const char *file = nullptr, *path = nullptr;
  unsigned flags = 0;
  if (H5Lget_val(parent, name.c_str(), value.data(), value.size(), H5P_DEFAULT) < 0) return {};
  if (H5Lunpack_elink_val(value.data(), value.size(), &flags, &file, &path) < 0) return {};
  return file;
}

Id create_table(hid_t parent, const std::string& name, hid_t type, const std::vector<hsize_t>& row_shape, hsize_t rows_per_chunk,
                const std::string& where) {
  std::vector<hsize_t> shape{0}, most{H5S_UNLIMITED}, chunk{rows_per_chunk};
  for (auto* axes : {&shape, &most, &chunk}) axes->insert(axes->end(), row_shape.begin(), row_shape.end());
  const Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), most.data()), H5Sclose);
  const Id properties = untimed(H5P_DATASET_CREATE);
  H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  if (H5Tget_size(type) > 1 && H5Tget_class(type) == H5T_INTEGER) H5Pset_shuffle(properties);
  H5Pset_deflate(properties, deflate_level);
  H5Pset_fletcher32(properties);  // damage of a chunk is detected when it is read
  Id table(H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
  if (table < 0) fail_writing(where, "'" + name + "' cannot be made");
  return table;
}

void append_rows(hid_t table, hid_t in_memory, const void* rows, hsize_t count, const std::string& where) {
  if (count == 0) return;
  std::vector<hsize_t> shape = shape_of(table, where);
  std::vector<hsize_t> first(shape.size(), 0), rows_shape = shape;
  first[0] = shape[0];
  rows_shape[0] = count;
  shape[0] += count;
  if (H5Dset_extent(table, shape.data()) < 0) fail_writing(where, "cannot grow");
  const Id in_file(H5Dget_space(table), H5Sclose);
  const Id given(H5Screate_simple(static_cast<int>(rows_shape.size()), rows_shape.data(), nullptr), H5Sclose);
  if (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, first.data(), nullptr, rows_shape.data(), nullptr) < 0 ||
      H5Dwrite(table, in_memory, given, in_file, H5P_DEFAULT, rows) < 0) {
    fail_writing(where, "cannot be written");
  }
}

void append_packed_rows(hid_t table, std::span<const std::vector<std::uint8_t>> rows, const std::string& where) {
  std::vector<hsize_t> shape = shape_of(table, where), place(shape.size(), 0);
  place[0] = shape[0];
  shape[0] += rows.size();
  if (H5Dset_extent(table, shape.data()) < 0) fail_writing(where, "cannot grow");
  constexpr std::uint32_t all_filters = 0;
  for (const std::vector<std::uint8_t>& row : rows) {
    if (H5Dwrite_chunk(table, H5P_DEFAULT, all_filters, place.data(), row.size(), row.data()) < 0)
      fail_writing(where, "cannot be written");
    ++place[0];
  }
}

void append_packed_chunk(hid_t table, std::span<const std::uint8_t> chunk, hsize_t rows, const std::string& where) {
  std::vector<hsize_t> shape = shape_of(table, where), place(shape.size(), 0);
  place[0] = shape[0];
  shape[0] += rows;
  constexpr std::uint32_t all_filters = 0;
  if (H5Dset_extent(table, shape.data()) < 0) fail_writing(where, "cannot grow");
  if (H5Dwrite_chunk(table, H5P_DEFAULT, all_filters, place.data(), chunk.size(), chunk.data()) < 0)
    fail_writing(where, "cannot be written");
}

std::optional<std::vector<std::uint8_t>> stored_chunk(hid_t table, hsize_t first_row, const std::string& where) {
  std::vector<hsize_t> place(shape_of(table, where).size(), 0);
  place[0] = first_row;
  hsize_t size = 0;
  if (H5Dget_chunk_storage_size(table, place.data(), &size) < 0 || size == 0 || size > largest_chunk) return std::nullopt;
  std::vector<std::uint8_t> chunk(size);
  std::uint32_t left_out_filters = 0;
  if (H5Dread_chunk(table, H5P_DEFAULT, place.data(), &left_out_filters, chunk.data()) < 0) fail(where, "a chunk cannot be read");
  if (left_out_filters != 0) return std::nullopt;
  return chunk;
}

std::vector<std::uint8_t> read_packed_chunk(hid_t table, hsize_t first_row, const std::string& where) {
  std::optional<std::vector<std::uint8_t>> chunk = stored_chunk(table, first_row, where);
  if (!chunk) throw Damaged(where + ": a chunk cannot be read; expected one as tactile writes it");
  check_checksum(*chunk, where);
  return *std::move(chunk);
}

std::vector<hsize_t> shape_of(hid_t table, const std::string& where) {
  const Id space(H5Dget_space(table), H5Sclose);
  const int axes = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
  if (axes < 1) throw Error(where + ": is not a table; expected 1 axis or more");
  std::vector<hsize_t> shape(static_cast<std::size_t>(axes));
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  return shape;
}

void read_rows(hid_t table, hid_t in_memory, void* rows, hsize_t first, hsize_t count, const std::string& where) {
  const Id type(H5Dget_type(table), H5Tclose);
  const H5T_class_t stored = H5Tget_class(type), wanted_class = H5Tget_class(in_memory);
  if (stored != wanted_class && !(stored == H5T_ENUM && wanted_class == H5T_INTEGER))
    throw Error(where + ": has another type; expected a file that tactile made");
  std::vector<hsize_t> shape = shape_of(table, where), begin(shape.size(), 0);
  if (first > shape[0] || count > shape[0] - first) {
    throw Error(where + ": has " + std::to_string(shape[0]) + " rows; expected at least " + std::to_string(first + count));
  }
  if (count == 0) return;
  begin[0] = first;
  shape[0] = count;
  const Id in_file(H5Dget_space(table), H5Sclose);
  const Id wanted(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  if (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, begin.data(), nullptr, shape.data(), nullptr) < 0 ||
      H5Dread(table, in_memory, wanted, in_file, H5P_DEFAULT, rows) < 0) {
    fail(where, "cannot be read");
  }
}

hsize_t rows_per_chunk(hid_t table, const std::string& where) {
  const Id properties(H5Dget_create_plist(table), H5Pclose);
  const H5D_layout_t layout = properties < 0 ? H5D_LAYOUT_ERROR : H5Pget_layout(properties);
  if (layout == H5D_LAYOUT_ERROR) fail(where, "its layout cannot be read");
  const bool is_here = layout == H5D_CHUNKED || layout == H5D_CONTIGUOUS || layout == H5D_COMPACT;
  if (!is_here || H5Pget_external_count(properties) > 0)
    throw Error(where + ": its values lie in other files; expected them in this one");
  if (layout != H5D_CHUNKED) return 0;
  std::vector<hsize_t> chunk(shape_of(table, where).size());
  if (H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data()) < 0) fail(where, "its chunks cannot be read");
  const Id type(H5Dget_type(table), H5Tclose);
  std::uint64_t size = H5Tget_size(type);
  for (const hsize_t along : chunk) {
    if (__builtin_mul_overflow(size, along, &size)) size = largest_chunk + 1;
    if (size > largest_chunk) throw Error(where + ": has chunks of more than 64 MiB; expected smaller ones");
  }
  return chunk[0];
}

void check_filters(hid_t table, const std::string& where) {
  const Id properties(H5Dget_create_plist(table), H5Pclose);
  const int filters = properties < 0 ? 0 : H5Pget_nfilters(properties);
  for (int i = 0; i < filters; ++i) {
    std::array<char, 64> text{};
    unsigned flags = 0, config = 0;
    std::size_t parameters = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &parameters, nullptr, text.size(), text.data(), &config);
    if (filter < 0 || H5Zfilter_avail(filter) > 0) continue;
    const std::string name = text_at(text.data(), text.size());
    const std::string number = "HDF5 filter " + std::to_string(filter);
    throw Error(fmt::format("{}: compressed with {}, which this program does not have; expected gzip or none", where,
                            name.empty() ? number : fmt::format("{} ({})", name, number)));
  }
}

void check_stored_size(hid_t table, const std::string& where) {
  const Id type(H5Dget_type(table), H5Tclose);
  std::uint64_t size = H5Tget_size(type);
  const std::uint64_t limit = free_of_doubt + largest_expansion * H5Dget_storage_size(table);
  for (const hsize_t along : shape_of(table, where)) {
    if (__builtin_mul_overflow(size, along, &size)) size = limit + 1;
    if (size > limit) throw Damaged(where + ": claims more values than its file can contain; expected a sound file");
  }
}

void write_table(hid_t parent, const std::string& name, const std::vector<std::string>& values, const std::string& where) {
  std::size_t longest = 1;
  for (const std::string& value : values) longest = std::max(longest, value.size());
  std::string bytes(longest * values.size(), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) values[i].copy(&bytes[i * longest], longest);
  const Id type = text_type(longest);
  const Id table = create_table(parent, name, type, {}, 256, where);
  append_rows(table, type, bytes.data(), values.size(), where);
}

std::vector<std::string> read_texts(hid_t parent, const std::string& name, const std::string& where) {
  const Id table = open_table(parent, name, where);
  const std::string what = where + ": '" + name + "'";
  const Id type(H5Dget_type(table), H5Tclose);
  const std::size_t size = H5Tget_size(type);
  const std::vector<hsize_t> shape = shape_of(table, what);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0 || shape.size() != 1 || size > longest_text) {
    throw Error(what + " is of another type; expected a column of fixed-length texts");
  }
  check_stored_size(table, what);
  std::string bytes(size * shape[0], '\0');
  read_rows(table, type, bytes.data(), 0, shape[0], what);
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < shape[0]; ++i) texts.push_back(text_at(&bytes[i * size], size));
  return texts;
}

void write_attribute(hid_t object, const std::string& name, std::int64_t value, const std::string& where) {
  write_plain_attribute(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value, where);
}

void write_attribute(hid_t object, const std::string& name, double value, const std::string& where) {
  write_plain_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value, where);
}

void write_attribute(hid_t object, const std::string& name, const std::string& value, const std::string& where) {
  const Id type = text_type(value.size());
  const std::string bytes = value.empty() ? std::string(1, '\0') : value;
  write_plain_attribute(object, name, type, type, bytes.data(), where);
}

bool has_attribute(hid_t object, const std::string& name) { return H5Aexists(object, name.c_str()) > 0; }

std::int64_t read_number(hid_t object, const std::string& name, const std::string& where) {
  const Id attribute = open_attribute(object, name, H5T_INTEGER, where);
  std::int64_t value = 0;
  if (H5Aread(attribute, H5T_NATIVE_INT64, &value) < 0) fail(where, "attribute '" + name + "' cannot be read");
  return value;
}

std::string read_text_attribute(hid_t object, const std::string& name, const std::string& where) {
  const Id attribute = open_attribute(object, name, H5T_STRING, where);
  const Id type(H5Aget_type(attribute), H5Tclose);
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    if (H5Aread(attribute, type, &text) < 0) fail(where, "attribute '" + name + "' cannot be read");
    std::string copy = text == nullptr ? "" : text;
    H5free_memory(text);
    return copy;
  }
  const std::size_t size = H5Tget_size(type);
  if (size > longest_text) throw Error(where + ": attribute '" + name + "' is too long; expected at most 65536 bytes");
  std::string bytes(size, '\0');
  if (H5Aread(attribute, type, bytes.data()) < 0) fail(where, "attribute '" + name + "' cannot be read");
  return text_at(bytes.data(), size);
}

}  // namespace tactile::hdf5
