#include "tactile/labels/posterior/likely_touches.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/labels/posterior/run_model_numbers.hpp"

namespace tactile::labels {
namespace {

/// A stretch of one happening in a path, in bins.
struct Stretch {
  Happening happening;
  std::size_t begin, end;
};

std::vector<Stretch> stretches_of(const Path& path, const RunStates& states) {
  std::vector<Stretch> stretches;
  for (std::size_t b = 0; b < path.size(); ++b) {
    const Happening happening = states.happening_of(path[b]);
    if (stretches.empty() || stretches.back().happening != happening) stretches.push_back({happening, b, b});
    stretches.back().end = b + 1;
  }
  return stretches;
}

/// A press ends where its speed is below 1 % of its peak, as in the definition of its truth; a level is a factor of three.
std::size_t end_of_press(const Stretch& press, const Path& path, const DrawnPaths& drawn, const RunStates& states) {
  const auto level_at = [&](std::size_t b) { return motion_levels[states.level_of(path[b], drawn.conditions[b])]; };
  double peak = 0;
  for (std::size_t b = press.begin; b < press.end; ++b) peak = std::max(peak, level_at(b));
  std::size_t end = press.end;
  while (end > press.begin + 1 && level_at(end - 1) <= 0.02 * peak) --end;
  return end;
}

/// The presses and slips of each path. Slips with less than 150 ms between them are one slip that sticks.
std::vector<std::vector<Stretch>> touches_of_paths(const PathSample& sample) {
  const auto sticks = static_cast<std::size_t>(150ms / sample.bin);
  std::vector<std::vector<Stretch>> all;
  sample.for_all_paths([&](const Path& path, const DrawnPaths& drawn) {
    std::vector<Stretch>& touches = all.emplace_back();
    for (Stretch stretch : stretches_of(path, *sample.states)) {
      if (stretch.happening == Happening::press) stretch.end = end_of_press(stretch, path, drawn, *sample.states);
      if (stretch.happening != Happening::press && stretch.happening != Happening::slip) continue;
      const bool goes_on = !touches.empty() && stretch.happening == Happening::slip &&
                           touches.back().happening == Happening::slip && stretch.begin < touches.back().end + sticks;
      if (goes_on)
        touches.back().end = stretch.end;
      else
        touches.push_back(stretch);
    }
  });
  return all;
}

alignment::UncertainTime time_of(std::span<const double> bins, const PathSample& sample) {
  const auto at = [&](double share) {
    return after(sample.begin, microseconds{std::llround(quantile(bins, share) * static_cast<double>(sample.bin.count()))});
  };
  return {at(0.5), at(0.025), at(0.975)};
}

/// The last bin of the window with onsets in most paths.
std::size_t bin_of_most_onsets(const std::vector<std::vector<Stretch>>& of_paths, Happening happening, std::size_t window,
                               std::size_t bins) {
  std::vector<int> changes(bins + window + 1, 0);
  for (const std::vector<Stretch>& touches : of_paths) {
    std::size_t covered = 0;
    for (const Stretch& one : touches) {
      if (one.happening != happening) continue;
      ++changes[std::max(one.begin, covered)];
      --changes[covered = one.begin + window];
    }
  }
  std::partial_sum(changes.begin(), changes.end(), changes.begin());
  const auto most = std::max_element(changes.begin(), changes.end() - 1);
  const auto beyond = std::find_if(most, changes.end() - 1, [&](int count) { return count != *most; });
  return static_cast<std::size_t>(most - changes.begin()) + static_cast<std::size_t>(beyond - most - 1) / 2;
}

/// The touch of most paths: those of one class that begin within 100 ms. They leave `of_paths`, with all that begin within it.
std::optional<LikelyTouch> take_likeliest(std::vector<std::vector<Stretch>>& of_paths, Happening happening,
                                          const PathSample& sample) {
  constexpr double least = 0.05;
  const auto near = static_cast<std::size_t>(100ms / sample.bin);
  const double ms_in_bins = 1000.0 / static_cast<double>(sample.bin.count());
  const std::size_t most = bin_of_most_onsets(of_paths, happening, near, sample.bins);
  std::vector<double> starts, ends;
  Random random(2);
  for (const std::vector<Stretch>& touches : of_paths) {
    const auto first = std::find_if(touches.begin(), touches.end(), [&](const Stretch& one) {
      return one.happening == happening && one.begin + near > most && one.begin <= most;
    });
    if (first == touches.end()) continue;
    // A motion that is in a bin began somewhere in the one before, or in it.
    starts.push_back(static_cast<double>(first->begin) + random.uniform() - random.uniform());
    const double end = static_cast<double>(first->end) + numbers::end_known_ms * ms_in_bins * random.normal();
    ends.push_back(std::max(end, starts.back() + 1));
  }
  const double share = sample.share_of_path() * static_cast<double>(starts.size());
  if (share < least) return std::nullopt;
  const std::size_t from = most - std::min(most, 2 * near);
  const auto until = std::max(most + near, static_cast<std::size_t>(std::max(0.0, value_of_rank(ends, ends.size() / 2))));
  for (std::vector<Stretch>& touches : of_paths) {
    std::erase_if(touches,
                  [&](const Stretch& one) { return one.happening == happening && one.begin >= from && one.begin <= until; });
  }
  return LikelyTouch{happening == Happening::press ? Touch::press : Touch::slip, share, time_of(starts, sample),
                     time_of(ends, sample)};
}

/// Of the paths, those in which nothing touches the skin in some of these bins.
double share_untouched(const PathSample& sample, std::size_t begin, std::size_t end) {
  double share = 0;
  sample.for_all_paths([&, each = sample.share_of_path()](const Path& path, const DrawnPaths&) {
    const auto first = path.begin() + static_cast<std::ptrdiff_t>(begin), last = path.begin() + static_cast<std::ptrdiff_t>(end);
    const bool is_untouched =
        std::any_of(first, last, [&](std::uint16_t state) { return sample.states->happening_of(state) == Happening::untouched; });
    share += is_untouched ? each : 0;
  });
  return share;
}

}  // namespace

std::vector<LikelyTouch> likely_touches(const PathSample& sample) {
  std::vector<LikelyTouch> found;
  std::vector<std::vector<Stretch>> of_paths = touches_of_paths(sample);
  for (const Happening happening : {Happening::press, Happening::slip}) {
    while (const std::optional<LikelyTouch> touch = take_likeliest(of_paths, happening, sample)) found.push_back(*touch);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const LikelyTouch& a, const LikelyTouch& b) { return a.start.at < b.start.at; });
  return found;
}

