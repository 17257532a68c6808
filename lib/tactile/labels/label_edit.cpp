#include "tactile/labels/label_edit.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/labels/edited_intervals.hpp"
#include "tactile/labels/exchange/import_edits.hpp"

namespace tactile::labels {
namespace {

std::size_t index_of(const Labels& labels, const std::string& id) {
  const auto found = std::find_if(labels.intervals.begin(), labels.intervals.end(),
                                  [&](const LabelledInterval& interval) { return interval.id == id; });
  if (found != labels.intervals.end()) return static_cast<std::size_t>(found - labels.intervals.begin());
  std::vector<std::string> ids;
  for (const LabelledInterval& interval : labels.intervals) ids.push_back(interval.id);
  throw Error(ids.empty() ? fmt::format("interval {}: there is none; expected --add, the run has no intervals", shown_text(id))
                          : fmt::format("interval {}: there is none; expected {}", shown_text(id), fmt::join(ids, ", ")));
}

const LabelFlag& flag_at(const Labels& labels, std::size_t index) {
  if (index < labels.flags.size()) return labels.flags[index];
  throw Error(fmt::format("flag {}: the run has {}; expected one of them", index + 1, labels.flags.size()));
}

std::string seconds(CameraTime t, const RecordingSpan& recording) { return seconds_text(between(recording.first, t).count()); }

alignment::UncertainTime seen_at(CameraTime t, microseconds within) { return {t, before(t, within), after(t, within)}; }

void check_touch(Touch touch) {
  if (touch == Touch::none) throw Error("class none: is the time between intervals; expected press or slip");
}

void check_place(const LabelledInterval& interval, const std::string& name, const RecordingSpan& recording) {
  for (const auto& [what, t] : {std::pair("starts", interval.start.at), std::pair("ends", interval.end.at)}) {
    if (t < recording.first || t > recording.last) {
      throw Error(fmt::format("{} {} at {} s, outside the recording; expected 0 s to {} s", name, what, seconds(t, recording),
                              seconds(recording.last, recording)));
    }
  }
  if (interval.start.at >= interval.end.at) {
    throw Error(fmt::format("{} starts at {} s and ends at {} s; expected its end after its start", name,
                            seconds(interval.start.at, recording), seconds(interval.end.at, recording)));
  }
}

void make_persons(LabelledInterval& interval) {
  interval.source = "person";
  interval.confirmed = true;
  interval.probability.reset();
}

/// The intervals with one that was placed, at `index`, in order.
/// @param is_new  it was added; else it was there before
Labels with_placed(Labels labels, std::vector<LabelledInterval> intervals, std::size_t index, bool end_earlier,
                   const RecordingSpan& recording) {
  const std::string name =
      intervals[index].id.empty() ? "a new " + std::string(name_of(intervals[index].touch)) : intervals[index].id;
  check_place(intervals[index], name, recording);
  std::vector<std::size_t> order(intervals.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return intervals[a].start.at < intervals[b].start.at; });
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    LabelledInterval& other = intervals[i];
    if (i == index || overlap(other.interval(), intervals[index].interval()) <= 0us) continue;
    const CameraTime start = intervals[index].start.at;
    if (end_earlier && other.start.at < start && other.end.at <= intervals[index].end.at) {
      other.end = {start, std::min(other.end.low, start), std::max(start, std::min(other.end.high, start))};
      other.confirmed = true;
      continue;
    }
    throw Error(
        fmt::format("{} from {} s to {} s would overlap {} from {} s to {} s; expected a place that is free{}", name,
                    seconds(start, recording), seconds(intervals[index].end.at, recording), other.id,
                    seconds(other.start.at, recording), seconds(other.end.at, recording),
                    other.start.at < start && !end_earlier ? fmt::format(", once the end of {} is moved", other.id) : ""));
  }
  std::vector<LabelledInterval> sorted;
  std::vector<std::size_t> new_index(labels.intervals.size(), no_interval);
  for (const std::size_t i : order) {
    if (i < new_index.size()) new_index[i] = sorted.size();
    sorted.push_back(std::move(intervals[i]));
  }
  return with_intervals(std::move(labels), std::move(sorted), new_index);
}

