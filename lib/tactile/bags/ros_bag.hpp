#pragma once

#include <filesystem>
#include <memory>

#include "tactile/bags/bag.hpp"

namespace tactile::bags {

/// Reads the messages of a ROS 1 bag, version 2.0, from front to back. The index at the end of the bag is not used. Therefore a
/// bag that was cut off, or never closed, is read up to its end. Of an incomplete chunk, the part that can be decompressed is
/// read. A record is at most as long as the file, and its header at most 1 MiB.
///
/// Source: the ROS wiki's Bags/Format/2.0.
class RosBagReader : public BagReader {
 public:
  /// @throws Error  if the file cannot be read, is not a bag of this version, or is encrypted
  explicit RosBagReader(const std::filesystem::path& file);
  ~RosBagReader() override;

  std::optional<BagMessage> next() override;
  void rewind() override;
  std::uint64_t bytes_read() const override;
  std::uint64_t file_size() const override;
  const BagProblems& problems() const override;
  std::string_view format() const override { return "ROS 1 bag"; }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::bags
