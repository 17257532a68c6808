#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tactile/labels/labelled_interval.hpp"

namespace tactile::labels {

/// What differs between two lists: from place `at` on, `removed` stood where `added` stands now.
template <class T>
struct ListChange {
  std::size_t at = 0;
  std::vector<T> removed, added;
};

/// What an edit replaced. Exact both ways, so that it can be undone and redone.
struct LabelChange {
  ListChange<LabelledInterval> intervals;
  ListChange<LabelFlag> flags;
  ListChange<TouchInterval> rejected;
};

/// One edit of a person.
struct HistoryEntry {
  std::string who;
  std::string when;                   ///< UTC, "2024-05-31T12:00:00.000000Z"
  std::string what;                   ///< in words: "start of press-1 from 1.230100 s to 1.234500 s"
  std::string why;                    ///< may be empty
  std::optional<LabelChange> change;  ///< nothing: it cannot be undone, because another program changed the labels since
};

/// All edits, the oldest first. The last `undone` are undone; they can be redone until another edit is made.
struct EditHistory {
  std::vector<HistoryEntry> entries;
  std::size_t undone = 0;
};

/// A labels.json with more is refused.
inline constexpr std::size_t most_history_entries = 50'000;

}  // namespace tactile::labels
