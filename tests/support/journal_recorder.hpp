#pragma once

#include <linux/fs.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "support/run_command.hpp"
#include "support/traced_calls.hpp"
#include "support/written_journal.hpp"

namespace tactile::test {

/// Writes the journal of a traced program.
class JournalRecorder {
 public:
  explicit JournalRecorder(const std::filesystem::path& root) : root_(std::filesystem::canonical(root)) { add_existing(root_); }

  WrittenJournal journal;

  void begins(const TracedCall& call) {
    if (call.number != SYS_fsync && call.number != SYS_fdatasync) return;
    const auto node = node_of(call, 0);
    if (!node) return;
    syncs_[call.thread] = ++sync_;
    put({.kind = JournalEntry::Kind::sync_begins, .node = *node, .sync = sync_});
  }

  /// Longer than other functions: it has one case for each system call that changes a file or a folder.
  void ends(const TracedCall& call) {
    if (call.result < 0) {
      syncs_.erase(call.thread);
      return;
    }
    switch (call.number) {
#ifdef SYS_open
      case SYS_open:
        opened(call, call.arguments[1]);
        break;
      case SYS_creat:
        opened(call, O_CREAT | O_TRUNC);
        break;
      case SYS_mkdir:
        made_folder(call, AT_FDCWD, 0);
        break;
      case SYS_rename:
        renamed(call, AT_FDCWD, 0, AT_FDCWD, 1, 0);
        break;
      case SYS_link:
        linked(call, AT_FDCWD, 0, AT_FDCWD, 1);
        break;
      case SYS_unlink:
      case SYS_rmdir:
        removed(call, AT_FDCWD, 0);
        break;
#endif
      case SYS_openat:
        opened(call, call.arguments[2]);
        break;
      case SYS_mkdirat:
        made_folder(call, folder_in(call, 0), 1);
        break;
#ifdef SYS_renameat
      case SYS_renameat:
        renamed(call, folder_in(call, 0), 1, folder_in(call, 2), 3, 0);
        break;
#endif
      case SYS_renameat2:
        renamed(call, folder_in(call, 0), 1, folder_in(call, 2), 3, call.arguments[4]);
        break;
      case SYS_linkat:
        linked(call, folder_in(call, 0), 1, folder_in(call, 2), 3);
        break;
      case SYS_unlinkat:
        removed(call, folder_in(call, 0), 1);
        break;
      case SYS_write:
      case SYS_writev:
        wrote(call, 0, position_after(call, 0) - static_cast<std::uint64_t>(call.result));
        break;
      case SYS_pwrite64:
      case SYS_pwritev:
      case SYS_pwritev2:
        wrote(call, 0, call.arguments[3]);
        break;
      case SYS_sendfile:
        wrote(call, 0, position_after(call, 0) - static_cast<std::uint64_t>(call.result));
        break;
      case SYS_copy_file_range:
        wrote_anywhere(call, 2);
        break;
      case SYS_fallocate:
        wrote_anywhere(call, 0);
        break;
      case SYS_ioctl:
        if (call.arguments[1] == FICLONE || call.arguments[1] == FICLONERANGE) wrote_anywhere(call, 0);
        break;
      case SYS_ftruncate:
        if (const auto node = node_of(call, 0))
          put({.kind = JournalEntry::Kind::resize, .node = *node, .offset = call.arguments[1]});
        break;
      case SYS_truncate:
        if (const auto place = place_named(call, AT_FDCWD, 0); place && node_at(*place))
          put({.kind = JournalEntry::Kind::resize, .node = *node_at(*place), .offset = call.arguments[1]});
        break;
      case SYS_mmap:
        if ((call.arguments[2] & PROT_WRITE) != 0 && (call.arguments[3] & MAP_SHARED) != 0 &&
            (call.arguments[3] & MAP_ANONYMOUS) == 0 && node_of(call, 4))
          journal.unseen.insert("a file mapped for writing");
        break;
      case SYS_symlinkat:
        journal.unseen.insert("a symbolic link");
        break;
      case SYS_fsync:
      case SYS_fdatasync:
        if (const auto sync = syncs_.find(call.thread); sync != syncs_.end()) {
          if (const auto node = node_of(call, 0))
            put({.kind = JournalEntry::Kind::sync_ends, .node = *node, .sync = sync->second});
          syncs_.erase(sync);
        }
        break;
      default:
        break;
    }
  }

 private:
  using Place = std::pair<std::size_t, std::string>;  ///< a folder, and a name in it
  using FileId = std::pair<dev_t, ino_t>;

