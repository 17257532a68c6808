#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "support/folder_image.hpp"
#include "support/written_journal.hpp"
#include "tactile/core/random.hpp"

namespace tactile::test {

/// The journal without its syncs. A test of power cuts must find damage in it; otherwise it would never find any.
inline WrittenJournal without_syncs(WrittenJournal journal) {
  std::erase_if(journal.entries, [](const JournalEntry& entry) {
    return entry.kind == JournalEntry::Kind::sync_begins || entry.kind == JournalEntry::Kind::sync_ends;
  });
  return journal;
}

/// What is on the disk after a power cut. Everything that was synced is there. Of later writes, each block of 4096 bytes and the
/// size of each file are as they were at some moment since; each folder has some of the later changes of names, the first ones.
class PowerCut {
 public:
  explicit PowerCut(const WrittenJournal& journal) : journal_(journal) {}

  /// The folder after the first `entries` of the journal. `random` draws the changes that were not synced; null: none of them.
  FolderImage after(std::size_t entries, Random* random) const {
    States states = states_after(entries);
    for (std::size_t node = 0; node < states.size(); ++node) {
      journal_.nodes[node].is_folder ? take_names(states[node], random) : take_bytes(states[node], random);
    }
    FolderImage image;
    add(states, 0, "", image);
    return image;
  }

  /// The synced contents of a file after the first `entries`; nothing if it was never synced. `path`: where the file is in the
  /// end.
  std::optional<std::string> synced(const std::string& path, std::size_t entries) const {
    if (syncs_of(path, entries) == 0) return std::nullopt;
    return states_after(entries)[*node_in_the_end(path)].content;
  }

  /// How often a file was synced within the first `entries`.
  std::size_t syncs_of(const std::string& path, std::size_t entries) const {
    const std::optional<std::size_t> node = node_in_the_end(path);
    return static_cast<std::size_t>(std::count_if(
        journal_.entries.begin(), journal_.entries.begin() + static_cast<std::ptrdiff_t>(entries),
        [&](const JournalEntry& entry) { return entry.kind == JournalEntry::Kind::sync_ends && entry.node == node; }));
  }

  /// The folder after all entries, without a power cut.
  FolderImage whole() const { return killed_after(journal_.entries.size()); }

  /// The folder after the first `entries`, if the program is killed then and the machine continues to run.
  FolderImage killed_after(std::size_t entries) const {
    const States states = written_after(entries);
    FolderImage image;
    add(states, 0, "", image);
    return image;
  }

