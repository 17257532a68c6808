#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "tactile/events/file_descriptor.hpp"

namespace tactile::bags {

using Bytes = std::span<const std::byte>;

inline constexpr std::size_t most_topics = 4096;  ///< of a bag
inline constexpr std::size_t most_name = 4096;    ///< characters of a topic or type

/// A bag's file, open for reading.
class BagFile {
 public:
  /// @throws Error  if it cannot be opened
  explicit BagFile(const std::filesystem::path& path);

  const std::string& name() const { return name_; }  ///< for errors
  std::uint64_t size() const { return size_; }
  /// Reads up to the end of the file. @throws Error  if that fails
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  std::string name_;
  events::FileDescriptor file_;
  std::uint64_t size_ = 0;
};

}  // namespace tactile::bags