  std::size_t add(bool is_folder, const FileId& id) {
    journal.nodes.push_back({.is_folder = is_folder, .content = {}, .names = {}});
    names_.emplace_back();
    ids_[id] = journal.nodes.size() - 1;
    return journal.nodes.size() - 1;
  }

  /// Adds a file, or a folder with its contents, as it is before the program begins.
  std::size_t add_existing(const std::filesystem::path& path) {
    struct stat status {};
    ::stat(path.c_str(), &status);
    const bool is_folder = S_ISDIR(status.st_mode);
    const std::size_t node = add(is_folder, {status.st_dev, status.st_ino});
    if (!is_folder) {
      journal.nodes[node].content = text_in_file(path);
      return node;
    }
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      if (entry.is_symlink()) continue;
      const std::size_t child = add_existing(entry.path());
      journal.nodes[node].names[entry.path().filename().string()] = child;
    }
    names_[node] = journal.nodes[node].names;
    return node;
  }

  void put(JournalEntry entry) {
    entry.time = std::chrono::steady_clock::now() - begin_;
    journal.entries.push_back(std::move(entry));
  }

  void name(std::vector<std::pair<Place, std::optional<std::size_t>>> changes) {
    std::map<std::size_t, JournalEntry> of_folders;
    std::vector<std::size_t> order;
    for (auto& [place, node] : changes) {
      auto& names = names_[place.first];
      node ? static_cast<void>(names[place.second] = *node) : static_cast<void>(names.erase(place.second));
      if (!of_folders.contains(place.first)) order.push_back(place.first);
      JournalEntry& entry = of_folders[place.first];
      entry.kind = JournalEntry::Kind::names;
      entry.node = place.first;
      entry.names.emplace_back(place.second, node);
    }
    for (const std::size_t folder : order) put(std::move(of_folders[folder]));
  }

  static std::string link_of(const TracedCall& call, std::uint64_t number) {
    return "/proc/" + std::to_string(call.thread) + "/fd/" + std::to_string(static_cast<int>(number));
  }
  static std::optional<FileId> id_of(const std::string& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return std::nullopt;
    return FileId{status.st_dev, status.st_ino};
  }
  std::optional<std::size_t> node_with(const std::optional<FileId>& id) const {
    const auto found = id ? ids_.find(*id) : ids_.end();
    return found == ids_.end() ? std::nullopt : std::optional(found->second);
  }
  std::optional<std::size_t> node_of(const TracedCall& call, std::size_t argument) const {
    const auto number = static_cast<int>(call.arguments[argument]);
    return number < 0 ? std::nullopt : node_with(id_of(link_of(call, call.arguments[argument])));
  }

  static int folder_in(const TracedCall& call, std::size_t argument) { return static_cast<int>(call.arguments[argument]); }

  /// The watched folder that is the parent of a path, and the last part of the path.
  std::optional<Place> place_of(const std::filesystem::path& path) const {
    std::error_code none;
    const std::filesystem::path parent = std::filesystem::canonical(path.parent_path(), none);
    if (none) return std::nullopt;
    const auto folder = node_with(id_of(parent.string()));
    return folder ? std::optional(Place{*folder, path.filename().string()}) : std::nullopt;
  }
  /// A path in an argument of a call, relative to the open folder `folder` or to the working folder.
  static std::filesystem::path path_in(const TracedCall& call, int folder, std::size_t argument) {
    const std::string base =
        folder == AT_FDCWD ? "/proc/" + std::to_string(call.thread) + "/cwd" : link_of(call, static_cast<std::uint64_t>(folder));
    return std::filesystem::path(base) / text_of_process(call.thread, call.arguments[argument]);
  }
  std::optional<Place> place_named(const TracedCall& call, int folder, std::size_t argument) const {
    const std::filesystem::path path = path_in(call, folder, argument);
    return place_of(path.has_filename() ? path : path.parent_path());  // "folder/" has none
  }
  std::optional<std::size_t> node_at(const Place& place) const {
    const auto found = names_[place.first].find(place.second);
    return found == names_[place.first].end() ? std::nullopt : std::optional(found->second);
  }

  void opened(const TracedCall& call, std::uint64_t flags) {
    if ((flags & (O_CREAT | O_TRUNC)) == 0 || (flags & O_TMPFILE) == O_TMPFILE) return;
    std::error_code none;
    const std::string link = link_of(call, static_cast<std::uint64_t>(call.result));
    const auto place = place_of(std::filesystem::read_symlink(link, none));
    const auto id = id_of(link);
    if (none || !place || !id) return;
    const auto there = node_at(*place);
    if (!there) {
      name({{*place, add(false, *id)}});
    } else if ((flags & O_TRUNC) != 0) {
      put({.kind = JournalEntry::Kind::resize, .node = *there, .offset = 0});
    }
  }