  /// Moments of power cuts, ascending, as numbers of entries. The first is the start, the last is the end, and half of the others
  /// are close to renames and syncs, where most errors happen. @param count  at least 2
  std::vector<std::size_t> moments(std::size_t count, Random& random) const {
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < journal_.entries.size(); ++i) {
      const JournalEntry::Kind kind = journal_.entries[i].kind;
      if (kind != JournalEntry::Kind::write && kind != JournalEntry::Kind::resize) near.push_back(i);
    }
    std::vector<std::size_t> moments;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t any = random.below(journal_.entries.size() + 1);
      moments.push_back(i % 2 == 0 || near.empty()
                            ? any
                            : std::min(near[random.below(near.size())] + random.below(3), journal_.entries.size()));
    }
    moments.front() = 0;
    moments.back() = journal_.entries.size();
    std::sort(moments.begin(), moments.end());
    return moments;
  }

 private:
  struct State {
    std::string content;
    std::map<std::string, std::size_t> names;
    std::vector<const JournalEntry*> pending;  ///< not synced
  };
  using States = std::vector<State>;
  static constexpr std::size_t block = 4096;

  States states_after(std::size_t entries) const {
    States states(journal_.nodes.size());
    for (std::size_t node = 0; node < states.size(); ++node) {
      states[node].content = journal_.nodes[node].content;
      states[node].names = journal_.nodes[node].names;
    }
    std::map<std::size_t, const JournalEntry*> sync_begins;
    for (std::size_t i = 0; i < entries; ++i) {
      const JournalEntry& entry = journal_.entries[i];
      State& state = states[entry.node];
      if (entry.kind == JournalEntry::Kind::sync_begins) {
        sync_begins[entry.sync] = &entry;
      } else if (entry.kind == JournalEntry::Kind::sync_ends) {
        const auto later = std::find_if(state.pending.begin(), state.pending.end(),
                                        [&](const JournalEntry* each) { return each > sync_begins.at(entry.sync); });
        std::for_each(state.pending.begin(), later, [&](const JournalEntry* each) { apply(*each, state); });
        state.pending.erase(state.pending.begin(), later);
      } else {
        state.pending.push_back(&entry);
      }
    }
    return states;
  }

  static void apply(const JournalEntry& entry, State& state) {
    if (entry.kind == JournalEntry::Kind::names) {
      for (const auto& [name, node] : entry.names)
        node ? static_cast<void>(state.names[name] = *node) : static_cast<void>(state.names.erase(name));
    } else if (entry.kind == JournalEntry::Kind::resize) {
      state.content.resize(entry.offset, '\0');
    } else {
      if (state.content.size() < entry.offset + entry.bytes.size()) state.content.resize(entry.offset + entry.bytes.size(), '\0');
      state.content.replace(entry.offset, entry.bytes.size(), entry.bytes);
    }
  }

  static void take_names(State& state, Random* random) {
    if (random == nullptr || state.pending.empty()) return;
    const std::size_t count = random->below(state.pending.size() + 1);
    for (std::size_t i = 0; i < count; ++i) apply(*state.pending[i], state);
  }

  static void take_bytes(State& state, Random* random) {
    if (random == nullptr || state.pending.empty()) return;
    const std::size_t all = state.pending.size(), kind = random->below(4);
    if (kind == 0) return;
    if (kind == 1) {
      for (const JournalEntry* entry : state.pending) apply(*entry, state);
      return;
    }
    // The size after some of the entries, each block after some others.
    const std::size_t sized = random->below(all + 1);
    std::vector<std::size_t> taken;  // by block
    std::string content = state.content;
    std::uint64_t size = content.size(), kept_size = size;
    const auto entries_of_block = [&](std::size_t number) {
      while (taken.size() <= number) {
        const std::size_t which = random->below(3);
        taken.push_back(which == 0 ? 0 : which == 1 ? all : random->below(all + 1));
      }
      return taken[number];
    };
    for (std::size_t i = 0; i < all; ++i) {
      const JournalEntry& entry = *state.pending[i];
      const bool is_write = entry.kind == JournalEntry::Kind::write;
      const std::uint64_t begin = entry.offset,
                          end = is_write ? begin + entry.bytes.size() : std::max<std::uint64_t>(content.size(), begin);
      if (content.size() < end) content.resize(end, '\0');
      for (std::uint64_t at = begin; at < end;) {
        const std::uint64_t piece_end = std::min(end, (at / block + 1) * block);
        if (entries_of_block(at / block) > i) {
          is_write ? content.replace(at, piece_end - at, entry.bytes, at - begin, piece_end - at)
                   : content.replace(at, piece_end - at, piece_end - at, '\0');
        }
        at = piece_end;
      }
      size = is_write ? std::max(size, end) : begin;
      if (i + 1 == sized) kept_size = size;
    }
    content.resize(kept_size, '\0');
    state.content = std::move(content);
  }

  States written_after(std::size_t entries) const {
    States states = states_after(entries);
    for (State& state : states) {
      for (const JournalEntry* entry : state.pending) apply(*entry, state);
    }
    return states;
  }

  std::optional<std::size_t> node_in_the_end(const std::string& path) const {
    const States states = written_after(journal_.entries.size());
    std::size_t node = 0;
    for (const auto& part : std::filesystem::path(path)) {
      const auto found = states[node].names.find(part.string());
      if (found == states[node].names.end()) return std::nullopt;
      node = found->second;
    }
    return node;
  }

  void add(const States& states, std::size_t folder, const std::string& path, FolderImage& image) const {
    for (const auto& [name, node] : states[folder].names) {
      const std::string child = path + name;
      const bool is_folder = journal_.nodes[node].is_folder;
      image[child] = is_folder ? std::nullopt : std::optional(states[node].content);
      if (is_folder) add(states, node, child + "/", image);
    }
  }

  const WrittenJournal& journal_;
};

}  // namespace tactile::test