struct Editor {
  Labels labels;
  const RecordingSpan& recording;

  Labels operator()(const MoveEnd& edit) {
    const std::size_t index = index_of(labels, edit.id);
    std::vector<LabelledInterval> intervals = labels.intervals;
    alignment::UncertainTime& end = edit.which == IntervalEnd::start ? intervals[index].start : intervals[index].end;
    end = seen_at(edit.to, std::max(edit.within, microseconds{1}));
    if (edit.which == IntervalEnd::start) intervals[index].visible.reset();
    make_persons(intervals[index]);
    return with_placed(std::move(labels), std::move(intervals), index, edit.end_earlier, recording);
  }

  Labels operator()(const AddInterval& edit) {
    check_touch(edit.touch);
    std::vector<LabelledInterval> intervals = labels.intervals;
    const microseconds within = std::max(edit.within, microseconds{1});
    LabelledInterval added{.touch = edit.touch,
                           .start = seen_at(edit.start, within),
                           .end = seen_at(edit.end, within),
                           .source = {},
                           .evidence = {}};
    make_persons(added);
    intervals.push_back(std::move(added));
    const std::size_t index = intervals.size() - 1;
    return with_placed(std::move(labels), std::move(intervals), index, edit.end_earlier, recording);
  }

  Labels operator()(const RejectInterval& edit) {
    const std::size_t index = index_of(labels, edit.id);
    std::vector<LabelledInterval> intervals = labels.intervals;
    std::vector<std::size_t> new_index(intervals.size());
    std::iota(new_index.begin(), new_index.end(), 0);
    for (std::size_t i = index; i < new_index.size(); ++i) new_index[i] = i == index ? no_interval : i - 1;
    intervals.erase(intervals.begin() + static_cast<std::ptrdiff_t>(index));
    return with_intervals(std::move(labels), std::move(intervals), new_index);
  }

  Labels operator()(const ChangeClass& edit) {
    check_touch(edit.touch);
    const std::size_t index = index_of(labels, edit.id);
    std::vector<LabelledInterval> intervals = labels.intervals;
    if (intervals[index].touch == edit.touch)
      throw Error(fmt::format("{} is a {} already; expected another class", edit.id, name_of(edit.touch)));
    intervals[index].touch = edit.touch;
    make_persons(intervals[index]);
    return with_placed(std::move(labels), std::move(intervals), index, false, recording);
  }

  Labels operator()(const ConfirmInterval& edit) {
    const std::size_t index = index_of(labels, edit.id);
    labels.intervals[index].confirmed = true;
    for (LabelFlag& flag : labels.flags) flag.confirmed = flag.confirmed || flag.interval_index == index;
    return std::move(labels);
  }

  Labels operator()(const ConfirmRun&) {
    for (LabelledInterval& interval : labels.intervals) interval.confirmed = true;
    for (LabelFlag& flag : labels.flags) flag.confirmed = true;
    return std::move(labels);
  }

  Labels operator()(const LiftFlag& edit) {
    static_cast<void>(flag_at(labels, edit.flag_index));
    labels.flags[edit.flag_index].confirmed = true;
    return std::move(labels);
  }

  Labels operator()(const ImportFile& edit) {
    EditCounts counts;
    return with_edits(std::move(labels), edit.labels, edit.times, recording.first, recording.last, counts);
  }
};

struct Words {
  const Labels& labels;
  const RecordingSpan& recording;

  const LabelledInterval& interval(const std::string& id) const { return labels.intervals[index_of(labels, id)]; }

