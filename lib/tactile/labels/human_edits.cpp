#include "tactile/labels/human_edits.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <set>

namespace tactile {
namespace {

constexpr std::size_t no_index = static_cast<std::size_t>(-1);

bool is_a_persons(const LabelledInterval& interval) { return interval.confirmed || interval.source == "person"; }

/// How long both last at once; less than 0 if they do not meet.
microseconds overlap(const TouchInterval& a, const TouchInterval& b) {
  return between(std::max(a.start, b.start), std::min(a.end, b.end));
}

bool is_rejected(const LabelledInterval& interval, const std::vector<TouchInterval>& rejected) {
  return std::any_of(rejected.begin(), rejected.end(), [&](const TouchInterval& one) {
    return one.touch == interval.touch && overlap(one, interval.interval()) > 0us;
  });
}

void take_evidence(Evidence& evidence, const Evidence& fresh) {
  const auto take = [](std::optional<CameraTime>& old, const std::optional<CameraTime>& anew) {
    if (anew) old = anew;
  };
  take(evidence.events, fresh.events);
  take(evidence.robot, fresh.robot);
  take(evidence.video, fresh.video);
  take(evidence.imu, fresh.imu);
}

void end_at(LabelledInterval& interval, CameraTime t) {
  interval.end = {t, std::min(interval.end.low, t), std::min(interval.end.high, t)};
}

/// What is left of a fresh interval beside a person's.
enum class Remains : std::uint8_t { whole, cut_at_end, cut_at_start, nothing };

Remains beside(LabelledInterval& fresh, LabelledInterval& persons) {
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

/// An interval of the result, and where it comes from.
struct Kept {
  LabelledInterval interval = {};
  bool is_persons = false;
  std::string cut_by = {};  ///< the person's interval in which it had begun
};

bool was_confirmed(const LabelFlag& flag, const std::vector<Kept>& kept, const Labels& old) {
  return std::any_of(old.flags.begin(), old.flags.end(), [&](const LabelFlag& before) {
    if (!before.confirmed || before.reason != flag.reason || before.interval_index.has_value() != flag.interval_index.has_value())
      return false;
    if (!flag.interval_index) return true;
    const TouchInterval now = kept[*flag.interval_index].interval.interval(),
                        then = old.intervals[*before.interval_index].interval();
    return now.touch == then.touch && overlap(now, then) > 0us;
  });
}

}  // namespace

bool has_human_edits(const Labels& labels) {
  return !labels.rejected.empty() || std::any_of(labels.intervals.begin(), labels.intervals.end(), is_a_persons) ||
         std::any_of(labels.flags.begin(), labels.flags.end(), [](const LabelFlag& flag) { return flag.confirmed; });
}

Labels keep_human_edits(Labels fresh, const Labels& old) {
  std::vector<Kept> kept;
  for (const LabelledInterval& interval : old.intervals) {
    if (is_a_persons(interval)) kept.push_back({interval, true});
  }
  const std::size_t persons = kept.size();

  // Which of `kept` each fresh interval has become, for its flags.
  std::vector<std::size_t> became(fresh.intervals.size(), no_index);
  for (std::size_t i = 0; i < fresh.intervals.size(); ++i) {
    Kept candidate{fresh.intervals[i]};
    if (is_rejected(candidate.interval, old.rejected)) continue;
    bool stays = true;
    for (std::size_t p = 0; p < persons && stays; ++p) {
      LabelledInterval& person = kept[p].interval;
      const Remains remains = beside(candidate.interval, person);
      if (remains == Remains::cut_at_start) candidate.cut_by = person.id;
      if (remains != Remains::nothing) continue;
      stays = false;
      if (person.touch == candidate.interval.touch) {
        take_evidence(person.evidence, candidate.interval.evidence);
        became[i] = p;
      }
    }
    if (!stays) continue;
    became[i] = kept.size();
    kept.push_back(std::move(candidate));
  }

  std::vector<std::size_t> order(kept.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(kept[a].interval.start.at, kept[a].interval.end.at) <
           std::pair(kept[b].interval.start.at, kept[b].interval.end.at);
  });
  std::vector<std::size_t> place(kept.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;

  std::vector<LabelFlag> flags;
  for (LabelFlag& flag : fresh.flags) {
    if (flag.interval_index) {
      const std::size_t index = became[*flag.interval_index];
      if (index == no_index) continue;
      flag.interval_index = index;
      flag.confirmed = flag.confirmed || kept[index].is_persons;
    }
    flag.confirmed = flag.confirmed || was_confirmed(flag, kept, old);
    if (flag.interval_index) flag.interval_index = place[*flag.interval_index];
    flags.push_back(std::move(flag));
  }
  std::set<std::string> taken;
  for (std::size_t i = 0; i < persons; ++i) taken.insert(kept[i].interval.id);
  for (std::size_t i = persons; i < kept.size(); ++i) {
    if (!taken.insert(kept[i].interval.id).second) kept[i].interval.id.clear();
    if (kept[i].cut_by.empty()) continue;
    flags.push_back(
        {.interval_index = place[i],
         .reason = fmt::format("its onset was found within {}, which a person made: it is taken to begin where that ends",
                               kept[i].cut_by),
         .confirmed = false});
  }

  fresh.intervals.clear();
  for (const std::size_t i : order) fresh.intervals.push_back(std::move(kept[i].interval));
  name_intervals(fresh.intervals);
  fresh.flags = std::move(flags);
  for (const TouchInterval& one : old.rejected) fresh.rejected.push_back(one);
  return fresh;
}

}  // namespace tactile
