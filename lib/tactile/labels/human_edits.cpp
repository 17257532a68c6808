#include "tactile/labels/human_edits.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>

namespace tactile::labels {
namespace {

bool is_a_persons(const LabelledInterval& interval) { return interval.confirmed || interval.source == "person"; }

bool is_rejected(const LabelledInterval& interval, const std::vector<TouchInterval>& rejected) {
  return std::any_of(rejected.begin(), rejected.end(), [&](const TouchInterval& one) {
    return one.touch == interval.touch && overlap(one, interval.interval()) > 0us;
  });
}

void take_evidence(Evidence& evidence, const Evidence& fresh) {
  const auto take = [](std::optional<CameraTime>& old, const std::optional<CameraTime>& now) {
    if (now) old = now;
  };
  take(evidence.events, fresh.events);
  take(evidence.robot, fresh.robot);
  take(evidence.video, fresh.video);
  take(evidence.imu, fresh.imu);
}

void end_at(LabelledInterval& interval, CameraTime t) {
  interval.end = {t, std::min(interval.end.low, t), std::min(interval.end.high, t)};
}

/// What is left of a new interval where a person's overlaps it.
enum class Remains : std::uint8_t { whole, cut_at_end, cut_at_start, nothing };

Remains cut_by(LabelledInterval& fresh, LabelledInterval& persons) {
  if (fresh.start.at >= persons.end.at || persons.start.at >= fresh.end.at) return Remains::whole;
  const microseconds common = overlap(fresh.interval(), persons.interval());
  const microseconds length = between(fresh.start.at, fresh.end.at);
  if (fresh.touch == persons.touch || length <= 0us || common > length / 2) return Remains::nothing;
  if (fresh.start.at < persons.start.at) {
    end_at(fresh, persons.start.at);
    return Remains::cut_at_end;
  }
  const CameraTime begin = persons.end.at;
  fresh.start = {begin, std::min(fresh.start.low, begin), std::max(fresh.start.high, begin)};
  return Remains::cut_at_start;
}

/// Whether the person's interval was found as this one before it was moved, perhaps far away.
bool was_found_as(const LabelledInterval& fresh, const LabelledInterval& persons) {
  const std::optional<CameraTime>& found = persons.evidence.events;
  return fresh.touch == persons.touch && found && *found >= fresh.start.low && *found < fresh.end.at;
}

/// An interval of the result, and where it comes from.
struct Kept {
  LabelledInterval interval = {};
  bool is_persons = false;
  std::string begun_in = {};  ///< the person's interval in which it began
};

/// The intervals of the result, and where the new ones went.
struct Merged {
  std::vector<Kept> kept;  ///< a person's first
  std::size_t persons = 0;
  std::vector<std::optional<std::size_t>> became;  ///< of each new interval: its place in `kept`

  /// `kept` by time, as indices.
  std::vector<std::size_t> order() const {
    std::vector<std::size_t> order(kept.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(kept[a].interval.start.at, kept[a].interval.end.at) <
             std::pair(kept[b].interval.start.at, kept[b].interval.end.at);
    });
    return order;
  }
};

Merged merge(const Labels& fresh, const Labels& old) {
  Merged merged;
  std::vector<Kept>& kept = merged.kept;
  for (const LabelledInterval& interval : old.intervals) {
    if (is_a_persons(interval)) kept.push_back({interval, true});
  }
  merged.persons = kept.size();
  for (const LabelledInterval& interval : fresh.intervals) {
    std::optional<std::size_t>& became = merged.became.emplace_back();
    Kept candidate{interval};
    if (is_rejected(candidate.interval, old.rejected)) continue;
    bool stays = true;
    for (std::size_t i = 0; i < merged.persons && stays; ++i) {
      LabelledInterval& person = kept[i].interval;
      const Remains remains = was_found_as(candidate.interval, person) ? Remains::nothing : cut_by(candidate.interval, person);
      if (remains == Remains::cut_at_start) candidate.begun_in = person.id;
      if (remains != Remains::nothing) continue;
      stays = false;
      if (person.touch != candidate.interval.touch) continue;
      take_evidence(person.evidence, candidate.interval.evidence);
      if (person.source != "person") {
        person.probability = candidate.interval.probability;
        person.visible = candidate.interval.visible;
      }
      became = i;
    }
    if (!stays) continue;
    became = kept.size();
    kept.push_back(std::move(candidate));
  }
  return merged;
}

bool was_confirmed(const LabelFlag& flag, const std::vector<Kept>& kept, const Labels& old) {
  return std::any_of(old.flags.begin(), old.flags.end(), [&](const LabelFlag& before) {
    // Older versions wrote no keys.
    const bool is_same = before.key.empty() ? before.reason == flag.reason : before.key == flag.key;
    if (!before.confirmed || !is_same || before.interval_index.has_value() != flag.interval_index.has_value()) return false;
    if (!flag.interval_index) return true;
    const TouchInterval now = kept[*flag.interval_index].interval.interval(),
                        then = old.intervals[*before.interval_index].interval();
    return now.touch == then.touch && overlap(now, then) > 0us;
  });
}

/// The flags of the new labels that still hold. @param place  in time, of each of the merged intervals
std::vector<LabelFlag> merged_flags(std::vector<LabelFlag> fresh, const Merged& merged, const std::vector<std::size_t>& place,
                                    const Labels& old) {
  std::vector<LabelFlag> flags;
  for (LabelFlag& flag : fresh) {
    if (flag.interval_index) {
      flag.interval_index = merged.became[*flag.interval_index];
      if (!flag.interval_index) continue;
      flag.confirmed = flag.confirmed || merged.kept[*flag.interval_index].is_persons;
    }
    flag.confirmed = flag.confirmed || was_confirmed(flag, merged.kept, old);
    if (flag.interval_index) flag.interval_index = place[*flag.interval_index];
    flags.push_back(std::move(flag));
  }
  for (std::size_t i = merged.persons; i < merged.kept.size(); ++i) {
    if (merged.kept[i].begun_in.empty()) continue;
    flags.push_back(
        flag_of(doubt("onset-in-persons", "its onset was found within {}, which a person made: it begins where that ends",
                      merged.kept[i].begun_in),
                place[i]));
  }
  return flags;
}

}  // namespace

bool has_human_edits(const Labels& labels) {
  return !labels.rejected.empty() || std::any_of(labels.intervals.begin(), labels.intervals.end(), is_a_persons) ||
         std::any_of(labels.flags.begin(), labels.flags.end(), [](const LabelFlag& flag) { return flag.confirmed; });
}

Labels keep_human_edits(Labels fresh, const Labels& old) {
  Merged merged = merge(fresh, old);
  std::set<std::string> taken;
  for (std::size_t i = 0; i < merged.kept.size(); ++i) {
    const bool is_new = taken.insert(merged.kept[i].interval.id).second;
    if (!is_new && i >= merged.persons) merged.kept[i].interval.id.clear();
  }
  const std::vector<std::size_t> order = merged.order();
  std::vector<std::size_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  fresh.flags = merged_flags(std::move(fresh.flags), merged, place, old);
  fresh.intervals.clear();
  for (const std::size_t i : order) fresh.intervals.push_back(std::move(merged.kept[i].interval));
  name_intervals(fresh.intervals);
  fresh.rejected.insert(fresh.rejected.end(), old.rejected.begin(), old.rejected.end());
  return fresh;
}

}  // namespace tactile::labels
