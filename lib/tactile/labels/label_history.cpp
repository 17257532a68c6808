#include "tactile/labels/label_history.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/utc_time.hpp"
#include "tactile/labels/human_edits.hpp"

namespace tactile::labels {
namespace {

auto values_of(const alignment::UncertainTime& time) { return std::tuple(time.at, time.low, time.high); }

bool same(const LabelledInterval& a, const LabelledInterval& b) {
  const auto values = [](const LabelledInterval& one) {
    return std::tuple(one.id, one.touch, values_of(one.start), values_of(one.end), one.source, one.confirmed, one.evidence.events,
                      one.evidence.robot, one.evidence.video, one.evidence.imu, one.probability, one.visible);
  };
  return values(a) == values(b);
}

bool same(const LabelFlag& a, const LabelFlag& b) {
  return std::tie(a.interval_index, a.reason, a.confirmed, a.key) == std::tie(b.interval_index, b.reason, b.confirmed, b.key);
}

bool same(const TouchInterval& a, const TouchInterval& b) {
  return std::tie(a.touch, a.start, a.end) == std::tie(b.touch, b.start, b.end);
}

template <class T>
ListChange<T> change_of(const std::vector<T>& before, const std::vector<T>& after) {
  std::size_t begin = 0, end = 0;
  const std::size_t shorter = std::min(before.size(), after.size());
  while (begin < shorter && same(before[begin], after[begin])) ++begin;
  while (end < shorter - begin && same(before[before.size() - 1 - end], after[after.size() - 1 - end])) ++end;
  const auto middle = [&](const std::vector<T>& list) {
    return std::vector<T>(list.begin() + static_cast<std::ptrdiff_t>(begin), list.end() - static_cast<std::ptrdiff_t>(end));
  };
  return {.at = begin, .removed = middle(before), .added = middle(after)};
}

LabelChange change_of(const Labels& before, const Labels& after) {
  return {.intervals = change_of(before.intervals, after.intervals),
          .flags = change_of(before.flags, after.flags),
          .rejected = change_of(before.rejected, after.rejected)};
}

/// Puts `now` where `then` must stand. @return whether it stood there
template <class T>
bool replace(std::vector<T>& list, std::size_t at, const std::vector<T>& then, const std::vector<T>& now) {
  if (at > list.size() || then.size() > list.size() - at) return false;
  const auto begin = list.begin() + static_cast<std::ptrdiff_t>(at);
  if (!std::equal(then.begin(), then.end(), begin, [](const T& a, const T& b) { return same(a, b); })) return false;
  const auto place = list.erase(begin, begin + static_cast<std::ptrdiff_t>(then.size()));
  list.insert(place, now.begin(), now.end());
  return true;
}

bool is_sound(const Labels& labels) {
  const auto overlaps = [](const LabelledInterval& a, const LabelledInterval& b) { return b.start.at < a.end.at; };
  return std::adjacent_find(labels.intervals.begin(), labels.intervals.end(), overlaps) == labels.intervals.end() &&
         std::all_of(labels.flags.begin(), labels.flags.end(), [&](const LabelFlag& flag) {
           return !flag.interval_index || *flag.interval_index < labels.intervals.size();
         });
}

enum class Direction : std::uint8_t { back, forth };

/// One edit back or forth; nothing if it does not fit the labels.
std::optional<Labels> stepped(Labels labels, const HistoryEntry& entry, Direction direction) {
  if (!entry.change) return std::nullopt;
  const auto step = [&](auto& list, const auto& change) {
    return direction == Direction::back ? replace(list, change.at, change.added, change.removed)
                                        : replace(list, change.at, change.removed, change.added);
  };
  const bool fits = step(labels.intervals, entry.change->intervals) && step(labels.flags, entry.change->flags) &&
                    step(labels.rejected, entry.change->rejected);
  if (!fits || !is_sound(labels)) return std::nullopt;
  return labels;
}

[[noreturn]] void throw_not_fitting(const HistoryEntry& entry, const char* what) {
  throw Error(
      fmt::format("'{}' ({}) cannot be {}, because another program changed labels.json since; expected labels as that edit "
                  "left them",
                  entry.what, entry.when, what));
}

std::string counted_edits(std::size_t count) { return count == 1 ? "1 edit" : fmt::format("{} edits", count); }

}  // namespace

Labels recorded(const Labels& before, Labels after, const EditNote& note, std::string what, std::string when) {
  after.history = before.history;
  std::vector<HistoryEntry>& entries = after.history.entries;
  entries.resize(entries.size() - after.history.undone);
  after.history.undone = 0;
  entries.push_back(
      {.who = note.who, .when = std::move(when), .what = std::move(what), .why = note.why, .change = change_of(before, after)});
  return after;
}

Labels undone(Labels labels, std::size_t count) {
  const std::size_t made = labels.history.entries.size() - labels.history.undone;
  if (count > made)
    throw Error(
        fmt::format("{} to undo, but only {} made; expected at most {}", counted_edits(count), counted_edits(made), made));
  for (; count > 0; --count) {
    const HistoryEntry entry = labels.history.entries[labels.history.entries.size() - labels.history.undone - 1];
    std::optional<Labels> earlier = stepped(labels, entry, Direction::back);
    if (!earlier) throw_not_fitting(entry, "undone");
    labels = std::move(*earlier);
    ++labels.history.undone;
  }
  return labels;
}

Labels redone(Labels labels, std::size_t count) {
  if (count > labels.history.undone) {
    throw Error(fmt::format("{} to redo, but only {} undone; expected at most {}", counted_edits(count),
                            counted_edits(labels.history.undone), labels.history.undone));
  }
  for (; count > 0; --count) {
    const HistoryEntry entry = labels.history.entries[labels.history.entries.size() - labels.history.undone];
    std::optional<Labels> later = stepped(labels, entry, Direction::forth);
    if (!later) throw_not_fitting(entry, "redone");
    labels = std::move(*later);
    --labels.history.undone;
  }
  return labels;
}

Labels relabelled(const Labels& fresh, const Labels& old) {
  const Labels result = keep_human_edits(fresh, old);
  EditHistory history = old.history;
  std::vector<HistoryEntry>& entries = history.entries;
  const std::size_t now = entries.size() - history.undone;
  // Every edit is made again between the new labels under the edits until it and with it.
  Labels bare = old;
  bare.history = {};
  Labels state = bare, under = result;
  for (std::size_t i = now; i-- > 0;) {
    std::optional<Labels> earlier = stepped(std::move(state), entries[i], Direction::back);
    if (!earlier) {
      for (std::size_t k = 0; k <= i; ++k) entries[k].change.reset();
      break;
    }
    state = std::move(*earlier);
    Labels below = keep_human_edits(fresh, state);
    entries[i].change = change_of(below, under);
    under = std::move(below);
  }
  state = bare;
  under = result;
  for (std::size_t i = now; i < entries.size(); ++i) {
    std::optional<Labels> later = stepped(std::move(state), entries[i], Direction::forth);
    if (!later) {
      for (std::size_t k = i; k < entries.size(); ++k) entries[k].change.reset();
      break;
    }
    state = std::move(*later);
    Labels above = keep_human_edits(fresh, state);
    entries[i].change = change_of(under, above);
    under = std::move(above);
  }
  Labels labels = result;
  labels.history = std::move(history);
  return labels;
}

Labels relabelled_without_edits(Labels fresh, const Labels& old, const EditNote& note) {
  if (!has_human_edits(old)) return fresh;
  return recorded(relabelled(fresh, old), fresh, note, "labelled again with --force, without the edits before", now_utc());
}

}  // namespace tactile::labels
