#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tactile::test {

/// One change of a file or a folder by a program.
struct JournalEntry {
  enum class Kind : std::uint8_t { write, resize, names, sync_begins, sync_ends };
  Kind kind = Kind::write;
  std::size_t node = 0;                  ///< the file or the folder
  std::uint64_t offset = 0;              ///< write: where; resize: the new size
  std::string bytes{};                   ///< write
  std::size_t sync = 0;                  ///< sync_begins, sync_ends: number of the sync
  std::chrono::duration<double> time{};  ///< since the start
  /// names: the names of the folder that change, and their new nodes; nothing for a name that is removed.
  std::vector<std::pair<std::string, std::optional<std::size_t>>> names{};
};

/// A file or a folder as it was before all entries. Node 0 is the watched folder.
struct JournalNode {
  bool is_folder = false;
  std::string content;                       ///< of a file
  std::map<std::string, std::size_t> names;  ///< of a folder: the nodes in it
};

/// All changes that a program made in a folder, in order. At the end of a sync, everything that was written before its start is
/// on the disk.
struct WrittenJournal {
  std::vector<JournalNode> nodes;
  std::vector<JournalEntry> entries;
  std::set<std::string> unseen;  ///< kinds of changes that happened and leave no entry; expected empty
  int exit_code = -1;
};

}  // namespace tactile::test