  void made_folder(const TracedCall& call, int folder, std::size_t argument) {
    const auto place = place_named(call, folder, argument);
    if (!place) return;
    if (const auto id = id_of(path_in(call, folder, argument).string())) name({{*place, add(true, *id)}});
  }

  void renamed(const TracedCall& call, int from_folder, std::size_t from, int to_folder, std::size_t to, std::uint64_t flags) {
    const auto old_place = place_named(call, from_folder, from), new_place = place_named(call, to_folder, to);
    const auto moved = old_place ? node_at(*old_place) : std::nullopt, other = new_place ? node_at(*new_place) : std::nullopt;
    if (!moved || !new_place) {
      if (old_place || new_place) journal.unseen.insert("a rename into or out of the folder");
      return;
    }
    name({{*new_place, moved}, {*old_place, (flags & RENAME_EXCHANGE) != 0 ? other : std::nullopt}});
  }

  void linked(const TracedCall& call, int from_folder, std::size_t from, int to_folder, std::size_t to) {
    const auto old_place = place_named(call, from_folder, from), new_place = place_named(call, to_folder, to);
    if (old_place && new_place && node_at(*old_place)) name({{*new_place, node_at(*old_place)}});
  }

  void removed(const TracedCall& call, int folder, std::size_t argument) {
    const auto place = place_named(call, folder, argument);
    if (place && node_at(*place)) name({{*place, std::nullopt}});
  }

  /// The position of an open file after a call.
  static std::uint64_t position_after(const TracedCall& call, std::size_t argument) {
    std::ifstream info("/proc/" + std::to_string(call.thread) + "/fdinfo/" +
                       std::to_string(static_cast<int>(call.arguments[argument])));
    std::string key;
    std::uint64_t position = 0;
    info >> key >> position;
    return position;
  }

  static std::string bytes_at(const std::string& link, std::uint64_t offset, std::size_t size) {
    std::string bytes(size, '\0');
    const int file = ::open(link.c_str(), O_RDONLY | O_CLOEXEC);
    const ssize_t got = file < 0 ? -1 : ::pread(file, bytes.data(), size, static_cast<off_t>(offset));
    if (file >= 0) ::close(file);
    bytes.resize(got < 0 ? 0 : static_cast<std::size_t>(got));
    return bytes;
  }

  void wrote(const TracedCall& call, std::size_t argument, std::uint64_t offset) {
    const auto node = node_of(call, argument);
    if (!node || call.result == 0) return;
    const std::string link = link_of(call, call.arguments[argument]);
    put({.kind = JournalEntry::Kind::write,
         .node = *node,
         .offset = offset,
         .bytes = bytes_at(link, offset, static_cast<std::size_t>(call.result))});
  }

  /// For calls whose position is not recorded: the whole file counts as written.
  void wrote_anywhere(const TracedCall& call, std::size_t argument) {
    const auto node = node_of(call, argument);
    if (!node) return;
    const std::string link = link_of(call, call.arguments[argument]);
    struct stat status {};
    if (::stat(link.c_str(), &status) != 0) return;
    const auto size = static_cast<std::uint64_t>(status.st_size);
    put({.kind = JournalEntry::Kind::write, .node = *node, .bytes = bytes_at(link, 0, size)});
    put({.kind = JournalEntry::Kind::resize, .node = *node, .offset = size});
  }

  std::filesystem::path root_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::vector<std::map<std::string, std::size_t>> names_;  ///< of each folder, after the latest entry
  std::map<FileId, std::size_t> ids_;
  std::map<pid_t, std::size_t> syncs_;  ///< in progress, by thread
  std::size_t sync_ = 0;
};

/// Runs a program in the folder `in` and returns the journal of its changes there; nothing if this machine allows no tracing.
inline std::optional<WrittenJournal> journal_of(const std::vector<std::string>& words, const std::filesystem::path& in) {
  JournalRecorder recorder(in);
  const auto begins = [&](const TracedCall& call) {
    recorder.begins(call);
    return true;
  };
  const std::optional<int> exit_code = trace_calls(words, in, begins, [&](const TracedCall& call) { recorder.ends(call); });
  if (!exit_code) return std::nullopt;
  recorder.journal.exit_code = *exit_code;
  return std::move(recorder.journal);
}

}  // namespace tactile::test
