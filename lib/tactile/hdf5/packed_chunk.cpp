#include "tactile/hdf5/packed_chunk.hpp"

#include <zlib.h>

#include <cstddef>

#include "tactile/hdf5/read_apart.hpp"

namespace tactile::hdf5 {
namespace {

constexpr std::size_t checksum_size = 4;  // bytes at the end of a chunk

/// Fletcher's checksum of 32 bits over big-endian words of 16, the last one padded with 0. A sum of 0 that is not of zeros alone
/// is 0xffff. Source: HDF5 File Format Specification 3.0, filter 3.
std::uint32_t fletcher_32(std::span<const std::uint8_t> bytes) {
  constexpr std::uint32_t modulus = 0xffff;
  std::uint32_t sum = 0, sum_of_sums = 0;
  bool all_zero = true;
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    const std::uint32_t word = bytes[i] * 256U + (i + 1 < bytes.size() ? bytes[i + 1] : 0U);
    all_zero = all_zero && word == 0;
    sum = (sum + word) % modulus;
    sum_of_sums = (sum_of_sums + sum) % modulus;
  }
  const auto stored = [&](std::uint32_t value) { return value == 0 && !all_zero ? modulus : value; };
  return stored(sum_of_sums) << 16 | stored(sum);
}

}  // namespace

void check_checksum(std::span<const std::uint8_t> chunk, const std::string& where) {
  std::uint32_t stored = 0;
  for (std::size_t i = 0; i < checksum_size && chunk.size() > checksum_size; ++i)
    stored |= std::uint32_t{chunk[chunk.size() - checksum_size + i]} << (8 * i);
  if (chunk.size() <= checksum_size || fletcher_32(chunk.first(chunk.size() - checksum_size)) != stored)
    throw Damaged(where + ": the checksum of a chunk differs from its bytes; expected a sound HDF5 file");
}

std::vector<std::uint8_t> packed_chunk(std::span<const std::uint8_t> values, std::size_t value_size) {
  std::vector<std::uint8_t> shuffled;  // as HDF5's filter: the first bytes of all values, then the second ones, ...
  if (value_size > 1) {
    const std::size_t count = values.size() / value_size;
    shuffled.resize(values.size());
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t byte = 0; byte < value_size; ++byte) shuffled[byte * count + i] = values[i * value_size + byte];
    }
    values = shuffled;
  }
  uLongf size = compressBound(static_cast<uLong>(values.size()));
  std::vector<std::uint8_t> chunk(size);
  compress2(chunk.data(), &size, values.data(), static_cast<uLong>(values.size()), deflate_level);  // the bound is enough
  chunk.resize(size);
  const std::uint32_t checksum = fletcher_32(chunk);
  for (unsigned shift = 0; shift < 32; shift += 8) chunk.push_back(static_cast<std::uint8_t>(checksum >> shift & 0xff));
  return chunk;
}

std::vector<std::uint8_t> unpacked_chunk(std::span<const std::uint8_t> chunk, std::size_t bytes, const std::string& where,
                                         std::size_t value_size) {
  check_checksum(chunk, where);
  std::vector<std::uint8_t> unpacked(bytes);
  auto size = static_cast<uLongf>(bytes);
  const auto packed_size = static_cast<uLong>(chunk.size() - checksum_size);
  if (uncompress(unpacked.data(), &size, chunk.data(), packed_size) != Z_OK || size != bytes)
    throw Damaged(where + ": a chunk does not hold " + std::to_string(bytes) + " bytes; expected a sound HDF5 file");
  if (value_size == 1) return unpacked;
  std::vector<std::uint8_t> values(bytes);
  const std::size_t count = bytes / value_size;
  for (std::size_t byte = 0; byte < value_size; ++byte) {
    for (std::size_t i = 0; i < count; ++i) values[i * value_size + byte] = unpacked[byte * count + i];
  }
  return values;
}

}  // namespace tactile::hdf5