  std::string operator()(const MoveEnd& edit) const {
    const bool is_start = edit.which == IntervalEnd::start;
    const CameraTime from = is_start ? interval(edit.id).start.at : interval(edit.id).end.at;
    return fmt::format("{} of {} from {} s to {} s", is_start ? "start" : "end", edit.id, seconds(from, recording),
                       seconds(edit.to, recording));
  }
  std::string operator()(const AddInterval& edit) const {
    return fmt::format("{} added from {} s to {} s", name_of(edit.touch), seconds(edit.start, recording),
                       seconds(edit.end, recording));
  }
  std::string operator()(const RejectInterval& edit) const {
    const LabelledInterval& gone = interval(edit.id);
    return fmt::format("{} rejected, from {} s to {} s", edit.id, seconds(gone.start.at, recording),
                       seconds(gone.end.at, recording));
  }
  std::string operator()(const ChangeClass& edit) const {
    return fmt::format("class of {} from {} to {}", edit.id, name_of(interval(edit.id).touch), name_of(edit.touch));
  }
  std::string operator()(const ConfirmInterval& edit) const { return edit.id + " confirmed"; }
  std::string operator()(const ConfirmRun&) const { return "run confirmed"; }
  std::string operator()(const LiftFlag& edit) const { return "flag lifted: " + flag_at(labels, edit.flag_index).reason; }
  std::string operator()(const ImportFile& edit) const {
    EditCounts counts;
    with_edits(labels, edit.labels, edit.times, recording.first, recording.last, counts);
    return fmt::format("{} imported: {} confirmed, {} moved, {} added, {} rejected", edit.labels.where, counts.confirmed,
                       counts.moved, counts.added, counts.rejected);
  }
};

}  // namespace

Labels with_edit(Labels labels, const LabelEdit& edit, const RecordingSpan& recording) {
  return std::visit(Editor{std::move(labels), recording}, edit);
}

std::string words_of(const LabelEdit& edit, const Labels& before, const RecordingSpan& recording) {
  return std::visit(Words{before, recording}, edit);
}

std::vector<std::string> words_of_changes(const Labels& before, const Labels& after, const RecordingSpan& recording) {
  const auto with_id = [](const Labels& labels, const std::string& id) {
    return std::find_if(labels.intervals.begin(), labels.intervals.end(),
                        [&](const LabelledInterval& interval) { return interval.id == id; });
  };
  std::vector<std::string> words;
  const auto add = [&](const LabelEdit& edit) { words.push_back(words_of(edit, before, recording)); };
  for (const LabelledInterval& then : before.intervals) {
    const auto now = with_id(after, then.id);
    if (now == after.intervals.end()) {
      add(RejectInterval{then.id});
      continue;
    }
    const std::size_t known = words.size();
    if (now->start.at != then.start.at) add(MoveEnd{.id = then.id, .which = IntervalEnd::start, .to = now->start.at});
    if (now->end.at != then.end.at) add(MoveEnd{.id = then.id, .which = IntervalEnd::end, .to = now->end.at});
    if (now->touch != then.touch) add(ChangeClass{.id = then.id, .touch = now->touch});
    if (words.size() == known && now->confirmed && !then.confirmed) add(ConfirmInterval{then.id});
  }
  for (const LabelledInterval& now : after.intervals) {
    if (with_id(before, now.id) == before.intervals.end())
      add(AddInterval{.touch = now.touch, .start = now.start.at, .end = now.end.at});
  }
  return words;
}

CameraTime nearest_tick(CameraTime t, microseconds tick) {
  if (tick <= 0us) throw Error(fmt::format("a tick of {} us; expected one above 0", tick.count()));
  const CameraTime next = first_tick_from(t, tick), last = last_tick_until(t, tick);
  return between(last, t) <= between(t, next) ? last : next;
}

std::optional<CameraTime> nearest_event(CameraTime t, std::span<const CameraTime> events) {
  if (events.empty()) return std::nullopt;
  const auto next = std::lower_bound(events.begin(), events.end(), t);
  if (next == events.begin()) return events.front();
  if (next == events.end() || between(*(next - 1), t) <= between(t, *next)) return *(next - 1);
  return *next;
}

}  // namespace tactile::labels
