#include "tactile/review/touched_places.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tactile::review {

TouchedPlaces::TouchedPlaces(events::SensorSize size, const labels::Labels& labels, CameraTime first, CameraTime last)
    : size_(size), cells_(size), quiet_(cells_.count()), touched_(cells_.count()) {
  // A touch may begin and end anywhere in the 95 % intervals of its ends, so that these are neither touch nor quiet.
  std::vector<std::pair<CameraTime, int>> turns;  // how many stretches of each kind begin or end here
  constexpr int touch = 1 << 16, doubt = 1;
  const auto add_stretch = [&](CameraTime begin, CameraTime end, int kind) {
    turns.emplace_back(begin, kind);
    turns.emplace_back(std::max(begin, end), -kind);
  };
  for (const labels::LabelledInterval& interval : labels.intervals) {
    add_stretch(interval.start.at, interval.end.at, touch);
    add_stretch(interval.start.low, interval.start.at, doubt);
    add_stretch(interval.end.at, interval.end.high, doubt);
  }
  for (const TouchInterval& release : labels.releases) add_stretch(release.start, release.end, doubt);
  std::sort(turns.begin(), turns.end());
  int open = 0;
  parts_.push_back({CameraTime::min(), Part::Kind::quiet});
  for (const auto& [at, kind] : turns) {
    open += kind;
    parts_.push_back({at, open >= touch ? Part::Kind::touched : open > 0 ? Part::Kind::neither : Part::Kind::quiet});
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const CameraTime begin = std::clamp(parts_[i].begin, first, last);
    const CameraTime end = i + 1 < parts_.size() ? std::clamp(parts_[i + 1].begin, first, last) : last;
    const double seconds = std::chrono::duration<double>(between(begin, end)).count();
    if (parts_[i].kind == Part::Kind::quiet) quiet_s_ += seconds;
    if (parts_[i].kind == Part::Kind::touched) touched_s_ += seconds;
  }
}

void TouchedPlaces::add(std::span<const events::Event> events) {
  auto part = parts_.begin();
  for (const events::Event& event : events) {
    if (!is_in(event)) continue;
    const auto holds = [&] { return part->begin <= event.t && (part + 1 == parts_.end() || event.t < (part + 1)->begin); };
    if (!holds())
      part =
          std::upper_bound(parts_.begin(), parts_.end(), event.t, [](CameraTime t, const Part& one) { return t < one.begin; }) -
          1;
    if (part->kind == Part::Kind::quiet) ++quiet_[cells_.at(event)];
    if (part->kind == Part::Kind::touched) ++touched_[cells_.at(event)];
  }
}

void TouchedPlaces::choose() {
  if (!(quiet_s_ > 0 && touched_s_ > 0)) return;
  struct Cell {
    std::size_t index;
    double rise, quiet;  // events per second
  };
  const double events = static_cast<double>(std::accumulate(quiet_.begin(), quiet_.end(), std::uint64_t{0}));
  // Half an event more: without any noise the mean would be no rate.
  const double mean = (events + 0.5) / static_cast<double>(cells_.count()) / quiet_s_;
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < cells_.count(); ++i) {
    const double quiet = std::max(mean, static_cast<double>(quiet_[i]) / quiet_s_);
    const double rise = static_cast<double>(touched_[i]) / touched_s_ - quiet;
    if (rise > 0) cells.push_back({i, rise, quiet});
  }
  std::stable_sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.rise * b.quiet > b.rise * a.quiet; });
  double rise = 0, quiet = 0;
  for (const Cell& cell : cells) {
    if (rise > 0 && (rise + cell.rise) / std::sqrt(quiet + cell.quiet) <= rise / std::sqrt(quiet)) break;
    if (chosen_.empty()) chosen_.resize(cells_.count());
    chosen_[cell.index] = true;
    rise += cell.rise;
    quiet += cell.quiet;
  }
}

}  // namespace tactile::review
