#include "tactile/labels/exchange/import_edits.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <span>

#include "tactile/core/error.hpp"
#include "tactile/labels/edited_intervals.hpp"

namespace tactile::labels {
namespace {

constexpr std::size_t nothing = no_interval;

bool differs(std::int64_t a, std::int64_t b, std::int64_t most) {
  return std::max(saturating_subtract(a, b), saturating_subtract(b, a)) > most;
}

/// An imported interval that will be a label.
struct Placed {
  LabelledInterval interval = {};
  std::size_t old_index = nothing;
  bool start_moved = false, end_moved = false, changed = false;
  std::int64_t start_rounding_us = 0, end_rounding_us = 0;
};

std::string name_in_file(const ImportedInterval& imported) {
  return fmt::format("{}: {}", imported.where, imported.id.empty() ? std::string(name_of(imported.touch)) : imported.id);
}

class Edits {
 public:
  Edits(const Labels& labels, const ImportedLabels& imported, const FileTimes& times, CameraTime first_event,
        CameraTime last_event)
      : old_(labels.intervals),
        imported_(imported.intervals),
        clock_(times.to_camera(first_event)),
        counts_from_film_(times.origin == TimeOrigin::video),
        film_(labels.video_clock),
        first_(first_event),
        last_(last_event),
        claimed_(old_.size(), false),
        old_of_(imported_.size(), nothing) {}

  /// For each imported interval its former index, or `nothing`.
  const std::vector<std::size_t>& match() {
    std::map<std::string, std::size_t> by_id;
    for (std::size_t i = 0; i < old_.size(); ++i) by_id.emplace(old_[i].id, i);
    for (std::size_t i = 0; i < imported_.size(); ++i) {
      const auto found = by_id.find(imported_[i].id);
      if (found == by_id.end()) continue;
      if (claimed_[found->second])
        throw Error(fmt::format("{}: occurs twice; expected a different id for each, or none", name_in_file(imported_[i])));
      claim(i, found->second);
    }
    match_others([&](const ImportedInterval& imported, const LabelledInterval& old) {
      return !start_differs(imported, old) && !end_differs(imported, old);
    });
    match_others([&](const ImportedInterval& imported, const LabelledInterval& old) {
      return overlap({imported.touch, clock_.camera_from(imported.start_us), clock_.camera_from(imported.end_us)},
                     old.interval()) > 0us;
    });
    return old_of_;
  }

  Placed place(std::size_t i) const {
    const ImportedInterval& imported = imported_[i];
    Placed placed{
        .old_index = old_of_[i], .start_rounding_us = imported.start_rounding_us, .end_rounding_us = imported.end_rounding_us};
    const bool is_new = placed.old_index == nothing;
    if (!is_new) placed.interval = old_[placed.old_index];
    placed.start_moved = is_new || start_differs(imported, placed.interval);
    placed.end_moved = is_new || end_differs(imported, placed.interval);
    placed.changed = placed.start_moved || placed.end_moved || imported.touch != placed.interval.touch;
    if (placed.start_moved || placed.end_moved) check_length(imported);
    placed.interval.touch = imported.touch;
    if (placed.start_moved) placed.interval.start = moved(imported, imported.start_us, imported.start_rounding_us, "starts");
    if (placed.end_moved) placed.interval.end = moved(imported, imported.end_us, imported.end_rounding_us, "ends");
    if (placed.changed) placed.interval.source = "person";
    if (placed.changed || imported.confirmed) placed.interval.confirmed = true;
    return placed;
  }

 private:
  void claim(std::size_t imported_index, std::size_t old_index) {
    claimed_[old_index] = true;
    old_of_[imported_index] = old_index;
  }

  void match_others(const std::function<bool(const ImportedInterval&, const LabelledInterval&)>& belong_together) {
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < old_.size(); ++i) {
      if (!claimed_[i]) free.push_back(i);
    }
    for (std::size_t i = 0; i < imported_.size() && !free.empty(); ++i) {
      if (old_of_[i] != nothing) continue;
      const auto found = std::find_if(free.begin(), free.end(), [&](std::size_t old_index) {
        return old_[old_index].touch == imported_[i].touch && belong_together(imported_[i], old_[old_index]);
      });
      if (found == free.end()) continue;
      claim(i, *found);
      free.erase(found);
    }
  }

  bool start_differs(const ImportedInterval& imported, const LabelledInterval& old) const {
    return differs(imported.start_us, clock_.clock_us_from(old.start.at), imported.start_rounding_us);
  }
  bool end_differs(const ImportedInterval& imported, const LabelledInterval& old) const {
    return differs(imported.end_us, clock_.clock_us_from(old.end.at), imported.end_rounding_us);
  }

