#include "tactile/hdf5/packed_rows.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tactile::hdf5 {
namespace {

/// Whether a table's values are numbers of this type in chunks that `unpacked_chunk` unpacks.
bool is_packed(hid_t table, hid_t in_file, std::size_t size) {
  const Id type(H5Dget_type(table), H5Tclose);
  const Id properties(H5Dget_create_plist(table), H5Pclose);
  if (type < 0 || properties < 0 || H5Tequal(type, in_file) <= 0 || H5Pget_layout(properties) != H5D_CHUNKED) return false;
  std::vector<H5Z_filter_t> filters, expected{H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE, H5Z_FILTER_FLETCHER32};
  if (size == 1) expected.erase(expected.begin());
  for (int i = 0; i < H5Pget_nfilters(properties); ++i) {
    unsigned flags = 0, config = 0;
    std::size_t parameters = 0;
    filters.push_back(H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &parameters, nullptr, 0, nullptr, &config));
  }
  return filters == expected;
}

}  // namespace

PackedRows::PackedRows(hid_t table, const Type& type, hsize_t first, hsize_t count, const std::string& where)
    : where_(where), row_size_(type.size), first_(first), count_(count) {
  const std::vector<hsize_t> shape = shape_of(table, where);
  const bool holds_them = shape.size() == 1 && first <= shape[0] && count <= shape[0] - first;
  if (holds_them && is_packed(table, type.in_file, type.size) && read_chunks(table)) return;
  rows_per_chunk_ = 0;
  chunks_.assign(1, std::vector<std::uint8_t>(count * row_size_));
  read_rows(table, type.in_memory, chunks_.front().data(), first, count, where);
}

/// @return  whether all are stored with all filters
bool PackedRows::read_chunks(hid_t table) {
  rows_per_chunk_ = rows_per_chunk(table, where_);
  for (hsize_t row = first_ / rows_per_chunk_ * rows_per_chunk_; row < first_ + count_; row += rows_per_chunk_) {
    auto chunk = stored_chunk(table, row, where_);
    if (!chunk) return false;
    chunks_.push_back(*std::move(chunk));
  }
  return true;
}

void PackedRows::unpack(std::uint8_t* rows) const {
  if (rows_per_chunk_ == 0) {
    std::copy(chunks_.front().begin(), chunks_.front().end(), rows);
    return;
  }
  hsize_t begin = first_ % rows_per_chunk_, left = count_;
  for (const std::vector<std::uint8_t>& packed : chunks_) {
    const std::vector<std::uint8_t> chunk = unpacked_chunk(packed, rows_per_chunk_ * row_size_, where_, row_size_);
    const hsize_t taken = std::min(left, rows_per_chunk_ - begin);
    std::memcpy(rows, chunk.data() + begin * row_size_, taken * row_size_);
    rows += taken * row_size_;
    left -= taken;
    begin = 0;
  }
}

}  // namespace tactile::hdf5