bool are_alternatives(const LikelyTouch& a, const LikelyTouch& b) {
  constexpr double most = 1.05;  // shares of 400 paths
  constexpr microseconds same_onset = 100ms;
  return std::chrono::abs(between(a.start.at, b.start.at)) <= same_onset && a.probability + b.probability <= most;
}

bool is_likeliest(const LikelyTouch& touch, const std::vector<LikelyTouch>& all) {
  double of_any_class = 0;
  for (const LikelyTouch& other : all) {
    if (&other != &touch && !are_alternatives(other, touch)) continue;
    of_any_class += other.probability;
    if (other.probability > touch.probability || (other.probability == touch.probability && &other < &touch)) return false;
  }
  return of_any_class >= 0.5;
}

std::vector<TouchInterval> likely_releases(const PathSample& sample) {
  std::vector<double> probability(sample.bins, 0.0);
  sample.for_all_paths([&, each = sample.share_of_path()](const Path& path, const DrawnPaths&) {
    for (std::size_t b = 0; b < path.size(); ++b)
      probability[b] += sample.states->happening_of(path[b]) == Happening::release ? each : 0;
  });
  std::vector<TouchInterval> found;
  for (std::size_t b = 0; b < probability.size(); ++b) {
    if (probability[b] <= 0.5) continue;
    if (found.empty() || found.back().end != sample.begin_of(b))
      found.push_back({Touch::none, sample.begin_of(b), sample.begin_of(b)});
    found.back().end = sample.begin_of(b + 1);
  }
  return found;
}

std::vector<LikelyRest> likely_rests(const PathSample& sample) {
  std::vector<double> moves(sample.bins, 0.0), knocks(sample.bins, 0.0);
  sample.for_all_paths([&, each = sample.share_of_path()](const Path& path, const DrawnPaths&) {
    for (std::size_t b = 0; b < path.size(); ++b) {
      const Happening happening = sample.states->happening_of(path[b]);
      if (!has_motion(happening)) continue;
      const bool is_brief = happening == Happening::knock || happening == Happening::disturbance;
      (is_brief ? knocks : moves)[b] += each;
    }
  });
  std::vector<LikelyRest> rests;
  for (std::size_t begin = 0; begin < sample.bins;) {
    const auto is_moved = [](double p) { return p >= 0.5; };
    const auto from = [](std::vector<double>& of, std::size_t b) { return of.begin() + static_cast<std::ptrdiff_t>(b); };
    begin = static_cast<std::size_t>(std::find_if_not(from(moves, begin), moves.end(), is_moved) - moves.begin());
    const auto end = static_cast<std::size_t>(std::find_if(from(moves, begin), moves.end(), is_moved) - moves.begin());
    if (begin == end) break;
    std::size_t calm_begin = begin, calm_end = begin;
    for (std::size_t b = begin; b < end;) {
      const auto next = static_cast<std::size_t>(std::find_if(from(knocks, b), from(knocks, end), is_moved) - knocks.begin());
      if (next - b > calm_end - calm_begin) std::tie(calm_begin, calm_end) = std::pair(b, next);
      b = next + 1;
    }
    rests.push_back({.begin = sample.begin_of(begin),
                     .end = sample.begin_of(end),
                     .calm_begin = sample.begin_of(calm_begin),
                     .calm_end = sample.begin_of(calm_end),
                     .let_go = share_untouched(sample, begin, end),
                     .is_first = begin == 0,
                     .is_last = end == sample.bins});
    begin = end;
  }
  return rests;
}

}  // namespace tactile::labels
