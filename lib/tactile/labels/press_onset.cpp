#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/infinite.hpp"
#include "tactile/labels/onset_scan.hpp"

namespace tactile::labels {
namespace {

/// Up to where the events above the quiet rate stand out clearly (Page's cumulative sum). Later events say nothing about the
/// start of a burst, but would distort the fit, since their counts are the largest.
/// @param from  the first bin that may be returned
std::size_t clear_by(Counts counts, double quiet, double dispersion, std::size_t from) {
  constexpr double sure = 40.0;  // events
  const double allowance = quiet + 0.5 * std::sqrt(dispersion * quiet);
  double excess = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    excess = std::max(0.0, excess + counts[i] - allowance);
    if (excess >= sure * dispersion && i >= from) return i + 1;
  }
  return counts.size();
}

/// The rate of what precedes an onset: the quiet one, unless every part of it has more. Markers that were moved by the touch
/// before have another noise, and tips may creep on. Then a standard deviation is added, since the least part is low by chance.
double rate_before(Counts counts, double quiet, std::size_t part) {
  double least = infinite;
  for (std::size_t i = 0; i + part <= counts.size(); i += part) {
    const Counts some = counts.subspan(i, part);
    least = std::min(least, std::accumulate(some.begin(), some.end(), 0.0));
  }
  const auto bins = static_cast<double>(part);
  return least < infinite && least > quiet * bins ? (least + std::sqrt(least)) / bins : quiet;
}

/// How much likelier this many events are at their own rate than at the expected; 0 where they are fewer.
double gain_of(double events, double expected) {
  return events > expected ? events * std::log(events / expected) - (events - expected) : 0.0;
}

/// Counts that may hold an earlier contact than the found one: of a place, or of all places.
struct Candidate {
  Counts counts;
  double quiet = 0, dispersion = 1;
  Sums sums;
};

/// A step of the rate before bin `until`, and how much likelier it is than none.
struct Step {
  Scan scan;
  double gain = 0;
};

/// @param from  not earlier than this
Step step_before(const Candidate& candidate, std::size_t from, std::size_t until) {
  // For an untouched place, the rate just before, if that is higher.
  double quiet = candidate.quiet;
  if (from > 0) quiet = std::max(quiet, candidate.sums.of(0, from) / static_cast<double>(from));
  std::vector<double> gain(until, -infinite);
  for (std::size_t tau = from; tau < until; ++tau) {
    const double events = candidate.sums.of(tau, until), expected = quiet * static_cast<double>(until - tau);
    gain[tau] = gain_of(events, expected);
  }
  const Scan scan = scan_of(gain, candidate.dispersion);
  return {.scan = scan, .gain = gain[scan.best] / candidate.dispersion};
}

/// Whether weaker contacts came before the one that was found. The noise of all markers hides one that is touched, its own noise
/// does not. Moves the scan to the earliest contact that is sure.
void look_before(Scan& scan, const std::vector<Candidate>& candidates, std::size_t reach) {
  // Among many places one shows a clump by chance more easily.
  const double among = std::log(static_cast<double>(candidates.size()));
  const double sure = 7.0 + among, likely = 4.0 + among;
  for (int earlier = 0; earlier < 8; ++earlier) {
    const std::size_t until = scan.low;
    if (until < 2) return;
    bool is_sure = false;
    Step most;
    std::size_t low = until;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Step step = step_before(candidates[i], i == 0 ? 0 : until - std::min(until, reach), until);
      if (step.gain < likely) continue;
      low = std::min(low, step.scan.low);
      if (step.gain < sure || step.gain <= most.gain) continue;
      is_sure = true;
      most = step;
    }
    if (!is_sure) {
      scan.low = low;
      return;
    }
    scan = most.scan;
  }
}

}  // namespace

FoundTime press_onset(const LitRate& lit, const OnsetOptions& options, std::optional<CameraTime> earliest) {
  const alignment::EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  std::size_t begin = lit.burst_begin - std::min(lit.burst_begin, bins(options.first_contact + options.before));
  if (earliest && *earliest > rate.begin_of(begin))
    begin = std::min(static_cast<std::size_t>(between(rate.begin, *earliest) / rate.bin), lit.burst_begin);
  const Counts all = Counts(rate.counts).subspan(begin);
  const std::size_t ahead = lit.burst_begin - begin;
  const double floor = half_event_per(all.size());
  const auto quiet_of = [&](Counts counts, double of_run) {
    return rate_before(counts.first(ahead), std::max(of_run, floor), 2 * bins(options.before));
  };
  const double quiet = quiet_of(all, lit.quiet_per_bin);
  const std::size_t end = clear_by(all, quiet, lit.dispersion, ahead - std::min(ahead, bins(options.first_contact)));
  const std::size_t from = end - std::min(end, bins(options.before) * 2);
  Scan scan = scan_of(rise_likelihoods(all.subspan(from, end - from), quiet), lit.dispersion);
  scan = {scan.best + from, scan.low + from, scan.high + from};

  std::vector<Candidate> candidates;
  candidates.push_back({all, quiet, lit.dispersion, Sums(all)});
  for (const LitPlace& place : lit.places) {
    const Counts counts = Counts(place.counts).subspan(begin);
    candidates.push_back({counts, quiet_of(counts, place.quiet_per_bin), place.dispersion, Sums(counts)});
  }
  look_before(scan, candidates, bins(options.before));

  // The place of the first events shows for how long its pixels were blind.
  Counts counts = rate.counts, repeats = lit.repeats;
  double most = 0;
  for (std::size_t i = 0; i < lit.places.size(); ++i) {
    const double gain =
        gain_of(candidates[i + 1].sums.of(scan.best, end), candidates[i + 1].quiet * static_cast<double>(end - scan.best));
    if (gain <= most) continue;
    most = gain;
    counts = lit.places[i].counts;
    repeats = lit.places[i].repeats;
  }
  return found_at(lit, {begin + scan.best, begin + scan.low, begin + scan.high}, counts, repeats, options.press_blind_share,
                  options);
}

}  // namespace tactile::labels
