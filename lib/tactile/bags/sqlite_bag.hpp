#pragma once

#include <filesystem>
#include <memory>

#include "tactile/bags/bag.hpp"

namespace tactile::bags {

/// Reads the messages of a ROS 2 bag in SQLite (.db3) in the order in which they were written. Transactions in a write-ahead log
/// that a killed recorder left (.db3-wal) are read too. Of a file that was cut off, or has broken pages, the messages in sound
/// pages are read.
///
/// The file is opened for reading only. `topics` and `messages` must be plain tables, because a view or a virtual table can
/// compute without end.
///
/// Source: rosbag2_storage_sqlite3 of ROS 2; SQLite, Database File Format.
class SqliteBagReader : public BagReader {
 public:
  /// @throws Error  if the file cannot be read, or has no such tables
  explicit SqliteBagReader(const std::filesystem::path& file);
  ~SqliteBagReader() override;

  std::optional<BagMessage> next() override;
  void rewind() override;
  std::uint64_t bytes_read() const override;
  std::uint64_t file_size() const override;
  const BagProblems& problems() const override;
  std::string_view format() const override { return "ROS 2 bag (SQLite)"; }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::bags