  static void check_length(const ImportedInterval& imported) {
    if (imported.end_us == imported.start_us) {
      throw Error(fmt::format("{} at {} s has no length; expected an end after its start", name_in_file(imported),
                              seconds_text(imported.start_us)));
    }
    if (imported.end_us < imported.start_us) {
      throw Error(fmt::format("{} starts at {} s and ends at {} s; expected its end after its start", name_in_file(imported),
                              seconds_text(imported.start_us), seconds_text(imported.end_us)));
    }
  }

  alignment::UncertainTime moved(const ImportedInterval& imported, std::int64_t us, std::int64_t rounding_us,
                                 const char* what) const {
    const CameraTime t = clock_.camera_from(us);
    const microseconds rounding{rounding_us};
    if (t < before(first_, rounding) || t > after(last_, rounding)) {
      throw Error(fmt::format("{} {} at {} s, outside the recording; expected {} s to {} s", name_in_file(imported), what,
                              seconds_text(us), seconds_text(clock_.clock_us_from(first_)),
                              seconds_text(clock_.clock_us_from(last_))));
    }
    const CameraTime at = std::clamp(t, first_, last_);
    const microseconds within = counts_from_film_ ? within_on_film(imported, at, rounding_us) : rounding;
    return {at, before(at, within), after(at, within)};
  }

  /// A film shows no time better than its clock is known.
  microseconds within_on_film(const ImportedInterval& imported, CameraTime t, std::int64_t rounding_us) const {
    if (!film_) {
      throw Error(
          fmt::format("{} is moved or new, in times of the film, but the run's video clock is unknown; expected times of "
                      "the origin first-event or camera",
                      name_in_file(imported)));
    }
    return microseconds{
        std::llround(std::hypot(static_cast<double>(rounding_us), static_cast<double>(film_->uncertainty_at(t).count())))};
  }

  const std::vector<LabelledInterval>& old_;
  const std::vector<ImportedInterval>& imported_;
  ClockRelation clock_;
  bool counts_from_film_;
  const std::optional<alignment::FittedClock>& film_;
  CameraTime first_, last_;
  std::vector<bool> claimed_;
  std::vector<std::size_t> old_of_;
};

void put_at(alignment::UncertainTime& time, CameraTime t) { time = {t, std::min(time.low, t), std::max(time.high, t)}; }

/// Closes overlaps of neighbours that are due to the tool's rounding: the edited end is moved to the exact one.
void make_neighbours_meet(std::vector<Placed>& placed, const std::string& file) {
  for (std::size_t i = 0; i + 1 < placed.size(); ++i) {
    Placed& one = placed[i];
    Placed& next = placed[i + 1];
    const microseconds excess = between(next.interval.start.at, one.interval.end.at);
    if (excess <= 0us) continue;
    const bool is_rounding = excess.count() <= std::max(one.end_rounding_us, next.start_rounding_us);
    const bool can_meet = is_rounding && (one.end_moved ? one.interval.start.at < next.interval.start.at
                                                        : next.start_moved && one.interval.end.at < next.interval.end.at);
    if (!can_meet) {
      throw Error(fmt::format("{}: {} and {} overlap by {} s; expected intervals without overlap", file,
                              one.interval.id.empty() ? "a new " + std::string(name_of(one.interval.touch)) : one.interval.id,
                              next.interval.id.empty() ? "a new " + std::string(name_of(next.interval.touch)) : next.interval.id,
                              seconds_text(excess.count())));
    }
    if (one.end_moved) {
      put_at(one.interval.end, next.interval.start.at);
    } else {
      put_at(next.interval.start, one.interval.end.at);
    }
  }
}

}  // namespace

Labels with_edits(Labels labels, const ImportedLabels& imported, const FileTimes& times, CameraTime first_event,
                  CameraTime last_event, EditCounts& counts) {
  if (!imported.looked_at) {
    counts = {.kept = labels.intervals.size()};
    return labels;
  }
  counts = {};
  Edits edits(labels, imported, times, first_event, last_event);
  edits.match();
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < imported.intervals.size(); ++i) placed.push_back(edits.place(i));
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return std::pair(a.interval.start.at, a.interval.end.at) < std::pair(b.interval.start.at, b.interval.end.at);
  });
  make_neighbours_meet(placed, imported.where);

  std::vector<LabelledInterval> intervals;
  std::vector<std::size_t> new_index(labels.intervals.size(), nothing);
  for (Placed& one : placed) {
    const bool was_confirmed = one.old_index != nothing && labels.intervals[one.old_index].confirmed;
    if (one.old_index == nothing) {
      ++counts.added;
    } else {
      new_index[one.old_index] = intervals.size();
      if (one.changed) {
        ++counts.moved;
      } else {
        ++counts.kept;
        counts.confirmed += one.interval.confirmed && !was_confirmed ? 1 : 0;
      }
    }
    intervals.push_back(std::move(one.interval));
  }
  counts.rejected = static_cast<std::size_t>(std::count(new_index.begin(), new_index.end(), nothing));
  return with_intervals(std::move(labels), std::move(intervals), new_index);
}

}  // namespace tactile::labels
