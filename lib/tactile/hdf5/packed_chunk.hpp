#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tactile::hdf5 {

/// The bytes of a whole chunk as a table of `create_table` stores it. It needs no Session, so several threads may pack chunks at
/// the same time: HDF5 itself packs one after the other.
/// @param values      little-endian, of all rows of the chunk; rows that do not exist are 0
/// @param value_size  bytes of one value: 1, 2, 4 or 8
std::vector<std::uint8_t> packed_chunk(std::span<const std::uint8_t> values, std::size_t value_size = 1);
/// The inverse. @param bytes  of all values  @throws Damaged  if the checksum differs, or the chunk holds another number of bytes
std::vector<std::uint8_t> unpacked_chunk(std::span<const std::uint8_t> chunk, std::size_t bytes, const std::string& where,
                                         std::size_t value_size = 1);
/// @throws Damaged  if the last bytes of a packed chunk are not the checksum of the others
void check_checksum(std::span<const std::uint8_t> chunk, const std::string& where);

}  // namespace tactile::hdf5
