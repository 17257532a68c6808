#include "tactile/hdf5/packed_chunk.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "tactile/hdf5/read_apart.hpp"

namespace tactile::hdf5 {
namespace {

constexpr std::size_t checksum_size = 4;  // bytes at the end of a chunk
/// Of libdeflate. Chunks of our data sets are 0.5 % smaller than by zlib's level 4, in half the time.
constexpr int packing_level = 2;

struct FreeCompressor {
  void operator()(libdeflate_compressor* compressor) const { libdeflate_free_compressor(compressor); }
};
struct FreeDecompressor {
  void operator()(libdeflate_decompressor* decompressor) const { libdeflate_free_decompressor(decompressor); }
};

// One for each chunk: where memory lacks, glibc ends the program if a thread keeps an object that must be destroyed with it.

/// @throws std::bad_alloc
std::unique_ptr<libdeflate_compressor, FreeCompressor> new_compressor() {
  std::unique_ptr<libdeflate_compressor, FreeCompressor> made(libdeflate_alloc_compressor(packing_level));
  if (!made) throw std::bad_alloc();
  return made;
}

/// @throws std::bad_alloc
std::unique_ptr<libdeflate_decompressor, FreeDecompressor> new_decompressor() {
  std::unique_ptr<libdeflate_decompressor, FreeDecompressor> made(libdeflate_alloc_decompressor());
  if (!made) throw std::bad_alloc();
  return made;
}

/// Fletcher's checksum of 32 bits over big-endian words of 16, the last one padded with 0. A sum of 0 that is not of zeros alone
/// is 0xffff. Source: HDF5 File Format Specification 3.0, filter 3.
std::uint32_t fletcher_32(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t block = std::size_t{2} * 360;  // after so many bytes the second sum is still below 2^32
  std::uint32_t sum = 0, sum_of_sums = 0;
  const auto fold = [](std::uint32_t value) { return (value & 0xffff) + (value >> 16); };  // modulo 0xffff; 0 stays 0 only
  for (std::size_t begin = 0; begin < bytes.size(); begin += block) {
    const std::size_t end = std::min(bytes.size(), begin + block);
    for (std::size_t i = begin; i < end; i += 2) {
      sum += bytes[i] * 256U + (i + 1 < end ? bytes[i + 1] : 0U);
      sum_of_sums += sum;
    }
    sum = fold(sum);
    sum_of_sums = fold(sum_of_sums);
  }
  return fold(sum_of_sums) << 16 | fold(sum);
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
  const auto compressor = new_compressor();
  std::vector<std::uint8_t> chunk(libdeflate_zlib_compress_bound(compressor.get(), values.size()));
  chunk.resize(libdeflate_zlib_compress(compressor.get(), values.data(), values.size(), chunk.data(), chunk.size()));
  const std::uint32_t checksum = fletcher_32(chunk);
  for (unsigned shift = 0; shift < 32; shift += 8) chunk.push_back(static_cast<std::uint8_t>(checksum >> shift & 0xff));
  return chunk;
}

std::vector<std::uint8_t> unpacked_chunk(std::span<const std::uint8_t> chunk, std::size_t bytes, const std::string& where,
                                         std::size_t value_size) {
  check_checksum(chunk, where);
  std::vector<std::uint8_t> unpacked(bytes);
  const std::size_t packed_size = chunk.size() - checksum_size;
  // Without a place for the number of bytes, another number than asked for is an error.
  if (libdeflate_zlib_decompress(new_decompressor().get(), chunk.data(), packed_size, unpacked.data(), bytes, nullptr) !=
      LIBDEFLATE_SUCCESS)
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
